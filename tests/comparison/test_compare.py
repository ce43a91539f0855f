"""A comparison sees nothing where there is nothing, and every planted defect in the size that theory gives it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from catalogue import DEFECTIVE_CAMS, DEFECTIVE_LINKAGES, EVERY_SCENE, PRESS, SAW, SCENES, WITH_A_ROD
from synthetic import (
    STAGGERED,
    STEPS,
    TOGETHER,
    instants,
    longer_rod,
    other_branch,
    rod_reach,
    synthetic_trajectory,
    turned_crank,
    with_values,
)

from conrod import Comparison, Outcome, compare
from conrod.comparison.compare import ExactMotions, track_errors
from conrod.comparison.outcome import judge_outcome
from conrod.comparison.trajectory import BodyTracks, PointTracks, Track
from conrod.engines import engine_named
from conrod.engines.run import run_in_one_piece
from conrod.errors import InvalidInput
from conrod.exact.motion import Array, Instants
from conrod.execution.prediction import predicted_errors
from conrod.scenes import CamFollower, Saw, Scene, ShearPress

ROUNDING = 1e-14
QUANTITIES = ("position", "velocity", "acceleration")
# The reference's own agreement: velocities and accelerations of a cam carry the conditioning of its joints.
REFERENCES_AGREE = 1e-12
STEP = 2.0 * math.pi / STEPS  # [rad]


def slopes(scene: Scene, point: str, angles: Array) -> tuple[Array, Array, Array, Array]:
    """|x|, |x'|, |x''|, |x'''| by the crank angle, over L."""
    unit = scene.motion(angles, 1.0).point(point)
    length = scene.lengths[point]
    position, velocity, acceleration, jerk = (
        np.linalg.norm(getattr(unit, q), axis=1) / length for q in (*QUANTITIES, "jerk")
    )
    return position, velocity, acceleration, jerk


def nothing_found(found: Comparison) -> bool:
    """Whether the comparison calls this trajectory exact: the one rule that all negative controls must break."""
    return found.worst("position") <= ROUNDING and max(found.worst(q) for q in QUANTITIES) <= REFERENCES_AGREE


@pytest.mark.parametrize("stamps", [TOGETHER, (0.0, 0.5, 0.5)])
@pytest.mark.parametrize("name", EVERY_SCENE)
def test_compare_finds_no_error_in_exact_motion(name: str, stamps: tuple[float, float, float]) -> None:
    scene = EVERY_SCENE[name]
    found = compare(synthetic_trajectory(scene, stamps=stamps), scene)
    assert nothing_found(found)
    if not isinstance(scene, CamFollower):
        assert max(found.worst(q) for q in QUANTITIES) <= ROUNDING
    assert found.worst("total") <= ROUNDING
    assert found.closure.position <= ROUNDING
    assert max(found.closure.velocity, found.closure.acceleration) <= REFERENCES_AGREE
    assert (found.phase_max, found.drive_speed, found.drive_acceleration) == (0.0, 0.0, 0.0)
    assert set(found.points) == set(scene.lengths)


def test_comparison_is_shown_without_its_samples() -> None:
    scene = EVERY_SCENE["saw-40rpm"]
    found = repr(compare(synthetic_trajectory(scene), scene))
    assert found.startswith("<Comparison of C, M: largest position ")
    assert "array" not in found


@pytest.mark.parametrize("name", EVERY_SCENE)
def test_compare_measures_shift_by_one_step(name: str) -> None:
    scene = EVERY_SCENE[name]
    exact = synthetic_trajectory(scene)
    found = compare(with_values(exact, "position", lambda v: np.vstack([v[1:], v[:1]])), scene)
    assert not nothing_found(found)
    angles = exact.points[next(iter(scene.lengths))].position.instants.angle
    for point, errors in found.points.items():
        _, velocity, acceleration, _ = slopes(scene, point, angles[:-1])
        bend = 0.6 * STEP**2 * acceleration.max()
        np.testing.assert_allclose(errors.position.error[:-1], STEP * velocity, rtol=0.0, atol=bend)
        assert errors.position.size.max > 100.0 * ROUNDING


@pytest.mark.parametrize("name", WITH_A_ROD)
def test_compare_measures_velocity_stamped_half_a_step_early(name: str) -> None:
    scene = EVERY_SCENE[name]
    staggered = synthetic_trajectory(scene, stamps=STAGGERED)
    early = {
        point: replace(tracks, velocity=replace(tracks.velocity, instants=tracks.position.instants))
        for point, tracks in staggered.points.items()
    }
    found = compare(replace(staggered, points=early), scene)
    assert not nothing_found(found)
    assert found.worst("position") <= ROUNDING  # the defect is in the velocity, and is named so
    angles = staggered.points[scene.output].position.instants.angle
    for point, errors in found.points.items():
        _, _, acceleration, jerk = slopes(scene, point, angles)
        bend = 0.15 * STEP**2 * jerk.max()
        np.testing.assert_allclose(errors.velocity.error, 0.5 * STEP * acceleration, rtol=0.0, atol=bend)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("name", EVERY_SCENE)
def test_compare_measures_swapped_sign_as_twice_the_quantity(name: str, order: int) -> None:
    scene, quantity = EVERY_SCENE[name], QUANTITIES[order]
    exact = synthetic_trajectory(scene)
    found = compare(with_values(exact, quantity, lambda v: -v), scene)
    assert not nothing_found(found)
    for point, errors in found.points.items():
        at = getattr(exact.points[point], quantity).instants.angle
        np.testing.assert_allclose(
            getattr(errors, quantity).error, 2.0 * slopes(scene, point, at)[order], rtol=1e-10, atol=1e-11
        )


@pytest.mark.parametrize("name", SCENES)
def test_compare_measures_gravity_left_in_acceleration(name: str) -> None:
    scene = SCENES[name]
    found = compare(
        with_values(synthetic_trajectory(scene), "acceleration", lambda v: v + np.array([0.0, 9.81])), scene
    )
    assert not nothing_found(found)
    assert found.worst("velocity") <= REFERENCES_AGREE
    for point, errors in found.points.items():
        expected = 9.81 / (scene.speed**2 * scene.lengths[point])
        np.testing.assert_allclose(errors.acceleration.error, expected, rtol=1e-9)


@pytest.mark.parametrize("name", EVERY_SCENE)
def test_fast_drive_shows_in_drive_phase_and_total_only(name: str) -> None:
    scene = EVERY_SCENE[name]
    trajectory = synthetic_trajectory(scene, drive=1e-6)
    found = compare(trajectory, scene)
    assert found.worst("position") <= ROUNDING
    assert found.worst("velocity") <= REFERENCES_AGREE
    assert found.drive_speed == pytest.approx(1e-6, rel=1e-9)
    assert found.phase_final == found.phase_max == pytest.approx(1e-6 * 4.0 * math.pi, rel=1e-9)
    for point, errors in found.points.items():
        at = instants(scene.speed, 2.0)
        lag = 1e-6 * np.abs(scene.speed * at.times)
        expected = lag * slopes(scene, point, scene.speed * at.times)[1]
        bend = 0.6 * lag.max() ** 2 * slopes(scene, point, at.angle)[2].max()
        np.testing.assert_allclose(errors.total.error, expected, rtol=0.0, atol=bend + ROUNDING)
        assert errors.total.size.max > 1e-6


@pytest.mark.parametrize("name", DEFECTIVE_LINKAGES)
def test_compare_measures_longer_rod_as_triangle_predicts(name: str) -> None:
    scene = EVERY_SCENE[name]
    trajectory = synthetic_trajectory(scene, longer_rod(scene))
    found = compare(trajectory, scene)
    assert not nothing_found(found)
    slider = found.points[scene.output]
    # w = sqrt(l^2 - u^2) is the rod along the slide: dw / dl = l / w. Second order: 1e-8 of the rod.
    angles = slider.position.angle
    excess = 1e-4 * scene.rod
    expected = excess * scene.rod / rod_reach(scene, angles) / scene.lengths[scene.output]
    np.testing.assert_allclose(slider.position.error, expected, rtol=1e-4)
    # The joints of the right mechanism are open by just the excess.
    assert found.closure.position == pytest.approx(excess / max(scene.lengths.values()), rel=1e-9)


@pytest.mark.parametrize("name", DEFECTIVE_LINKAGES)
def test_other_branch_is_large_error_without_gap(name: str) -> None:
    scene = EVERY_SCENE[name]
    trajectory = synthetic_trajectory(scene, other_branch(scene))
    found = compare(trajectory, scene)
    slider = found.points[scene.output]
    expected = 2.0 * rod_reach(scene, slider.position.angle) / scene.lengths[scene.output]
    np.testing.assert_allclose(slider.position.error, expected, rtol=1e-12)
    # Every joint is closed: it takes the branch's sign to tell how this run ended.
    assert found.closure.position <= ROUNDING
    assert trajectory.bodies is not None
    assert judge_outcome(scene.kinematics, trajectory.bodies, scene.speed).outcome is Outcome.FLIPPED


@pytest.mark.parametrize("name", {**DEFECTIVE_LINKAGES, **DEFECTIVE_CAMS})
def test_compare_measures_cam_or_crank_turned_by_0_01_deg(name: str) -> None:
    scene = EVERY_SCENE[name]
    turn = math.radians(0.01)
    trajectory = synthetic_trajectory(scene, turned_crank(scene))
    found = compare(trajectory, scene)
    assert not nothing_found(found)
    assert found.phase_max == 0.0  # by the drive's own account all is well
    for point, errors in found.points.items():
        _, velocity, acceleration, _ = slopes(scene, point, errors.position.angle)
        bend = 0.6 * turn**2 * acceleration.max()
        np.testing.assert_allclose(errors.position.error, turn * velocity, rtol=0.0, atol=bend + ROUNDING)
        assert errors.position.size.max > 1e-5


@pytest.mark.parametrize("name", WITH_A_ROD)
def test_closure_measures_slider_that_drifts_off_its_pin(name: str) -> None:
    scene = EVERY_SCENE[name]
    trajectory = synthetic_trajectory(scene)
    assert trajectory.bodies is not None
    length, w = max(scene.lengths.values()), abs(scene.speed)
    slider = 3 * scene.mechanism().body_index["slider"]
    for level, (field, scale) in enumerate((("poses", 1.0), ("rates", w), ("accelerations", w**2))):
        states = getattr(trajectory.bodies, QUANTITIES[level])
        values = getattr(states, field).copy()
        values[7, slider : slider + 2] += 1e-5 * length * scale * np.array([0.6, 0.8])
        moved = replace(trajectory.bodies, **{QUANTITIES[level]: replace(states, **{field: values})})
        closure = compare(replace(trajectory, bodies=moved), scene).closure
        assert getattr(closure, QUANTITIES[level]) == pytest.approx(1e-5, rel=1e-6)
        for other in set(QUANTITIES) - {QUANTITIES[level]}:
            assert getattr(closure, other) <= REFERENCES_AGREE


def test_size_has_max_rms_and_final_value() -> None:
    scene = PRESS
    trajectory = synthetic_trajectory(scene)
    bump = np.zeros((2 * STEPS + 1, 2))
    bump[5], bump[-1] = [3e-3, 4e-3], [0.0, -1e-3]
    size = compare(with_values(trajectory, "position", lambda v: v + bump), scene).points["A"].position.size
    length = scene.lengths["A"]
    assert size.max == pytest.approx(5e-3 / length)
    assert size.final == pytest.approx(1e-3 / length)
    assert size.rms == pytest.approx(math.sqrt((5e-3**2 + 1e-3**2) / (2 * STEPS + 1)) / length)


@pytest.mark.parametrize(
    ("asked", "line"),
    [
        (("positon",), "unknown quantity 'positon': did you mean 'position'"),
        (("position", "maxx"), "unknown measure 'maxx': did you mean 'max'"),
    ],
)
def test_worst_refuses_unknown_quantity_with_choices(asked: tuple[str, ...], line: str) -> None:
    with pytest.raises(InvalidInput, match=f"^{line}"):
        compare(synthetic_trajectory(SAW), SAW).worst(*asked)


def test_compare_refuses_unknown_point_and_scene_name() -> None:
    made = synthetic_trajectory(SAW)
    with pytest.raises(InvalidInput, match=r"^unknown observed point 'Z'"):
        compare(made, SAW).points["Z"]
    with pytest.raises(InvalidInput, match=r"^compare takes a scene, not its name"):
        compare(made, "saw-500rpm")


@pytest.mark.parametrize("sample", [0, STEPS, -1], ids=["first", "middle", "last"])
def test_largest_error_includes_every_sample(sample: int) -> None:
    """One wrong sample is found wherever it is: in each error, closure, phase and drive."""
    right = synthetic_trajectory(PRESS)
    bump = np.zeros(2 * STEPS + 1)
    bump[sample] = 1e-3
    for quantity in QUANTITIES:
        found = compare(with_values(right, quantity, lambda v: v + bump[:, None] * [3.0, 4.0]), PRESS)
        power = QUANTITIES.index(quantity)
        norm = PRESS.lengths["A"] * abs(PRESS.speed) ** power
        assert found.points["A"].position.size.max == pytest.approx(5e-3 / norm if power == 0 else 0.0, abs=1e-12)
        assert getattr(found.points["A"], quantity).size.max == pytest.approx(5e-3 / norm, rel=1e-9)
        assert found.worst(quantity) >= getattr(found.points["A"], quantity).size.max
    assert right.bodies is not None
    at = right.bodies.position.instants
    for field, found_as, expected in (
        ("angle", "phase_max", 1e-3),
        ("rate", "drive_speed", 1e-3 / abs(PRESS.speed)),
        ("acceleration", "drive_acceleration", 1e-3 / PRESS.speed**2),
    ):
        moved = replace(at, **{field: getattr(at, field) + bump})
        states = replace(right.bodies.position, instants=moved)
        off = compare(replace(right, bodies=BodyTracks(states, states, states)), PRESS)
        assert getattr(off, found_as) == pytest.approx(expected, rel=1e-9)
    for part, kept in (("poses", "position"), ("rates", "velocity"), ("accelerations", "acceleration")):
        states = right.bodies.position
        open_ = replace(states, **{part: getattr(states, part) + 1e-3 * (bump[:, None] != 0.0) * np.arange(9)})
        closure = compare(replace(right, bodies=BodyTracks(open_, open_, open_)), PRESS).closure
        assert getattr(closure, kept) > 1e-4 / abs(PRESS.speed) ** 2


@pytest.mark.parametrize("outcome", [o for o in Outcome if o is not Outcome.COMPLETED])
def test_compare_refuses_run_that_did_not_complete(outcome: Outcome) -> None:
    trajectory = replace(synthetic_trajectory(SAW), outcome=outcome, reason="planted")
    with pytest.raises(ValueError, match=f"{outcome.slug}.*has no errors: planted"):
        compare(trajectory, SAW)


RUNS = [
    *(
        (name, engine, preset)
        for name in ("shear-press", "saw-500rpm")
        for engine, presets in (("mujoco", ("stock", "tuned", "hardened")), ("pymunk", ("stock", "tuned")))
        for preset in presets
    ),
    *(("cam-follower", engine, "tuned") for engine in ("mujoco", "pymunk")),
]


def run(scene: Scene, engine: str, preset: str) -> Any:
    steps = 4000 if isinstance(scene, CamFollower) else 500
    made = engine_named(engine)
    return run_in_one_piece(made, scene, made.presets[preset](scene, steps), 1.0)


def largest_difference(scene: Scene, trajectory: Any, reference: Scene) -> dict[str, float]:
    """Measured against a reference minus predicted from the scene's joints, normalised."""
    predicted = predicted_errors(scene.kinematics, trajectory.points, trajectory.bodies)
    sizes = {}
    for k, quantity in enumerate(QUANTITIES):
        sizes[quantity] = 0.0
        for name, tracks in trajectory.points.items():
            measured = ExactMotions(reference).error(getattr(tracks, quantity), name, quantity)
            off = np.linalg.norm(measured - predicted[name][quantity], axis=1).max()
            sizes[quantity] = max(sizes[quantity], float(off) / (scene.lengths[name] * abs(scene.speed) ** k))
    return sizes


