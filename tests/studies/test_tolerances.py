"""One meaning for a tolerance: a share of the range of motion, or a size with a unit, in every study."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import conrod
from conrod.cli.options import tolerance_in
from conrod.errors import InvalidInput
from conrod.execution.result import Plan
from conrod.execution.tolerances import (
    TOLERANCE_NAMES,
    UnscaledLimit,
    check_tolerance,
    point_scales,
    scale_tolerance,
    scene_scales,
)
from conrod.mjcf.loop_results import LOOP_UNITS, LoopRequest
from conrod.report.results import verdict_words
from conrod.scenes import SCENES
from conrod.studies.forces.results import ForceErrors, ForceResult
from conrod.studies.sweep.recommend import check_tolerances
from conrod.studies.sweep.step_search import TriedRun
from conrod.studies.validation.results import ValidationResult

SAW = SCENES["saw-500rpm"]
L = SAW.lengths["C"]


def refusal(function: Any, *arguments: Any) -> str:
    with pytest.raises(InvalidInput) as refused:
        function(*arguments)
    return str(refused.value)


def sizes(**errors: float) -> dict[str, dict[str, dict[str, float]]]:
    """Errors of a result: position errors over L by point."""
    return {point: {"position": {"max": size, "rms": size, "final": size}} for point, size in errors.items()}


def result(**errors: float) -> ValidationResult:
    return ValidationResult(
        scene="saw", parameters={}, engine="mujoco", engine_version="4", preset="tuned", mode="dynamic",
        revolutions=2.0, outcome="completed", errors=sizes(**errors),
    )  # fmt: skip


def test_a_share_is_the_same_with_and_without_l() -> None:
    assert check_tolerance({"position": "1e-4L", "velocity": "2e-3 L", "total": "1e-4"}) == {
        "position": 1e-4, "velocity": 2e-3, "total": 1e-4,
    }  # fmt: skip
    assert check_tolerance({"position": 1e-4}, LOOP_UNITS) == {"position": 1e-4}  # a typed number there is in metres
    asked = check_tolerance({"position": "0.1 mm", "velocity": "1e-4L"}, LOOP_UNITS)
    assert asked == {"position": pytest.approx(1e-4), "velocity": UnscaledLimit(1e-4, is_share=True)}


def test_a_plain_number_is_refused_where_it_may_be_metres() -> None:
    said = refusal(tolerance_in, "position=1e-4", LOOP_UNITS)
    assert said == (
        "--tolerance position=1e-4 may be 1e-4 m or a share of the range of motion: give a size, as in position=0.1mm, "
        "or a share, as in position=1e-4L"
    )
    assert refusal(check_tolerance, {"acceleration": "5"}, LOOP_UNITS).startswith("--tolerance acceleration=5 may be")
    assert tolerance_in("position=1e-4,velocity=1mm/s", TOLERANCE_NAMES) == {"position": 1e-4, "velocity": "1mm/s"}
    assert tolerance_in("position=1e-4L,velocity=1mm/s", LOOP_UNITS) == {"position": "1e-4L", "velocity": "1mm/s"}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("position=much", "is not a number; give a share, as in position=1e-4L, or a size, as in position=0.1mm"),
        ("position=1kg", "is not a unit of m"),
        ("position=-1mm", "--tolerance position = -0.001 m is out of range"),
        ("phase=1e-3L", "an angle has no range of motion: give phase=0.1deg"),
    ],
)
def test_a_tolerance_is_refused_when_no_size_or_share(text: str, said: str) -> None:
    assert said in refusal(tolerance_in, text, TOLERANCE_NAMES)


def test_a_tolerance_without_a_single_unit_is_a_share() -> None:
    assert check_tolerance({"energy": "1e-6"}, ("position", "energy")) == {"energy": 1e-6}
    assert "energy has no single unit" in refusal(check_tolerance, {"energy": "1 J"}, ("position", "energy"))
    assert "reactions has no single unit" in refusal(check_tolerance, {"reactions": "5 N"}, ("reactions",))


def test_a_size_is_converted_by_the_scales_of_the_scene() -> None:
    asked = check_tolerance({"position": "0.1mm", "velocity": "1 mm/s", "acceleration": "1m/s^2", "phase": "0.1deg"})
    limits, weights = scale_tolerance(asked, scene_scales(SAW))
    fastest = SAW.speed
    assert limits == pytest.approx(
        {"position": 1e-4 / L, "velocity": 1e-3 / (L * fastest), "acceleration": 1.0 / (L * fastest**2),
         "phase": np.radians(0.1)}
    )  # fmt: skip
    assert set(weights) <= {"position", "velocity", "acceleration"}


def test_each_point_is_held_to_the_size_and_to_no_less() -> None:
    # The fork travels a tenth of the slide: 0.09 mm of it is a larger share than 0.1 mm of the slide, and allowed.
    scales = point_scales({"slide": 0.2, "fork": 0.02}, 10.0)
    limits, weights = scale_tolerance({"position": UnscaledLimit(1e-4, is_share=False)}, scales)
    assert limits == pytest.approx({"position": 5e-4})
    asked = {"position": UnscaledLimit(1e-4, is_share=False)}
    for off, passed in ((0.09e-3, True), (0.11e-3, False)):
        for point in ("slide", "fork"):
            found = result(**{"slide": 0.0, "fork": 0.0, point: off / scales["position"][point]})
            judged = found.with_verdict(asked, scales)
            assert judged.passed is passed
            assert (judged.judged_error("position") or 0.0) * 0.2 == pytest.approx(off)
            run: Any = found
            assert (TriedRun(run, weights=weights).excess(limits) <= 1.0) is passed
    # As a share alone the fork is not: the control that weights decide.
    assert result(slide=0.0, fork=0.09e-3 / 0.02).with_verdict({"position": 5e-4}).passed is False


def test_a_verdict_has_sizes_beside_its_shares() -> None:
    judged = result(C=5e-4, M=1e-5).with_verdict({"position": 1e-4})
    assert verdict_words(judged, SAW) == "OUT OF TOLERANCE: position 5.0e-4 (0.11 mm) > 1.0e-4 (0.021 mm)"
    in_units = result(C=5e-4, M=1e-5).with_verdict(check_tolerance({"position": "0.1mm"}), scene_scales(SAW))
    assert verdict_words(in_units, SAW).endswith("> 4.7e-4 (0.10 mm)")
    assert result(C=4e-4, M=1e-5).with_verdict(check_tolerance({"position": "0.1mm"}), scene_scales(SAW)).passed


def test_a_torque_may_be_given_in_newton_metres() -> None:
    errors = {"torque": ForceErrors(0.01, 0.005, None, 20.0, own_peak=True)}
    found = ForceResult(
        scene="saw", engine="mujoco", engine_version="4", preset="tuned", parameters={}, steps_per_revolution=1000,
        revolutions=2.0, groups={"torque": ("torque",)}, outcome="completed", errors=errors,
    )  # fmt: skip
    for text, passed in (("0.3 N m", True), ("0.1 N m", False), ("0.02L", True)):
        asked = check_tolerance({"torque": text}, ("torque", "reactions"))
        assert found.with_verdict(asked).passed is passed
    words = verdict_words(found.with_verdict(check_tolerance({"torque": "0.1 N m"}, ("torque",))), SAW)
    assert words == "OUT OF TOLERANCE: torque 0.010 (0.20 N m) > 0.0050 (0.10 N m)"


def test_shares_of_a_model_with_drives_are_of_its_motion() -> None:
    asked = LoopRequest({}, tolerance={"velocity": 0.1}, shares={"position": 1e-3})
    assert asked.in_si({"position": 0.4, "velocity": 2.0}).tolerance == {"velocity": 0.1, "position": 4e-4}


def test_recommend_takes_sizes() -> None:
    assert check_tolerances({"position": "0.01mm", "velocity": None}) == {
        "position": UnscaledLimit(pytest.approx(1e-5), is_share=False)
    }
    assert "--position = '1 kg'" in refusal(check_tolerances, {"position": "1 kg"})


def test_a_table_is_judged_by_a_size_in_mm() -> None:
    times = np.linspace(0.0, 0.12, 60)
    exact = SAW.motion(SAW.speed * times, SAW.speed).point("C").position
    table = {"time": times, "C.x": exact[:, 0] + 1e-4, "C.y": exact[:, 1]}
    within, out = (conrod.check(table, SAW, tolerance={"position": text}) for text in ("0.11mm", "0.09mm"))
    assert (within.passed, out.passed) == (True, False)
    assert within.verdict.startswith("within tolerance: position 4.7e-4 (0.10 mm) <= 5.21e-4 (0.11 mm)")
    assert out.verdict.startswith("OUT OF TOLERANCE: position 4.7e-4 (0.10 mm) > 4.263e-4 (0.090 mm)")
    assert "'0.11mm'" in within.call


def test_a_plan_keeps_numbers_as_they_were() -> None:
    assert replace(Plan(), tolerance={"position": 1e-4}).tolerance == {"position": 1e-4}
