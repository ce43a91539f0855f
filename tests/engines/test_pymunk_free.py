"""Free and torque-driven motion in pymunk against the exact one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pymunk
import pytest
from free_machines import SWINGING_FOUR_BAR, SWINGING_SLIDER_CRANK, chain, energy_drift, exact, pose_error

from conrod.engines import engine_named
from conrod.engines.pymunk import free_run as own
from conrod.engines.pymunk import settings
from conrod.engines.pymunk.built import Build
from conrod.engines.pymunk.loads import Pushes
from conrod.engines.tracks import FreeRun, Pace
from conrod.exact.dynamics.forward import FreeMotion
from conrod.mechanism.loads import Displacement, Distance, Elastic, Friction, Load, SpeedLine, TimePulse, Turn, Viscous
from conrod.mechanism.mechanism import GROUND, Mechanism
from conrod.runs.trajectory import Outcome

PYMUNK: Any = engine_named("pymunk")
PACE = Pace(1.0)  # no rule of pymunk's asks for it
REFINED = (2e-3, 1e-3, 5e-4)  # steps [s]

Swing = tuple[FreeRun, FreeMotion]


def swing(mechanism: Mechanism, h: float, seconds: float, rate: float = 0.0, preset: str = "tuned") -> Swing:
    """A run told at about 250 instants, with the exact motion at these."""
    steps = round(seconds / h)
    every = max(1, steps // 250)
    right = exact(mechanism, h, steps, rate, every)
    return PYMUNK.free_run(mechanism, preset, h, steps, right.poses[0], right.rates[0], PACE, every), right


def orders(errors: list[float]) -> list[float]:
    return [float(np.log2(a / b)) for a, b in pairwise(errors)]


def pose_errors(mechanism: Mechanism, rate: float = 0.0, seconds: float = 1.0) -> list[float]:
    return [pose_error(*swing(mechanism, h, seconds, rate)) for h in REFINED]


def test_the_free_swing_of_a_four_bar_has_order_two() -> None:
    errors = pose_errors(SWINGING_FOUR_BAR)
    assert errors[-1] < 1e-3
    assert min(orders(errors)) > 1.8


def test_a_four_bar_swings_for_ten_seconds_within_a_thousandth() -> None:
    runs = [swing(SWINGING_FOUR_BAR, h, 10.0) for h in (1.25e-3, 6.25e-4)]
    assert [run.outcome for run, _ in runs] == [Outcome.COMPLETED] * 2
    assert pose_error(*runs[-1]) < 5e-4
    drifts = [energy_drift(run, right) for run, right in runs]
    assert drifts[-1] < 1e-4
    assert orders(drifts)[0] == pytest.approx(2.2, abs=0.3)


@pytest.mark.slow
def test_at_the_change_points_of_the_chain_the_iteration_not_the_step_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    """With all bars in line its four-bars are redundant, and the iteration slow: it is left on the way at each step."""
    mechanism, h = chain(2), 6.25e-4
    steps = round(3.0 / h)
    right = exact(mechanism, h, steps, 1.0, 50)
    errors = []
    for iterations in (160, 1280):
        monkeypatch.setattr(settings, "iterations_by_masses", lambda _, iterations=iterations: iterations)
        run = PYMUNK.free_run(mechanism, "tuned", h, steps, right.poses[0], right.rates[0], PACE, 50)
        errors.append(pose_error(run, right))
    assert errors[1] < 0.5 * errors[0]


def anchored(*laws: Any) -> Mechanism:
    """The slider-crank with laws between the rod and the ground."""
    along = Distance(GROUND, "rod", (0.2, 0.3), (0.05, 0.0))
    loads = tuple(Load(f"load {k}", along, law) for k, law in enumerate(laws))
    return replace(SWINGING_SLIDER_CRANK, loads=loads)


SPRING, DAMPER = Elastic(20.0, 0.2), Viscous(0.5)
DRIVEN = replace(
    SWINGING_SLIDER_CRANK,
    loads=(
        Load("motor", Turn(GROUND, "crank"), SpeedLine(2.0, 12.0)),
        Load("push", Turn(GROUND, "crank"), TimePulse(1.0, 0.1, 0.6)),
        Load("friction", Displacement("slider", (0.0, 0.0), 0.0), Friction(0.5, 0.3)),
    ),
)


SPRUNG, DAMPED, BOTH = anchored(SPRING), anchored(DAMPER), anchored(SPRING, DAMPER)


@pytest.mark.parametrize(
    "mechanism",
    [SPRUNG, DAMPED, BOTH, DRIVEN],
    ids=["spring", "damper", "spring and damper", "motor, pulse and friction"],
)
def test_under_loads_free_motion_has_order_two(mechanism: Mechanism) -> None:
    errors = pose_errors(mechanism)
    assert min(orders(errors)) > 1.8
    assert errors[-1] < 5e-4


def with_own_spring(monkeypatch: pytest.MonkeyPatch, stiffness: float, damping: float) -> None:
    """Have every free run carry pymunk's spring where `anchored` has its loads."""
    built = own.build_free

    def sprung(*given: Any) -> Build:
        made = built(*given)
        ends = made.local(GROUND, (0.2, 0.3)), made.local("rod", (0.05, 0.0))
        made.space.add(pymunk.DampedSpring(made.link(GROUND), made.link("rod"), *ends, 0.2, stiffness, damping))
        return made

    monkeypatch.setattr(own, "build_free", sprung)