@pytest.mark.parametrize(("name", "engine", "preset"), RUNS)
def test_error_predicted_from_gaps_matches_at_second_order(name: str, engine: str, preset: str) -> None:
    scene = SCENES[name]
    trajectory = run(scene, engine, preset)
    measured = compare(trajectory, scene)
    for quantity, off in largest_difference(scene, trajectory, scene).items():
        # One Newton step leaves the square of the position error, by a curvature of order one, in every quantity.
        remainder = measured.worst("position") * max(measured.worst("position"), measured.worst(quantity))
        assert off <= 2.0 * remainder + 1e-13, (quantity, off)


@pytest.mark.parametrize(
    ("scene", "wrong"),
    [(Saw(), Saw(rod=0.3 * 1.0001)), (ShearPress(), ShearPress(rod=0.390 * 1.0001))],
    ids=["saw", "press"],
)
def test_prediction_separates_wrong_reference_from_engine(scene: Scene, wrong: Scene) -> None:
    trajectory = run(scene, "mujoco", "hardened")
    assert largest_difference(scene, trajectory, scene)["position"] < 1e-12
    # Negative control: a rod 0.01 % too long in the reference, and the gaps do not account for what is measured.
    assert largest_difference(scene, trajectory, wrong)["position"] > 1e-5


