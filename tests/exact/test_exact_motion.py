"""The ruler itself: closed forms, the generic solver, and a 50-digit evaluation that knows neither."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest
from catalogue import CAMS, CAMS_WITH_JOINTS, DEFECTIVE_CAMS, DEFECTIVE_LINKAGES, EVERY_SCENE, slow_but_for_a_few
from synthetic import longer_rod, other_branch, turned_crank

from conrod.errors import InvalidInput
from conrod.exact.kinematics import GenericReference, Kinematics
from conrod.exact.motion import WIDTH_DIRECTIONS, Array, Motion, diameter, rotate_planar
from conrod.mechanism.cam import symmetric_cam
from conrod.scenes import SCENES, CamFollower, Saw, Scene, ShearPress

QUANTITIES = ("position", "velocity", "acceleration", "jerk")
TURN = 2.0 * math.pi

# The two references against each other.
AGAINST_EACH_OTHER = 1e-12


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


def slider(scene: ShearPress | Saw, t: mpmath.mpf) -> mpmath.mpf:
    """Where the slider is on its line."""
    r, rod = mpmath.mpf(scene.crank), mpmath.mpf(scene.rod)
    if isinstance(scene, ShearPress):
        return r * mpmath.cos(t) + mpmath.sqrt(rod**2 - (r * mpmath.sin(t)) ** 2)
    e = mpmath.mpf(scene.offset)
    return mpmath.sqrt(rod**2 - e**2) - r + r * mpmath.cos(t) - mpmath.sqrt(rod**2 - (r * mpmath.sin(t) - e) ** 2)


@pytest.mark.parametrize("scene", [ShearPress(crank=(1.0 - 1e-9) * 0.390), Saw(offset=(1.0 - 1e-9) * 0.2)])
def test_closed_form_has_11_digits_near_change_point(scene: ShearPress | Saw) -> None:
    """Where `limits` ends its axis of nearness: at the pose of worst condition, and ever closer to it."""
    beside = np.geomspace(1e-9, 0.3, 8)
    angles = np.concatenate([centre + sign * beside for centre in (0.5 * math.pi, 1.5 * math.pi) for sign in (-1, 1)])
    closed = scene.motion(angles, 1.0).point(scene.output).position.sum(axis=1)  # one of the two is 0
    with mpmath.workdps(50):
        off = [float(mpmath.mpf(c) - slider(scene, mpmath.mpf(t))) for c, t in zip(closed, angles, strict=True)]
    assert 1e-13 < np.abs(off).max() / scene.lengths[scene.output] < 1e-11


def generic_difference(scene: Scene, kinematics: Kinematics, alpha: float = 0.0) -> dict[str, float]:
    angles = away_from_breaks(scene, ten_turns(400), 1e-6)
    acceleration = alpha * scene.speed**2
    return difference(
        scene.motion(angles, scene.speed, acceleration), kinematics.motion(angles, scene.speed, acceleration), scene
    )


@pytest.mark.parametrize("alpha", [0.0, -1.3])
@pytest.mark.parametrize("name", [*EVERY_SCENE, *slow_but_for_a_few(CAMS)])
def test_closed_form_matches_generic_solver_over_ten_turns(name: str, alpha: float) -> None:
    scene = EVERY_SCENE.get(name) or CAMS[name]
    found = generic_difference(scene, scene.kinematics, alpha)
    assert max(found.values()) <= AGAINST_EACH_OTHER, found


@pytest.mark.parametrize(
    ("name", "defect"),
    [*((name, longer_rod) for name in DEFECTIVE_LINKAGES), *((name, turned_crank) for name in DEFECTIVE_CAMS)],
)
def test_generic_solver_detects_longer_rod_and_turned_cam(name: str, defect: Any) -> None:
    scene = EVERY_SCENE[name]
    found = generic_difference(scene, defect(scene))
    assert min(found.values()) > 1e5 * AGAINST_EACH_OTHER, found


@pytest.mark.parametrize("name", DEFECTIVE_LINKAGES)
def test_generic_solver_stays_on_start_branch(name: str) -> None:
    scene = DEFECTIVE_LINKAGES[name]
    other = other_branch(scene)
    found = generic_difference(scene, other)
    assert found["position"] > 1.0, found  # the slider is on the far side of the shaft
    assert other.branch(other.start) == -scene.kinematics.branch(scene.kinematics.start)


@pytest.mark.parametrize("name", slow_but_for_a_few(CAMS_WITH_JOINTS))
def test_both_references_take_the_same_side_at_a_break(name: str) -> None:
    cam = CAMS_WITH_JOINTS[name]
    angles, sides = np.array(cam.break_angles()), []
    np.testing.assert_allclose(angles, cam.kinematics.break_angles, rtol=0.0, atol=1e-9)
    for side in ("left", "right"):
        sides.append(cam.motion(angles, cam.speed, side=side))
        found = difference(sides[-1], cam.kinematics.motion(angles, cam.speed, side=side), cam)
        assert max(found.values()) <= 10 * AGAINST_EACH_OTHER, (side, found)
    jumps = difference(*sides, cam)
    assert max(jumps["position"], jumps["velocity"]) < 1e-12
    assert min(jumps["acceleration"], jumps["jerk"]) > 0.1


def test_a_linkage_that_cannot_turn_is_refused_in_one_line() -> None:
    with pytest.raises(InvalidInput, match="cannot be assembled at crank angle") as refusal:
        longer_rod(Saw(), 0.6).motion(np.linspace(0.0, TURN, 9), 1.0)
    assert "\n" not in str(refusal.value)


def test_a_mechanism_with_another_mobility_is_refused() -> None:
    mechanism = Saw().mechanism()
    with pytest.raises(InvalidInput, match="mobility 3"):
        Kinematics(replace(mechanism, joints=mechanism.joints[:-1]))


def test_normalising_lengths_equal_strokes() -> None:
    press, saw, cam = ShearPress(), Saw(), CamFollower()
    assert press.lengths["A"] == pytest.approx(2.0 * press.crank, rel=2e-6)
    stroke = math.sqrt((saw.rod + saw.crank) ** 2 - saw.offset**2) - math.sqrt(
        (saw.rod - saw.crank) ** 2 - saw.offset**2
    )
    assert saw.lengths["C"] == pytest.approx(stroke, rel=2e-6)
    assert cam.lengths["roller"] == pytest.approx(0.073, rel=2e-6)  # document 004: largest lift 73 mm


def test_press_position_matches_document() -> None:
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


@pytest.mark.parametrize("speed", [1.0, -20.0])
def test_reference_sides_follow_time_at_negative_speed(speed: float) -> None:
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
def test_least_flank_radius_makes_one_circle_without_breaks(base: float, off: float) -> None:
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


@pytest.mark.parametrize("speed", [1.0, -3.0])
@pytest.mark.parametrize("name", CAMS_WITH_JOINTS)
def test_least_acceleration_lies_just_after_flank_joint(name: str, speed: float) -> None:
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


def test_a_flank_near_the_least_radius_keeps_its_digits() -> None:
    # The triangle of the centres is nearly flat there; the arcs must still meet.
    for excess in (2e-9, 1e-7, 1e-5):
        arcs = symmetric_cam(0.036, 0.0725 + excess, 0.029, 0.080).arcs
        assert len(arcs) == 4
        for arc, following in zip(arcs, arcs[1:] + arcs[:1], strict=True):
            np.testing.assert_allclose(arc.point(arc.stop), following.point(following.start), rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("generic", [False, True])
def test_exact_motion_does_not_depend_on_blocks(name: str, generic: bool) -> None:
    scene = SCENES[name]
    ruler = GenericReference(scene.mechanism(), scene.speed) if generic else scene
    angle = np.linspace(-3.0, 9.0, 9001)
    speed, acceleration = scene.speed * (1.0 + 0.1 * np.sin(angle)), 0.3 * scene.speed**2 * np.cos(angle)
    whole = ruler.motion(angle, speed, acceleration)
    for rows in (slice(0, 5), slice(2040, 2060), slice(8188, 8200), slice(8995, 9001)):
        part = ruler.motion(angle[rows], speed[rows], acceleration[rows])
        for point in scene.lengths:
            for order, quantity in enumerate(QUANTITIES):
                values = getattr(whole.point(point), quantity)
                size = scene.lengths[point] * abs(scene.speed) ** order
                np.testing.assert_allclose(values[rows], getattr(part.point(point), quantity), atol=1e-12 * size)


@pytest.mark.parametrize("turned", [0.0, 0.3, 1.2, 3.0])
@pytest.mark.parametrize("flatness", [1.0, 0.5, 1e-3, 0.0])
def test_length_of_a_path_is_its_widest_extent(flatness: float, turned: float) -> None:
    """An ellipse from a circle to a straight line, 4 m long, at any angle."""
    angle = np.linspace(0.0, TURN, 720, endpoint=False)
    path = np.column_stack(
        rotate_planar((2.0 * np.cos(angle), 2.0 * flatness * np.sin(angle)), np.full(len(angle), turned))
    )
    assert diameter(path) == pytest.approx(4.0, rel=2e-6)
    # In no direction is it wider than in those that are looked at.
    ways = np.linspace(0.0, math.pi, WIDTH_DIRECTIONS, endpoint=False)
    widths = np.ptp(np.column_stack([np.cos(ways), np.sin(ways)]) @ path.T, axis=1)
    assert diameter(path) == pytest.approx(widths.max(), rel=1e-15)