def against(loaded: Mechanism) -> list[float]:
    """Errors of runs without loads against the exact motion with them."""
    bare, found = replace(loaded, loads=()), []
    for h in REFINED:
        steps = round(1.0 / h)
        every = steps // 250
        right = exact(loaded, h, steps, 0.0, every)
        found.append(
            pose_error(PYMUNK.free_run(bare, "tuned", h, steps, right.poses[0], right.rates[0], PACE, every), right)
        )
    return found


def test_pymunks_own_spring_is_as_good(monkeypatch: pytest.MonkeyPatch) -> None:
    errors = pose_errors(SPRUNG)
    with_own_spring(monkeypatch, SPRING.stiffness, 0.0)
    assert against(SPRUNG) == pytest.approx(errors, rel=1e-3)


def test_pymunks_own_damper_has_a_lower_order(monkeypatch: pytest.MonkeyPatch) -> None:
    errors = pose_errors(BOTH)
    with_own_spring(monkeypatch, SPRING.stiffness, DAMPER.damping)
    found = against(BOTH)
    assert orders(found)[-1] < 1.4
    assert found[-1] > 3.0 * errors[-1]


def test_forces_of_the_state_before_the_step_have_order_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Pushes, "give", Pushes.as_they_are)
    assert orders(pose_errors(SPRUNG)) == pytest.approx([1.0, 1.0], abs=0.1)


def test_a_start_out_of_step_has_order_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def as_given(made: Build, h: float, pushes: Pushes | None) -> Any:
        return own.state(made)[1][0]

    monkeypatch.setattr(own, "_half_step", as_given)
    assert orders(pose_errors(SWINGING_FOUR_BAR))[-1] == pytest.approx(1.0, abs=0.15)


def wrong(mechanism: Mechanism, **changes: Callable[[Any], Any]) -> Mechanism:
    """The mechanism with a property of its rocker changed."""
    return replace(
        mechanism,
        bodies=tuple(
            replace(b, **{name: change(getattr(b, name)) for name, change in changes.items()})
            if b.name == "rocker"
            else b
            for b in mechanism.bodies
        ),
    )


@pytest.mark.parametrize(
    "changes",
    [
        {"mass": lambda mass: 1.01 * mass},
        {"inertia": lambda inertia: 1.05 * inertia},
        {"centre_of_gravity": lambda centre: (centre[0] + 0.01 * 0.25, centre[1])},
    ],
    ids=["mass", "inertia", "centre of gravity"],
)
def test_a_wrong_body_is_seen_in_free_motion(changes: dict[str, Callable[[Any], Any]]) -> None:
    mechanism, h, steps = LOPSIDED, 5e-4, 4000
    right = exact(mechanism, h, steps, 0.0, 16)
    found = [
        pose_error(PYMUNK.free_run(one, "tuned", h, steps, right.poses[0], right.rates[0], PACE, 16), right)
        for one in (mechanism, wrong(mechanism, **changes))
    ]
    assert found[1] > 5.0 * found[0]


# With the rocker's centre of gravity off its pivot, so that its mass has something to do.
LOPSIDED = wrong(SWINGING_FOUR_BAR, centre_of_gravity=lambda _: (0.1, 0.0))


def test_a_run_that_breaks_says_so() -> None:
    run, _ = swing(chain(2), 0.5, 10.0, 1.0)
    assert run.outcome in (Outcome.OPENED, Outcome.EXPLODED, Outcome.DIVERGED)
    assert run.reason
