"""A verdict notices what is planted into the run that it is on, and one that notices nothing is no verdict."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from conrod.engines import engine_named
from conrod.engines.engine import run_extent
from conrod.engines.mujoco import MuJoCoSettings, dynamics, exchanged_inertia
from conrod.engines.numerics import phase_bound
from conrod.execution.result import Plan
from conrod.scenes import SCENES, scene_named
from conrod.studies.detection.defects import MOTION_DEFECTS, Recording
from conrod.studies.detection.qualification import (
    SIZE_RATIO,
    QualificationCase,
    failure_reasons,
    motion_judge,
    smallest_noticed_size,
)
from conrod.studies.validation.dynamic_mode import prepare_run
from docs.studies.healthy import VariantCase, variant

SAW = SCENES["saw-500rpm"]
CHEAP = Plan(250, 0.5)
MASS = {"mass"}


@cache
def qualified(tolerance: float | None = None) -> Any:
    asked = None if tolerance is None else {"position": tolerance}
    # Forces of tuned MuJoCo are not judged, which saves their run.
    return QualificationCase("saw", SAW, "mujoco", "tuned", replace(CHEAP, tolerance=asked)).perform().qualified


@pytest.mark.parametrize("threshold", [3.7e-9, 0.9])
def test_bisection_finds_a_known_threshold(threshold: float) -> None:
    found = smallest_noticed_size(lambda size: size > threshold, 1.0)
    assert threshold <= found <= SIZE_RATIO * threshold


def test_defects_of_motion_are_detected_and_masses_are_invisible() -> None:
    found = {one.defect: one for one in qualified().motion}
    assert set(found) == {one.name for one in MOTION_DEFECTS} | MASS
    assert {name for name, one in found.items() if not one.by} == MASS
    assert {name for name, one in found.items() if not one.visible} == MASS
    assert found["other branch"].by == ("flipped",)
    assert found["run cut short"].by == ("crashed",)
    for one in qualified().motion:
        assert one.smallest is None or one.smallest < one.size
    assert not qualified().notices_nothing


def test_a_blind_judge_is_told() -> None:
    blind = qualified(tolerance=1e6)
    assert blind.notices_nothing
    # What has no size is noticed all the same: it alone makes no verdict.
    assert {one.defect for one in blind.motion if one.by} == {"other branch", "run cut short", "no number in a sample"}
    result = replace(prepare_run("saw", SAW, engine_named("mujoco"), "tuned", CHEAP)[0], passed=True)
    assert result.with_qualification(blind).passed is False
    assert "no verdict" in result.with_qualification(blind).other_failures()[0]
    assert result.with_qualification(qualified()).passed is True


@pytest.mark.slow
def test_forces_show_the_masses_that_the_motion_does_not() -> None:
    found = QualificationCase("saw", SAW, "mujoco", "hardened", Plan(1000, 1.0)).perform().qualified
    assert {one.defect for one in found.forces if one.by} == MASS
    for one in found.forces:
        assert one.smallest < one.size


def test_nothing_planted_is_nothing_noticed() -> None:
    engine = engine_named("pymunk")
    result, settings, start = prepare_run("saw", SAW, engine, "tuned", CHEAP)
    given, judge = (
        Recording.from_engine(engine, SAW, settings, result.revolutions, start),
        motion_judge(result, SAW, None),
    )
    assert judge(given).passed is True
    for defect in MOTION_DEFECTS:
        if defect.unit:
            for _, plant in defect.places(given):
                assert failure_reasons(judge(plant(given, 0.0))) == ()


@pytest.mark.parametrize("number", [0, 1])
def test_healthy_variant_passes_and_fails_with_a_wrong_step(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    made, steps, start = variant(SAW, number)
    assert (made, steps, start) == variant(SAW, number)
    assert made.parameters["rod"] != SAW.parameters["rod"]
    case = VariantCase("saw", made, "mujoco", "hardened", Plan(steps, 1.0), start)
    assert case.perform().passed is True
    right = dynamics.build

    def build(*given: Any) -> Any:
        wrong = right(*given)
        wrong.model.opt.timestep *= 1.0001
        return wrong

    monkeypatch.setattr(dynamics, "build", build)
    assert case.perform().passed is False


def test_flywheel_rate_varies_with_all_bodies_that_turn() -> None:
    """Near an end of this rocker's pass its coupler turns fast, and the crank's rate is off by 8e-14."""
    made, steps, start = variant(scene_named("double-rocker"), 14)
    found = VariantCase("double-rocker", made, "mujoco", "tuned", Plan(steps, 1.0), start).perform()
    assert found.passed is True
    begun_at = run_extent(made, steps, 1.0)[0]
    points_alone = exchanged_inertia(made) / MuJoCoSettings.tuned(made, steps).armature
    turns = found.revolutions
    assert phase_bound(steps * turns, turns, begun_at, points_alone) < found.phase["max"]
