"""A wrong clock is out of tolerance: errors are compared at the angle reached, and say nothing of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from planted_engine import LawfulEngine

from conrod.engines import engine_named
from conrod.engines.mujoco import dynamics as mujoco
from conrod.engines.pymunk import dynamics as pymunk
from conrod.execution.result import Plan
from conrod.scenes import SCENES, scene_named
from conrod.studies.validation.dynamic_mode import validate_dynamic
from conrod.studies.validation.results import ValidationResult

SAW = SCENES["saw-40rpm"]
STEPS = 200
WRONG = 1e-4  # of a step: 0.01 %
CLOCK = {"phase", "total"}


def validated(engine: Any, preset: str, scene: Any = SAW, turns: float = 1.0) -> ValidationResult:
    return validate_dynamic("saw", scene, engine, preset, Plan(STEPS, turns))


# -- an engine whose clock alone is wrong ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("step_error", "late", "off"),
    [(0.0, 0, 0.0), (WRONG, 0, WRONG * 2.0 * np.pi), (-WRONG, 0, WRONG * 2.0 * np.pi), (0.0, 1, 2.0 * np.pi / STEPS)],
    ids=["right", "long steps", "short steps", "stamps a step late"],
)
def test_engine_passes_by_its_law_and_fails_by_its_clock_alone(step_error: float, late: int, off: float) -> None:
    found = validated(LawfulEngine(step_error, late), "sharp")
    assert found.completed
    assert found.passed is (off == 0.0)
    assert set(found.out_of_tolerance()) == (CLOCK if off else set())
    assert (found.phase or {})["max"] == pytest.approx(off, rel=1e-6, abs=1e-12)
    # At the angle reached there is nothing to be seen of it.
    assert replace(found, tolerance=replace(found.tolerance, phase=None, total=None)).with_verdict().passed
    # A user may ask for a phase.
    assert [found.with_verdict({"phase": size}).passed for size in (1.1 * off + 1e-12, 0.9 * off)] == [True, off == 0.0]


def test_what_the_clock_may_do_to_a_point_is_allowed_and_no_more() -> None:
    sharp = validated(LawfulEngine(), "sharp").tolerance
    assert sharp.phase == pytest.approx(STEPS * np.finfo(float).eps * 2.0 * np.pi)
    assert 0.0 < sharp.total - sharp.position < 10.0 * sharp.phase
    assert "phase: rounding" in sharp.reason


# -- the engines that ship, with a clock made wrong --------------------------------------------------------------------


def with_longer_steps(made: Any) -> Any:
    made.model.opt.timestep *= 1.0 + WRONG
    return made


# Of an engine's module, a function and what takes its place.
FAULTS: dict[str, tuple[Any, str, Callable[[Any], Any]]] = {
    "mujoco, long steps": (mujoco, "build", lambda right: lambda *given: with_longer_steps(right(*given))),
    "mujoco, late stamps": (
        *(mujoco, "sample_instants"),
        lambda right: lambda made, times, *rest: right(made, times + made.model.opt.timestep, *rest),
    ),
    "pymunk, long steps": (
        *(pymunk, "advance"),
        lambda right: lambda made, timestep, *rest: right(made, (1.0 + WRONG) * timestep, *rest),
    ),
    "pymunk, late stamps": (
        *(pymunk, "sample_instants"),
        lambda right: lambda mechanism, h, times, *rest: right(mechanism, h, times + h, *rest),
    ),
    "pymunk, late stamps of velocities": (
        *(pymunk, "sample_instants"),
        lambda right: lambda mechanism, h, *rest: later(right(mechanism, h, *rest), h),
    ),
}


def later(at: Any, by: float) -> Any:
    return replace(at, velocity=replace(at.velocity, times=at.velocity.times + by))


@pytest.mark.parametrize("fault", FAULTS)
def test_real_engine_fails_with_a_wrong_clock_only(fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    engine, (module, name, wrong) = engine_named(fault.split(",", maxsplit=1)[0]), FAULTS[fault]
    assert validated(engine, "tuned").passed
    monkeypatch.setattr(module, name, wrong(getattr(module, name)))
    found = validated(engine, "tuned")
    assert found.completed
    assert found.passed is False
    # pymunk's crank angle is written at every step, and drifts no further than one step's share.
    shown = CLOCK if fault.startswith("mujoco") or fault.endswith("late stamps") else {"phase"}
    assert shown <= set(found.out_of_tolerance())


@pytest.mark.parametrize("scene", ["geneva", "web-cutter", "press-cutting", "cam-3-4-5"])
@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_no_shipped_engine_leaves_the_law_of_its_clock(scene: str, engine: str) -> None:
    """Machines that make a pass, that turn, that carry loads, and a cam."""
    machine, made = scene_named(scene), engine_named(engine)
    found = validate_dynamic(scene, machine, made, "tuned", Plan(1000, 1.0))
    assert (found.tolerance.phase is None) == (found.tolerance.position is None)
    assert not CLOCK & set(found.out_of_tolerance())