def test_errors_are_taken_at_crank_motion_reached() -> None:
    times = np.linspace(0.0, 0.7 * SAW.period, 50)
    gain = 0.3 * SAW.speed**2
    at = Instants(times, SAW.speed * times + 0.5 * gain * times**2, SAW.speed + gain * times, np.full(50, gain))
    motion, steady = SAW.motion(at.angle, at.rate, at.acceleration), SAW.motion(SAW.speed * times, SAW.speed)
    tracks = {
        name: PointTracks(*(Track(at, getattr(motion.point(name), quantity)) for quantity in QUANTITIES))
        for name in SAW.lengths
    }
    for name, errors in track_errors(tracks, SAW.speed, ExactMotions(SAW)).items():
        for quantity in QUANTITIES:
            assert getattr(errors, quantity).error.max() <= ROUNDING
            assert getattr(errors, quantity).angle is at.angle
            track = getattr(tracks[name], quantity)
            moved = replace(track, values=np.add(track.values, [1.0, -2.0]))
            np.testing.assert_allclose(ExactMotions(SAW).error(track, name, quantity), 0.0, atol=1e-9)
            np.testing.assert_allclose(ExactMotions(SAW).error(moved, name, quantity), [[1.0, -2.0]] * 50, atol=1e-9)
        late = np.linalg.norm(motion.point(name).position - steady.point(name).position, axis=1) / SAW.lengths[name]
        np.testing.assert_allclose(errors.total.error, late, atol=ROUNDING)


def test_nominal_motion_turns_at_the_nominal_speed() -> None:
    times = np.linspace(0.0, 0.7 * SAW.period, 50)
    slow = Instants(times, 0.5 * SAW.speed * times, np.full(50, 0.5 * SAW.speed), np.zeros(50))
    found, steady = ExactMotions(SAW).at_nominal_angle(slow, SAW.speed), SAW.motion(SAW.speed * times, SAW.speed)
    for name in SAW.lengths:
        for quantity in QUANTITIES:
            np.testing.assert_array_equal(getattr(found.point(name), quantity), getattr(steady.point(name), quantity))
