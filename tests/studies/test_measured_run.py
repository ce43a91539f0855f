"""A measurement holds the errors of the run that the case names, at the angles that it names."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

from conrod.comparison.compare import ExactMotions, compare
from conrod.comparison.trajectory import COMPARED_QUANTITIES as COMPARED
from conrod.comparison.trajectory import ArrayMapper, Trajectory
from conrod.engines import engine_named
from conrod.engines.run import run
from conrod.exact.motion import QUANTITIES, Array
from conrod.execution import run as measuring
from conrod.execution.prediction import predicted_errors
from conrod.execution.result import Plan
from conrod.execution.run import RunCase, RunResult, clamp_to_span, measure, run_refusal
from conrod.scenes import SCENES, scene_named
from conrod.studies.validation.dynamic_mode import DRAWN_POSES, validate_dynamic

SAW: Any = SCENES["saw-40rpm"]
GENEVA: Any = scene_named("geneva")
STEPS, ANGLES = 40, 8


def case_of(scene: Any, engine: str, steps: int = STEPS, preset: str = "tuned", **facts: Any) -> RunCase:
    return RunCase("mine", scene, engine_named(engine).presets[preset](scene, steps), **facts)


def run_again(case: RunCase) -> Trajectory:
    return run(case.scene, case.settings, case.revolutions, case.start_angle)


def size(values: Array, scene: Any, point: str, order: int) -> float:
    return float(np.hypot(*values.T).max()) / (scene.lengths[point] * abs(scene.speed) ** order)


@pytest.mark.parametrize(
    ("engine", "predicted_per_turn", "stride"), [("mujoco", STEPS // 4, 4), ("pymunk", 2 * STEPS, 1)]
)
def test_completed_run_is_measured_against_the_exact_motion(
    engine: str, predicted_per_turn: int, stride: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measuring, "PREDICTED_SAMPLES_PER_TURN", predicted_per_turn)
    case = case_of(SAW, engine, revolutions=1.5, start_angle=0.3, signed_angles=ANGLES)
    found, made = case.perform(), run_again(case)
    expected = compare(made, SAW)
    assert (found.outcome, found.reason) == ("completed", "")
    assert found.errors == {p: {q: asdict(getattr(e, q).size) for q in COMPARED} for p, e in expected.points.items()}
    assert found.closure == asdict(expected.closure)
    assert found.phase == {"max": expected.phase_max, "final": expected.phase_final}
    assert found.drive == {"speed": expected.drive_speed, "acceleration": expected.drive_acceleration}
    # The prediction is made at so many samples, and holds the worst point of each quantity.
    cut: Any = ArrayMapper(lambda parts: parts[0][::-1][::stride][::-1])
    points = {name: cut(tracks) for name, tracks in made.points.items()}
    predicted = predicted_errors(SAW.kinematics, points, cut(made.bodies))
    for k, quantity in enumerate(QUANTITIES):
        worst = {"predicted": 0.0, "difference": 0.0}
        for name, tracks in points.items():
            expected_error = predicted[name][quantity]
            off = expected_error - ExactMotions(SAW).error(getattr(tracks, quantity), name, quantity)
            for what, values in (("predicted", expected_error), ("difference", off)):
                worst[what] = max(worst[what], size(values, SAW, name, k))
        assert (found.prediction or {})[quantity] == pytest.approx(worst, rel=1e-12)


def interpolated(made: Trajectory, scene: Any, point: str, quantity: str, times: Array) -> Array:
    track = getattr(made.points[point], quantity)
    errors = ExactMotions(scene).error(track, point, quantity)
    return np.column_stack([np.interp(times, track.instants.times, errors[:, axis]) for axis in (0, 1)])


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
@pytest.mark.parametrize("scene", [SAW, GENEVA], ids=["turning", "one pass"])
def test_signed_errors_are_at_equal_angles_of_last_turn_or_pass(scene: Any, engine: str) -> None:
    case = clamp_to_span(case_of(scene, engine, revolutions=2.0, start_angle=0.3, signed_angles=ANGLES))
    found, made = measure(case), run_again(case)
    span = scene.kinematics.mechanism.driver.span
    if span is None:
        angles = 0.3 + 2.0 * np.pi * (1.0 + np.arange(ANGLES) / ANGLES)
    else:
        angles = span[0] + (span[1] - span[0]) * (np.arange(ANGLES) + 0.5) / ANGLES
    assert (found.largest("position") or 0.0) > 1e-9, "errors of nothing but rounding would prove nothing"
    for point in scene.lengths:
        for k, quantity in enumerate(QUANTITIES):
            expected = interpolated(made, scene, point, quantity, angles / scene.speed)
            expected = expected / (scene.lengths[point] * abs(scene.speed) ** k)
            np.testing.assert_allclose(found.signed_errors(point, quantity), expected, rtol=1e-9, atol=1e-15)
    whole = RunResult("completed", signed={"C": {"position": [[0, 1]]}})  # as JSON may have it
    assert whole.signed_errors("C", "position").dtype == np.float64
    with pytest.raises(ValueError, match="'exploded' has no errors"):
        RunResult("exploded").signed_errors("C", "position")


def test_a_pass_of_two_steps_is_not_run_and_one_of_three_is() -> None:
    cases = (clamp_to_span(case_of(GENEVA, "pymunk", n)) for n in range(2, 40))
    fewest = next(case for case in cases if run_refusal(case, GENEVA) is None)
    steps = fewest.settings.steps_per_revolution
    assert round(fewest.revolutions * steps) == 3
    assert run_refusal(case_of(SAW, "pymunk", 2), SAW) is None
    found = measure(case_of(GENEVA, "pymunk", steps - 1))
    assert (found.outcome, found.errors) == ("unsupported", None)
    assert "are needed" in found.reason


def test_refusal_or_failure_is_an_outcome_with_reason_only() -> None:
    cam = SCENES["cam-follower"]
    refused = case_of(cam, "mujoco", preset="hardened")
    why = refused.settings and engine_named("mujoco").refusal(cam, refused.settings)
    assert why
    assert measure(refused) == RunResult("unsupported", why)
    failing = case_of(SCENES["saw-500rpm"], "pymunk", 20, "stock")
    made = run_again(failing)
    assert made.outcome.slug != "completed"
    assert measure(failing) == RunResult(made.outcome.slug, made.reason)


def test_drawn_poses_have_the_errors_of_points_and_show_a_defect() -> None:
    run = validate_dynamic("saw", SAW, engine_named("pymunk"), "stock", Plan(240))
    assert run.poses.values.shape == (DRAWN_POSES + 1, 9)
    exact = SAW.motion(run.poses.angle, SAW.speed).point("C").position
    for share, right in ((1.0, True), (1.1, False)):
        poses = SAW.kinematics.poses(run.poses.angle) + share * run.poses.values
        off = np.linalg.norm(SAW.kinematics.point_derivatives([poses])["C"][0] - exact, axis=1).max() / SAW.lengths["C"]
        assert bool(off == pytest.approx(run.largest("position"), rel=0.02)) is right
