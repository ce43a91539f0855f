"""The ruler itself: closed forms, the generic solver, and a 50-digit evaluation that knows neither."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
from catalogue import (
    CAMS,
    CAMS_WITH_JOINTS,
    DEFECTIVE_CAMS,
    DEFECTIVE_LINKAGES,
    EVERY_SCENE,
    slow_but_for_a_few,
)
from synthetic import longer_rod, other_branch, turned_crank, with_longer_rod

from conrod.errors import InvalidInput
from conrod.exact import GenericReference
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, Motion, PointMotion
from conrod.mechanism.cam import symmetric_cam
from conrod.runs.outcome import joint_gaps
from conrod.scenes import CamFollower, Saw, Scene, ShearPress

QUANTITIES = ("position", "velocity", "acceleration", "jerk")
TURN = 2.0 * math.pi

# Issue 2: closed form against 50 digits, and the two references against each other.
AGAINST_DIGITS, AGAINST_EACH_OTHER, GAP = 1e-13, 1e-12, 1e-12


def ten_turns(count: int) -> Array:
    """Crank angles over ten revolutions, no two alike within a turn (golden section)."""
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    return np.sort(np.remainder(golden * np.arange(1, count + 1), 1.0)) * 10.0 * TURN


def difference(first: Motion, second: Motion, scene: Scene) -> dict[str, float]:
    """Largest difference of each quantity over all points, normalised by L, omega L, omega^2 L, omega^3 L."""
    worst = dict.fromkeys(QUANTITIES, 0.0)
    for name, length in scene.lengths.items():
        for order, quantity in enumerate(QUANTITIES):
            off = getattr(first.point(name), quantity) - getattr(second.point(name), quantity)
            size = float(np.linalg.norm(off, axis=1).max()) / (length * abs(scene.speed) ** order)
            worst[quantity] = max(worst[quantity], size)
    return worst


def away_from_breaks(scene: Scene, angles: Array, width: float) -> Array:
    """The angles that are farther than `width` [rad] from every break."""
    for angle in scene.break_angles():
        angles = angles[np.abs(np.remainder(angles - angle + math.pi, TURN) - math.pi) > width]
    return angles


# -- the closed forms against 50 digits ------------------------------------------------------------------------------

Coordinates = tuple[mpmath.mpf, mpmath.mpf]


def press_points(scene: ShearPress, t: mpmath.mpf) -> dict[str, Coordinates]:
    """Slider by the cosine rule in the triangle shaft, pin, slider (not by the rod's projection)."""
    r, a = mpmath.mpf(scene.crank), mpmath.mpf(scene.rod)
    # a^2 = r^2 + y^2 - 2 r y cos t, the root above the pin
    p = -2 * r * mpmath.cos(t)
    y = -p / 2 + mpmath.sqrt(p**2 / 4 - (r**2 - a**2))
    pin = (r * mpmath.sin(t), r * mpmath.cos(t))
    return {"A": (mpmath.mpf(0), y), "G": ((2 * pin[0]) / 3, pin[1] + (y - pin[1]) / 3)}


def saw_points(scene: Saw, t: mpmath.mpf) -> dict[str, Coordinates]:
    """Rod by its angle, as document 002's listing has it: theta3b = pi - asin((e - r sin t) / l)."""
    r, rod, e = (mpmath.mpf(v) for v in (scene.crank, scene.rod, scene.offset))
    s0 = mpmath.sqrt(rod**2 - e**2) - r
    turn = mpmath.pi - mpmath.asin((e - r * mpmath.sin(t)) / rod)
    pin = (s0 + r * mpmath.cos(t), r * mpmath.sin(t) - e)
    slider = (pin[0] + rod * mpmath.cos(turn), pin[1] + rod * mpmath.sin(turn))
    return {"C": slider, "M": ((pin[0] + slider[0]) / 2, (pin[1] + slider[1]) / 2)}


def cam_points(scene: CamFollower, t: mpmath.mpf) -> dict[str, Coordinates]:
    """Roller where the line x = 0 meets the circle of radius (arc + roller) about the turned centre of the arc."""
    base, nose, c, r = (
        mpmath.mpf(v) for v in (scene.base_radius, scene.nose_radius, scene.centre_distance, scene.roller_radius)
    )
    flank = mpmath.mpf(scene.flank_radius)
    if abs(flank - (base + nose + c) / 2) <= mpmath.mpf("1e-9"):
        return {"roller": (mpmath.mpf(0), _on_arc(((c + nose - base) / 2, 0), (base + nose + c) / 2 + r, t))}
    # Law of cosines in the triangle of the centres; nose on the cam's +x axis.
    to_base, to_nose = flank - base, flank - nose
    at_shaft = mpmath.acos((c**2 + to_base**2 - to_nose**2) / (2 * c * to_base))
    centre = (to_base * mpmath.cos(at_shaft), -to_base * mpmath.sin(at_shaft))  # of the flank above the axis
    normal = mpmath.atan2(-centre[1], c - centre[0])
    joint = (c + (nose + r) * mpmath.cos(normal), (nose + r) * mpmath.sin(normal))  # roller at flank and nose
    turned = mpmath.fmod(t, 2 * mpmath.pi)
    turned = min(turned, 2 * mpmath.pi - turned)  # the cam is symmetric
    nose_at = mpmath.pi - mpmath.atan2(joint[1], joint[0])
    # Mirrored into the rising half the cam's nose axis is at -90 deg + t, seen from which the roller is above.
    if turned < at_shaft:
        arc = ((mpmath.mpf(0), mpmath.mpf(0)), base + r)
    elif turned < nose_at:
        arc = (centre, flank + r)
    else:
        arc = ((c, mpmath.mpf(0)), nose + r)
    falling = mpmath.fmod(t, 2 * mpmath.pi) > mpmath.pi
    (x, y), reach = arc
    return {"roller": (mpmath.mpf(0), _on_arc((x, -y if falling else y), reach, t))}


def _on_arc(centre: tuple[mpmath.mpf, mpmath.mpf], reach: mpmath.mpf, t: mpmath.mpf) -> mpmath.mpf:
    turn = t - mpmath.pi / 2
    x = centre[0] * mpmath.cos(turn) - centre[1] * mpmath.sin(turn)
    y = centre[0] * mpmath.sin(turn) + centre[1] * mpmath.cos(turn)
    return y + mpmath.sqrt(reach**2 - x**2)


POINTS: dict[type[Scene], Callable[..., dict[str, Coordinates]]] = {
    ShearPress: press_points,
    Saw: saw_points,
    CamFollower: cam_points,
}


def fifty_digits(scene: Scene, angles: Array, speed: float, acceleration: float) -> Motion:
    """Motion at angle + speed t + acceleration t^2 / 2, differentiated in t at t = 0 by mpmath."""
    points = POINTS[type(scene)]
    columns: dict[str, list[list[list[float]]]] = {name: [] for name in scene.lengths}
    with mpmath.workdps(50):
        w, a = mpmath.mpf(speed), mpmath.mpf(acceleration)
        for angle in angles:
            start = mpmath.mpf(float(angle))
            # Every coordinate is differentiated on the same stencil: evaluate all of them there at once.
            at = cache(lambda t, _precision, start=start: points(scene, start + w * t + a * t**2 / 2))
            for name, rows in columns.items():
                rows.append(
                    [
                        [
                            float(d)
                            for d in mpmath.diffs(lambda t, at=at, name=name, k=k: at(t, mpmath.mp.prec)[name][k], 0, 3)
                        ]
                        for k in (0, 1)
                    ]
                )
    return Motion(angles, {name: PointMotion(*np.array(rows).transpose(2, 0, 1)) for name, rows in columns.items()})


@pytest.mark.parametrize("alpha", [0.0, 0.7])
@pytest.mark.parametrize("name", [name for name, scene in EVERY_SCENE.items() if type(scene) in POINTS])
def test_closed_form_matches_fifty_digits_over_ten_revolutions(name: str, alpha: float) -> None:
    scene = EVERY_SCENE[name]
    angles = away_from_breaks(scene, ten_turns(12), 1e-6)
    acceleration = alpha * scene.speed**2
    exact = fifty_digits(scene, angles, scene.speed, acceleration)
    found = difference(scene.motion(angles, scene.speed, acceleration), exact, scene)
    assert max(found.values()) <= AGAINST_DIGITS, found


@pytest.mark.parametrize("scene", [ShearPress(crank=(1.0 - 1e-9) * 0.390), Saw(offset=(1.0 - 1e-9) * 0.2)])
def test_the_closed_form_keeps_eleven_digits_next_to_a_change_point(scene: Scene) -> None:
    """Where `limits` ends its axis of nearness: at the pose of worst condition, and ever closer to it."""
    beside = np.geomspace(1e-9, 0.3, 8)
    angles = np.concatenate([centre + sign * beside for centre in (0.5 * math.pi, 1.5 * math.pi) for sign in (-1, 1)])
    closed, off = scene.motion(angles, 1.0), 0.0
    with mpmath.workdps(50):
        for k, angle in enumerate(angles):
            for name, place in POINTS[type(scene)](scene, mpmath.mpf(float(angle))).items():
                gap = [float(mpmath.mpf(float(closed.point(name).position[k, i])) - place[i]) for i in (0, 1)]
                off = max(off, math.hypot(*gap) / scene.lengths[name])
    assert 1e-13 < off < 1e-11


@pytest.mark.parametrize("name", CAMS)
def test_every_cam_matches_fifty_digits(name: str) -> None:
    cam = CAMS[name]
    angles = away_from_breaks(cam, ten_turns(9), 1e-6)
    found = difference(cam.motion(angles, cam.speed), fifty_digits(cam, angles, cam.speed, 0.0), cam)
    assert max(found.values()) <= AGAINST_DIGITS, found


def test_fifty_digits_catch_a_rod_that_is_a_ten_thousandth_too_long() -> None:
    angles = ten_turns(5)
    for scene in (ShearPress(), Saw()):
        wrong = replace(scene, rod=scene.rod * 1.0001)
        found = difference(wrong.motion(angles, scene.speed), fifty_digits(scene, angles, scene.speed, 0.0), scene)
        assert min(found.values()) > 1e5 * AGAINST_DIGITS, found


def test_fifty_digits_catch_a_cam_turned_by_a_hundredth_degree() -> None:
    cam = CamFollower()
    angles = away_from_breaks(cam, ten_turns(9), 1e-3)
    wrong = cam.motion(angles + math.radians(0.01), cam.speed)
    found = difference(wrong, fifty_digits(cam, angles, cam.speed, 0.0), cam)
    assert min(found.values()) > 1e5 * AGAINST_DIGITS, found


def test_fifty_digits_catch_a_swapped_sign_of_the_angular_acceleration() -> None:
    scene = Saw()
    angles, alpha = ten_turns(5), 0.7 * scene.speed**2
    found = difference(
        scene.motion(angles, scene.speed, -alpha), fifty_digits(scene, angles, scene.speed, alpha), scene
    )
    assert found["position"] <= AGAINST_DIGITS
    assert min(found["acceleration"], found["jerk"]) > 0.1


# -- the closed forms against the generic solver ---------------------------------------------------------------------


def generic_difference(scene: Scene, kinematics: Kinematics, alpha: float = 0.0) -> dict[str, float]:
    angles = away_from_breaks(scene, ten_turns(400), 1e-6)
    acceleration = alpha * scene.speed**2
    return difference(
        scene.motion(angles, scene.speed, acceleration), kinematics.motion(angles, scene.speed, acceleration), scene
    )


@pytest.mark.parametrize("alpha", [0.0, -1.3])
@pytest.mark.parametrize("name", EVERY_SCENE)
def test_closed_form_matches_the_generic_solver_over_ten_revolutions(name: str, alpha: float) -> None:
    scene = EVERY_SCENE[name]
    found = generic_difference(scene, scene.kinematics, alpha)
    assert max(found.values()) <= AGAINST_EACH_OTHER, found


@pytest.mark.parametrize("name", slow_but_for_a_few(CAMS))
def test_every_cam_matches_the_generic_solver(name: str) -> None:
    cam = CAMS[name]
    found = generic_difference(cam, cam.kinematics)
    assert max(found.values()) <= AGAINST_EACH_OTHER, found


LINKAGE_SCENES: dict[str, Any] = {name: s for name, s in EVERY_SCENE.items() if isinstance(s, ShearPress | Saw)}


@pytest.mark.parametrize("name", DEFECTIVE_LINKAGES)
def test_the_generic_solver_catches_a_rod_that_is_a_ten_thousandth_too_long(name: str) -> None:
    scene = LINKAGE_SCENES[name]
    found = generic_difference(scene, longer_rod(scene))
    assert min(found.values()) > 1e5 * AGAINST_EACH_OTHER, found


@pytest.mark.parametrize("name", DEFECTIVE_LINKAGES)
def test_the_generic_solver_stays_on_the_branch_it_is_started_on(name: str) -> None:
    scene = LINKAGE_SCENES[name]
    other = other_branch(scene)
    found = generic_difference(scene, other)
    assert found["position"] > 1.0, found  # the slider is on the far side of the shaft
    assert other.branch(other.start) == -scene.kinematics.branch(scene.kinematics.start)


@pytest.mark.parametrize("name", DEFECTIVE_CAMS)
def test_the_generic_solver_catches_a_cam_turned_by_a_hundredth_degree(name: str) -> None:
    scene = DEFECTIVE_CAMS[name]
    found = generic_difference(scene, turned_crank(scene))
    assert min(found.values()) > 1e5 * AGAINST_EACH_OTHER, found


@pytest.mark.parametrize("name", DEFECTIVE_LINKAGES)
def test_the_generic_solver_catches_a_swapped_sense_of_rotation(name: str) -> None:
    # (A symmetric cam moves its follower alike in both senses: nothing to catch there.)
    scene = LINKAGE_SCENES[name]
    mechanism = scene.mechanism()
    driver = replace(mechanism.driver, sense=-mechanism.driver.sense)
    found = generic_difference(scene, Kinematics(replace(mechanism, driver=driver)))
    assert min(found.values()) > 1e5 * AGAINST_EACH_OTHER, found


@pytest.mark.parametrize("name", slow_but_for_a_few(CAMS_WITH_JOINTS))
def test_both_references_take_the_same_side_at_a_break(name: str) -> None:
    cam = CAMS_WITH_JOINTS[name]
    angles = np.array(cam.break_angles())
    for side in ("left", "right"):
        closed = cam.motion(angles, cam.speed, side=side)
        found = difference(closed, cam.kinematics.motion(angles, cam.speed, side=side), cam)
        assert max(found.values()) <= 10 * AGAINST_EACH_OTHER, (side, found)


def test_a_linkage_that_cannot_turn_is_refused_in_one_line() -> None:
    with pytest.raises(InvalidInput, match="cannot be assembled at crank angle") as refusal:
        Kinematics(with_longer_rod(Saw().mechanism(), 0.6)).motion(np.linspace(0.0, TURN, 9), 1.0)
    assert "\n" not in str(refusal.value)


def test_a_mechanism_with_another_mobility_is_refused() -> None:
    mechanism = Saw().mechanism()
    with pytest.raises(InvalidInput, match="mobility 3"):
        Kinematics(replace(mechanism, joints=mechanism.joints[:-1]))


# -- exact poses in the joints' equations ----------------------------------------------------------------------------


def closed_form_poses(scene: Scene, angles: Array) -> Array:
    """Stacked poses (T, 3 n) made from the observed points of the closed form: no Newton iteration in them."""
    points = {name: p.position for name, p in scene.motion(angles, scene.speed).points.items()}
    zero = np.zeros_like(angles)
    match scene:
        case ShearPress():
            pin = 1.5 * points["G"] - 0.5 * points["A"]
            crank = np.column_stack([zero, zero, math.pi / 2 - angles])
            slider = points["A"]
        case Saw():
            pin = 2.0 * points["M"] - points["C"]
            crank = np.column_stack([zero + scene.shaft[0], zero + scene.shaft[1], angles])
            slider = points["C"]
        case CamFollower():
            cam = np.column_stack([zero, zero, angles - math.pi / 2])
            return np.column_stack([cam, points["roller"], zero])
        case _:
            raise NotImplementedError(f"poses of a {scene.kind} from its observed points")
    along = slider - pin
    rod = np.column_stack([pin, np.arctan2(along[:, 1], along[:, 0])])
    return np.column_stack([crank, rod, slider, zero])


@pytest.mark.parametrize(
    "name", [n for n, s in {**EVERY_SCENE, **CAMS}.items() if isinstance(s, ShearPress | Saw | CamFollower)]
)
def test_exact_poses_leave_nothing_in_any_joint(name: str) -> None:
    scene = {**EVERY_SCENE, **CAMS}[name]
    mechanism = scene.mechanism()
    gaps = joint_gaps(mechanism, [closed_form_poses(scene, ten_turns(1000))])
    assert set(gaps) == {joint.name for joint in mechanism.joints}
    assert max(np.abs(gap).max() for gap in gaps.values()) <= GAP


@pytest.mark.parametrize("name", LINKAGE_SCENES)
def test_a_rod_that_is_a_ten_thousandth_too_long_leaves_just_that_gap(name: str) -> None:
    scene = LINKAGE_SCENES[name]
    poses = closed_form_poses(scene, ten_turns(100))
    gaps = joint_gaps(with_longer_rod(scene.mechanism(), 1.0001), [poses])
    np.testing.assert_allclose(gaps["slider-pin"], 1e-4 * scene.rod, rtol=1e-9)


def test_a_cam_turned_by_a_hundredth_degree_leaves_a_gap() -> None:
    cam = CamFollower()
    poses = closed_form_poses(cam, ten_turns(1000))
    poses[:, 2] += math.radians(0.01)
    assert np.abs(joint_gaps(cam.mechanism(), [poses])["contact"]).max() > 1e6 * GAP


@pytest.mark.parametrize("name", EVERY_SCENE)
def test_gap_rates_and_gap_accelerations_of_the_exact_motion_vanish(name: str) -> None:
    scene = EVERY_SCENE[name]
    angles = away_from_breaks(scene, ten_turns(500), 1e-6)
    derivatives = scene.kinematics.derivatives(angles, 2)
    mechanism = scene.mechanism()
    for order in (1, 2):
        gaps = joint_gaps(mechanism, derivatives[: order + 1])
        assert max(np.abs(gap).max() for gap in gaps.values()) <= 10 * GAP


# -- in time ----------------------------------------------------------------------------------------------------------


# -- normalising lengths ---------------------------------------------------------------------------------------------


def test_normalising_lengths_are_the_strokes() -> None:
    press, saw, cam = ShearPress(), Saw(), CamFollower()
    assert press.lengths["A"] == pytest.approx(2.0 * press.crank, rel=2e-6)
    stroke = math.sqrt((saw.rod + saw.crank) ** 2 - saw.offset**2) - math.sqrt(
        (saw.rod - saw.crank) ** 2 - saw.offset**2
    )
    assert saw.lengths["C"] == pytest.approx(stroke, rel=2e-6)
    assert cam.lengths["roller"] == pytest.approx(0.073, rel=2e-6)  # document 004: largest lift 73 mm


# -- the documents' machines -----------------------------------------------------------------------------------------


def test_the_press_is_where_the_document_has_it() -> None:
    press = ShearPress()
    r, rod = press.crank, press.rod
    at = press.motion([0.0, math.pi / 2, math.pi], press.speed)
    slider, gravity_centre = at.point("A"), at.point("G")
    np.testing.assert_allclose(slider.position[:, 1], [r + rod, math.sqrt(rod**2 - r**2), rod - r], rtol=1e-15)
    np.testing.assert_allclose(slider.position[:, 0], 0.0)
    # At the dead centres the slider's acceleration is r omega^2 (1 +- r / l), towards the middle of the stroke.
    expected = [-r * press.speed**2 * (1.0 + r / rod), r * press.speed**2 * (1.0 - r / rod)]
    np.testing.assert_allclose(slider.acceleration[[0, 2], 1], expected, rtol=1e-14)
    np.testing.assert_allclose(gravity_centre.position[0], [0.0, r + rod / 3.0], rtol=1e-15)
    # Clockwise from the upward vertical: a quarter of a turn later the crank pin, and with it G, is to the right.
    assert gravity_centre.position[1, 0] == pytest.approx(2.0 / 3.0 * r, rel=1e-15)


# -- the cam ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [1.0, -1.0])
@pytest.mark.parametrize("name", CAMS_WITH_JOINTS)
def test_breaks_are_the_four_joints_of_the_arcs(name: str, speed: float) -> None:
    cam = replace(CAMS_WITH_JOINTS[name], speed=speed)
    angles = np.array(cam.break_angles())
    left, right = (cam.motion(angles, speed, side=side).point("roller") for side in ("left", "right"))
    assert len(angles) == 4
    assert np.all(np.diff(angles) > 0.0)
    assert 0.0 < angles[0] < angles[-1] < TURN
    np.testing.assert_allclose(angles + angles[::-1], TURN, rtol=1e-15)  # a symmetric cam
    beside = 1e-6
    before, after = cam.motion(angles - beside, speed), cam.motion(angles + beside, speed)
    # The values on either side are the limits from either side (jerk bounds the way to the limit) ...
    for limit, near in ((left, before.point("roller")), (right, after.point("roller"))):
        assert np.abs(limit.acceleration - near.acceleration).max() <= 1e2 * beside * cam.full_lift
        assert np.abs(limit.jerk - near.jerk).max() <= 1e4 * beside * cam.full_lift
    # ... and they differ, by far more than that.
    assert np.abs(left.acceleration - right.acceleration).max(axis=1).min() > 0.1 * cam.full_lift
    # At the base joints the flank's centre is straight below the roller's path, so that the jerk there is zero.
    jump_of_jerk = np.abs(left.jerk - right.jerk).max(axis=1)
    assert (jump_of_jerk > 0.01 * cam.full_lift).tolist() == [False, True, True, False]


@pytest.mark.parametrize("name", CAMS_WITH_JOINTS)
def test_position_and_velocity_are_continuous_at_the_breaks(name: str) -> None:
    cam = CAMS_WITH_JOINTS[name]
    angles = np.array(cam.break_angles())
    left, right = (cam.motion(angles, cam.speed, side=side).point("roller") for side in ("left", "right"))
    np.testing.assert_allclose(left.position, right.position, rtol=0.0, atol=1e-13 * cam.full_lift)
    np.testing.assert_allclose(left.velocity, right.velocity, rtol=0.0, atol=1e-13 * cam.full_lift)
    # Negative control: had a joint been 0.01 degrees off, velocity would jump there.
    off = angles + math.radians(0.01)
    wrong = _other_arc(cam, angles, off)
    assert np.abs(wrong - cam.motion(off, cam.speed).point("roller").velocity[:, 1]).max() > 1e-6 * cam.full_lift


def _other_arc(cam: CamFollower, joints: Array, angles: Array) -> Array:
    """Velocity at `angles` continued from the arc before the joint, by its Taylor series."""
    left = cam.motion(joints, cam.speed, side="left").point("roller")
    step = angles - joints
    return np.asarray((left.velocity + step[:, None] * left.acceleration)[:, 1])


@pytest.mark.parametrize("speed", [1.0, -20.0])
def test_sides_of_the_reference_are_seen_along_time(speed: float) -> None:
    cam = CamFollower(speed=speed)
    angles = np.array(cam.break_angles()) - (0.0 if speed > 0 else TURN)
    times = angles / speed
    beside = 1e-6 / abs(speed)
    for side, near in (("left", times - beside), ("right", times + beside)):
        at = cam.reference(times, side=side).point("roller").acceleration
        limit = cam.reference(near).point("roller").acceleration
        np.testing.assert_allclose(at, limit, atol=1e-3 * speed**2 * cam.full_lift)
    left, right = (cam.reference(times, side=s).point("roller").acceleration for s in ("left", "right"))
    assert np.abs(left - right).max(axis=1).min() > 0.1 * speed**2 * cam.full_lift


@pytest.mark.parametrize(("base", "off"), [(0.036, -1e-9), (0.056, 0.0), (0.076, 1e-9)])
def test_the_least_flank_radius_makes_one_circle_without_breaks(base: float, off: float) -> None:
    least = 0.5 * (base + 0.029 + 0.080)
    cam = CamFollower(base_radius=base, flank_radius=least + off * (1.0 - 1e-6))
    assert cam.is_one_circle
    assert cam.break_angles() == ()
    # One circle of radius (R + R1 + C) / 2 about (C + R1 - R) / 2: an eccentric, in closed form once more.
    angles = np.linspace(0.0, TURN, 360)
    eccentricity, reach = 0.5 * (0.080 + 0.029 - base), least + cam.roller_radius
    height = -eccentricity * np.cos(angles) + np.sqrt(reach**2 - (eccentricity * np.sin(angles)) ** 2)
    np.testing.assert_allclose(cam.motion(angles, 1.0).point("roller").position[:, 1], height, rtol=1e-14)
    (arc,) = cam.mechanism().cam_contacts[0].profile.arcs
    assert arc.radius == pytest.approx(least, rel=1e-14)
    assert arc.centre == (pytest.approx(eccentricity, rel=1e-14), 0.0)


def test_below_the_least_flank_radius_there_is_no_cam() -> None:
    with pytest.raises(InvalidInput, match=r"flank_radius = 0\.072.* is out of range.*0\.0725 m <= flank_radius"):
        CamFollower(flank_radius=0.0725 - 2e-8)


@pytest.mark.parametrize("name", CAMS)
def test_cams_lift_by_the_documents_amount_and_dwell_at_the_base_circle(name: str) -> None:
    cam = CAMS[name]
    at = cam.motion([0.0, math.pi], cam.speed).point("roller")
    assert at.position[0, 1] == pytest.approx(cam.base_radius + cam.roller_radius, rel=1e-14)
    assert at.position[1, 1] - at.position[0, 1] == pytest.approx(0.109 - cam.base_radius, rel=1e-13)
    if not cam.is_one_circle:
        dwell = cam.joint_angles[0]
        rest = cam.motion(np.linspace(-0.999 * dwell, 0.999 * dwell, 99), cam.speed).point("roller")
        np.testing.assert_array_equal(rest.velocity, 0.0)


@pytest.mark.parametrize("speed", [1.0, -3.0])
@pytest.mark.parametrize("name", CAMS_WITH_JOINTS)
def test_the_least_acceleration_is_just_after_the_joint_of_flank_and_nose(name: str, speed: float) -> None:
    cam = replace(CAMS_WITH_JOINTS[name], speed=speed)
    _, nose_joint = cam.joint_angles
    angles = np.linspace(0.0, math.pi, 20001)
    acceleration = cam.motion(angles, speed).point("roller").acceleration[:, 1]
    just_after = cam.motion([nose_joint], speed).point("roller").acceleration[0, 1]
    just_before = cam.motion([nose_joint], speed, side="left").point("roller").acceleration[0, 1]
    tip = cam.motion([math.pi], speed).point("roller").acceleration[0, 1]
    assert cam.least_acceleration == pytest.approx(just_after, rel=1e-14)
    assert just_after <= acceleration.min() + 1e-9 * abs(just_after)
    assert just_after < tip
    assert just_after < just_before
    assert cam.preload_force == pytest.approx(-25.0 * 0.5 * just_after, rel=1e-14)


@pytest.mark.parametrize("name", CAMS)
def test_the_signed_distance_is_measured_along_the_normal(name: str) -> None:
    profile = CAMS[name].mechanism().cam_contacts[0].profile
    normals = np.linspace(0.0, TURN, 1441)[:-1] + 1e-4
    points = profile.points(normals)
    outward = np.column_stack([np.cos(normals), np.sin(normals)])
    for way in (0.0, 1e-4, 0.009, 0.5, -1e-4, -0.005):
        x, y = (points + way * outward).T
        np.testing.assert_allclose(profile.distance(x, y), way, rtol=0.0, atol=2e-15)
    # Convex: the outline turns left everywhere, once around.
    edges = np.diff(np.vstack([points, points[:1]]), axis=0)
    following = np.roll(edges, -1, axis=0)
    assert np.all(edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] > 0.0)
    # Negative control: a cam turned by 0.01 degrees is not where these points are.
    turn = math.radians(0.01)
    x = points[:, 0] * math.cos(turn) - points[:, 1] * math.sin(turn)
    y = points[:, 0] * math.sin(turn) + points[:, 1] * math.cos(turn)
    assert np.abs(profile.distance(x, y)).max() > 1e-6


def test_a_flank_near_the_least_radius_keeps_its_digits() -> None:
    # The triangle of the centres is nearly flat there; the arcs must still meet.
    for excess in (2e-9, 1e-7, 1e-5):
        arcs = symmetric_cam(0.036, 0.0725 + excess, 0.029, 0.080).arcs
        assert len(arcs) == 4
        for arc, following in zip(arcs, arcs[1:] + arcs[:1], strict=True):
            np.testing.assert_allclose(arc.point(arc.stop), following.point(following.start), rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("scene", [CamFollower(), CamFollower(speed=-2.0), Saw()], ids=["cam", "cam-back", "saw"])
def test_a_generic_reference_has_the_interface_of_a_scene(scene: Scene) -> None:
    generic = GenericReference(scene.mechanism(), scene.speed)
    times = np.linspace(0.0, scene.period, 101)
    for name, length in scene.lengths.items():
        off = scene.reference(times).point(name).acceleration - generic.reference(times).point(name).acceleration
        assert np.abs(off).max() <= 1e-12 * length * scene.speed**2
        assert abs(generic.lengths[name] / length - 1.0) < 1e-3
    np.testing.assert_allclose(scene.break_angles(), generic.break_angles(), rtol=0.0, atol=1e-9)
