"""A wrong clock is out of tolerance: errors are compared at the angle reached, and say nothing of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from planted_engine import LawfulEngine

from conrod.engines import engine_named
from conrod.engines.mujoco import dynamics as mujoco_dynamics
from conrod.engines.pymunk import dynamics as pymunk_dynamics
from conrod.scenes import SCENES, scene_named
from conrod.studies.validation.plan import Plan, validate_dynamic
from conrod.studies.validation.results import ValidationResult

SAW = SCENES["saw-40rpm"]
STEPS = 200
WRONG = 1e-4  # of a step: 0.01 %
CLOCK = {"phase", "total"}


def validated(engine: Any, preset: str, scene: Any = SAW, turns: float = 1.0) -> ValidationResult:
    return validate_dynamic("saw", scene, engine, preset, Plan(STEPS, turns))


def turned_by_the_wrong_clock(found: ValidationResult) -> float:
    """Crank angle [rad] between the two clocks at the end of a turn."""
    assert found.phase is not None
    return found.phase["max"]


# -- an engine whose clock alone is wrong ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("step_error", "late", "off"),
    [(0.0, 0, 0.0), (WRONG, 0, WRONG * 2.0 * np.pi), (-WRONG, 0, WRONG * 2.0 * np.pi), (0.0, 1, 2.0 * np.pi / STEPS)],
    ids=["right", "long steps", "short steps", "stamps a step late"],
)
def test_an_engine_passes_by_its_own_law_and_fails_by_its_clock_alone(step_error: float, late: int, off: float) -> None:
    found = validated(LawfulEngine(step_error, late), "sharp")
    assert found.completed
    assert found.passed is (off == 0.0)
    assert set(found.exceeded()) == (CLOCK if off else set())
    assert turned_by_the_wrong_clock(found) == pytest.approx(off, rel=1e-6, abs=1e-12)
    # At the angle reached there is nothing to be seen of it.
    assert replace(found, tolerance=replace(found.tolerance, phase=None, total=None)).judged().passed


def test_what_the_clock_may_do_to_a_point_is_allowed_and_no_more() -> None:
    sharp = validated(LawfulEngine(), "sharp").tolerance
    assert sharp.position is not None
    assert sharp.total is not None
    assert sharp.phase == pytest.approx(STEPS * np.finfo(float).eps * 2.0 * np.pi)
    assert 0.0 < sharp.total - sharp.position < 10.0 * sharp.phase
    assert "phase: rounding" in sharp.reason


def test_a_user_may_ask_for_a_phase() -> None:
    plan = Plan(STEPS, 1.0)
    found = validate_dynamic("saw", SAW, LawfulEngine(WRONG), "sharp", plan)
    assert found.judged({"phase": 1e-3}).passed
    assert found.judged({"phase": 1e-4}).passed is False


# -- the engines that ship, with a clock made wrong --------------------------------------------------------------------


def with_a_longer_step(monkeypatch: pytest.MonkeyPatch, engine: str) -> None:
    if engine == "mujoco":
        right = mujoco_dynamics.build

        def build(*given: Any) -> Any:
            made = right(*given)
            made.model.opt.timestep *= 1.0 + WRONG
            return made

        monkeypatch.setattr(mujoco_dynamics, "build", build)
    else:
        steps = pymunk_dynamics.advance
        monkeypatch.setattr(
            pymunk_dynamics,
            "advance",
            lambda made, settings, *rest: steps(
                made, replace(settings, timestep=(1.0 + WRONG) * settings.timestep), *rest
            ),
        )


def with_late_stamps(monkeypatch: pytest.MonkeyPatch, engine: str) -> None:
    if engine == "mujoco":
        stamped = mujoco_dynamics.instants_of
        monkeypatch.setattr(
            mujoco_dynamics,
            "instants_of",
            lambda made, times, *rest: stamped(made, times + made.model.opt.timestep, *rest),
        )
    else:
        stamps = pymunk_dynamics.staggered
        monkeypatch.setattr(
            pymunk_dynamics, "staggered", lambda mechanism, h, times, *rest: stamps(mechanism, h, times + h, *rest)
        )


def with_late_velocity_stamps(monkeypatch: pytest.MonkeyPatch, engine: str) -> None:
    stamps = pymunk_dynamics.staggered

    def late(mechanism: Any, h: float, *rest: Any) -> Any:
        at = stamps(mechanism, h, *rest)
        return replace(at, velocity=replace(at.velocity, times=at.velocity.times + h))

    monkeypatch.setattr(pymunk_dynamics, "staggered", late)


Fault = Callable[[pytest.MonkeyPatch, str], None]


@pytest.mark.parametrize(
    ("engine", "fault", "shown"),
    [
        ("mujoco", with_a_longer_step, CLOCK),
        ("mujoco", with_late_stamps, CLOCK),
        # The crank's angle is written at every step, and drifts no further than one step's share.
        ("pymunk", with_a_longer_step, {"phase"}),
        ("pymunk", with_late_stamps, CLOCK),
        ("pymunk", with_late_velocity_stamps, {"phase"}),
    ],
)
def test_an_engine_that_ships_fails_with_a_wrong_clock_and_passes_with_its_own(
    engine: str, fault: Fault, shown: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert validated(engine_named(engine), "tuned").passed
    fault(monkeypatch, engine)
    found = validated(engine_named(engine), "tuned")
    assert found.completed
    assert found.passed is False
    assert shown <= set(found.exceeded())


@pytest.mark.parametrize("scene", ["geneva", "web-cutter", "press-cutting", "cam-3-4-5"])
@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_no_shipped_engine_leaves_the_law_of_its_clock(scene: str, engine: str) -> None:
    """Machines that make a pass, that turn, that carry loads, and a cam."""
    machine, made = scene_named(scene), engine_named(engine)
    found = validate_dynamic(scene, machine, made, "tuned", Plan(1000, 1.0))
    assert (found.tolerance.phase is None) == (found.tolerance.position is None)
    assert not CLOCK & set(found.exceeded())
