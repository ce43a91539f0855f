"""Free and torque-driven motion in pymunk against the exact one."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from free_machines import SWINGING_FOUR_BAR, SWINGING_SLIDER_CRANK, chain, energy_drift, exact, pose_error

from conrod.engines import engine_named
from conrod.engines.pymunk import dynamics as own
from conrod.engines.pymunk.loads import Pushes
from conrod.engines.pymunk.space import Build
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


def test_forces_of_the_state_before_the_step_have_order_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Pushes, "give", Pushes.as_they_are)
    assert orders(pose_errors(SPRUNG)) == pytest.approx([1.0, 1.0], abs=0.1)


def test_a_start_out_of_step_has_order_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def as_given(made: Build, h: float, pushes: Pushes | None) -> Any:
        return own.state(made)[1][0]

    monkeypatch.setattr(own, "_half_step", as_given)
    assert orders(pose_errors(SWINGING_FOUR_BAR))[-1] == pytest.approx(1.0, abs=0.15)


def test_a_run_that_breaks_says_so() -> None:
    run, _ = swing(chain(2), 0.5, 10.0, 1.0)
    assert run.outcome in (Outcome.OPENED, Outcome.EXPLODED, Outcome.DIVERGED)
    assert run.reason
