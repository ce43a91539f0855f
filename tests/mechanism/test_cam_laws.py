"""Cams made from motion laws: their exact motion is the law's, and their profile is the roller's envelope."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from described import CATALOGUE, tables

from conrod.engines import engine_named
from conrod.engines.cam_polygon import cam_polygon
from conrod.errors import InvalidInput
from conrod.mechanism.cam import DWELL, HARMONIC, LAWS, Segment, symmetric_cam
from conrod.mechanism.cam_law import LawProfile, can_roll, check_undercut, concave_reason
from conrod.mechanism.units import REVOLUTION
from conrod.scenes import catalogue_scene
from conrod.scenes.described_scene import DescribedScene, scene_from_tables
from conrod.studies.limits.changed_machines import dead_centre_angles
from conrod.studies.validation.kinematic_mode import validate_kinematic

MOVING = tuple(law for law in LAWS if law != DWELL)
CAMS = tuple(f"cam-{law}" for law in MOVING)
LIFT, RISE = 0.033, math.radians(120.0)


def profile(law: str, **changed: Any) -> LawProfile:
    dwell = Segment(DWELL, REVOLUTION / 2.0 - RISE, 0.0)
    segments = (Segment(law, RISE, LIFT), dwell, Segment(law, RISE, -LIFT), dwell)
    return replace(LawProfile(0.076, 0.009, segments), **changed)


def changed_profile(name: str, **fields: Any) -> dict[str, Any]:
    """A shipped file with other fields of its profile."""
    given = tables(CATALOGUE / f"{name}.toml")
    given["joints"]["contact"]["profile"] |= fields
    return given


@pytest.mark.parametrize("law", MOVING)
def test_law_derivatives_match_differences_of_lift(law: str) -> None:
    x, step = np.linspace(0.02, 0.98, 193), 1e-5
    for order in range(5):
        told = LAWS[law](x, order + 1)
        quotient = (LAWS[law](x + step, order) - LAWS[law](x - step, order)) / (2.0 * step)
        assert np.abs(quotient - told).max() < 1e-8 * (2.0 * math.pi) ** (order + 4)
        # Negative control: the next law's derivative is another one.
        other = LAWS[MOVING[MOVING.index(law) - 1]](x, order + 1)
        assert np.abs(quotient - other).max() > 1e-2


def worst_difference(scene: DescribedScene, law: LawProfile) -> float:
    """Of the generic solver's motion from a law's own derivatives, over the lift; to jerk."""
    angle = np.linspace(0.0, REVOLUTION, 997) + 0.01
    point, own = scene.motion(angle, 1.0).point("roller"), law.lift(angle, 3)
    found = [point.position - [0.0, law.prime_radius], point.velocity, point.acceleration, point.jerk]
    return max(float(np.abs(f - np.column_stack([0.0 * s, s])).max()) for f, s in zip(found, own, strict=True)) / LIFT


@pytest.mark.parametrize("name", CAMS[:2])
def test_generic_solver_reproduces_law_derivatives_to_jerk(name: str) -> None:
    scene = catalogue_scene(name)
    law = scene.mechanism().cam_contacts[0].profile
    assert isinstance(law, LawProfile)
    assert worst_difference(scene, law) < 1e-12
    # Negative control: a lift off by a millionth is seen.
    wrong = replace(law, segments=tuple(replace(s, lift=s.lift * (1.0 + 1e-6)) for s in law.segments))
    assert worst_difference(scene, wrong) > 1e-7


@pytest.mark.parametrize("name", CAMS)
def test_break_angles_are_where_acceleration_or_jerk_jumps(name: str) -> None:
    scene = catalogue_scene(name)
    law = name.removeprefix("cam-")
    at = [] if law == "4-5-6-7" else [0.0, 120.0, 180.0, 300.0]
    np.testing.assert_allclose(np.degrees(scene.break_angles()), at, rtol=0.0, atol=1e-7)
    size = LIFT / RISE**2
    if at:
        angles = np.array(scene.break_angles())
        before, after = (scene.motion(angles, 1.0, side=side).point("roller") for side in ("left", "right"))
        jump = np.abs(after.acceleration - before.acceleration)[:, 1]
        assert np.all(jump > size) if law == HARMONIC else np.all(jump < 1e-6 * size)
        assert law == HARMONIC or np.all(np.abs(after.jerk - before.jerk)[:, 1] > size / RISE)


@pytest.mark.parametrize(("offset", "sense"), [(0.012, 1), (-0.02, -1)])
def test_offset_follower_follows_the_law(offset: float, sense: int) -> None:
    way, height = "counter-clockwise" if sense > 0 else "clockwise", math.sqrt(0.085**2 - offset**2)
    cam = changed_profile("cam-3-4-5", offset=offset, sense=way)
    cam["ground"] = {"points": {"line": [-offset, 0.0]}}
    cam["joints"]["guide"]["guide"] = "ground.line"
    cam["start"] = {"follower": {"origin": [-offset, height]}}
    cam["driver"]["sense"] = way
    scene = scene_from_tables(cam)
    angle = np.linspace(0.0, REVOLUTION, 499) + 0.01
    point, own = scene.motion(angle, 1.0).point("roller"), profile("3-4-5").lift(angle, 3)
    np.testing.assert_allclose(point.position[:, 0], -offset, rtol=0.0, atol=1e-15)
    found = (point.position[:, 1] - height, point.velocity[:, 1], point.acceleration[:, 1], point.jerk[:, 1])
    assert max(float(np.abs(f - s).max()) for f, s in zip(found, own, strict=True)) < 1e-12 * LIFT * 10.0


@pytest.mark.parametrize(("law", "offset"), list(zip(MOVING, (0.0, 0.012) * 2, strict=True)))
def test_profile_is_envelope_of_roller(law: str, offset: float) -> None:
    cam = profile(law, offset=offset)
    angle = np.linspace(0.0, REVOLUTION, 400, endpoint=False) + 1e-3
    rim, centres, normals = cam.points(angle), cam.pitch(angle).points, cam.pitch(angle).normals
    distance = np.hypot(*(rim[:, None, :] - centres[None, :, :]).transpose(2, 0, 1))
    np.testing.assert_allclose(distance.diagonal(), cam.roller_radius, rtol=0.0, atol=1e-16)
    assert distance.min() > cam.roller_radius - 1e-12
    tangents = (cam.points(angle + 1e-6) - cam.points(angle - 1e-6)) / 2e-6
    assert np.abs(np.sum(tangents * normals, axis=1)).max() < 1e-9
    # Negative control: normals of another law do not fit.
    other = profile(MOVING[MOVING.index(law) - 1], offset=offset).pitch(angle).normals
    assert np.abs(np.sum(tangents * other, axis=1)).max() > 1e-4


@pytest.mark.parametrize("law", MOVING[:2])
def test_cam_polygon_is_within_its_stated_depth(law: str) -> None:
    cam = profile(law)
    assert cam.is_convex
    for inset in (0.0, 0.9 * cam.least_radius):
        polygon = cam_polygon(cam, 400, inset)
        dense = (
            cam.points(np.linspace(0.0, REVOLUTION, 20001))
            - inset * cam.pitch(np.linspace(0.0, REVOLUTION, 20001)).normals
        )
        edges = np.roll(polygon.vertices, -1, axis=0) - polygon.vertices
        outward = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.hypot(*edges.T)[:, None]
        over = np.max(dense @ outward.T - np.sum(polygon.vertices * outward, axis=1), axis=1)
        # How far the curve stands out of the polygon, or stays within it, by the nearest facet.
        assert -polygon.error * (1.0 + 1e-6) <= over.min() < 0.0 < over.max() <= polygon.error * (1.0 + 1e-6)
        assert over.max() > 0.9 * polygon.error  # the bound is no loose one
        turned = edges[:, 0] * np.roll(edges, -1, axis=0)[:, 1] - edges[:, 1] * np.roll(edges, -1, axis=0)[:, 0]
        assert np.all(turned > 0.0)


def test_undercut_cam_is_refused_with_least_base_radius() -> None:
    small = profile("4-5-6-7", base_radius=0.001, roller_radius=0.06)
    assert not can_roll(small)
    with pytest.raises(InvalidInput, match=r"undercuts the cam.*base_radius of at least") as refused:
        check_undercut(small)
    enough = float(str(refused.value).split("at least ")[1].split(" m")[0])
    check_undercut(replace(small, base_radius=enough * 1.001))
    assert not can_roll(replace(small, base_radius=enough * 0.99))


def test_engines_refuse_hollow_cam_as_not_convex() -> None:
    scene = scene_from_tables(changed_profile("cam-4-5-6-7", base_radius="30 mm"))
    reason = concave_reason(scene.mechanism().cam_contacts[0].profile)
    assert reason is not None
    assert "hollow" in reason
    enough = float(reason.split("at least ")[1].split(" m")[0])
    assert concave_reason(profile("4-5-6-7", base_radius=enough)) is None
    for name in ("mujoco", "pymunk"):
        result = validate_kinematic("hollow", scene, engine_named(name))
        assert (result.outcome, result.reason) == ("unsupported", reason)
    assert concave_reason(symmetric_cam(0.036, 0.118, 0.029, 0.080)) is None


RISES, FALLS = {"law": "3-4-5", "over": 2.0, "lift": 0.01}, {"law": "3-4-5", "over": 2.0, "lift": -0.01}
REFUSED = {
    "turn": ([RISES, FALLS, {"law": "dwell", "over": 1.0}], "over adds up to 286.478898 deg"),
    "lift": ([RISES, FALLS | {"lift": -0.009}, {"law": "dwell"}], "lift adds up to 0.001 m"),
    "two lifts": ([{"law": "3-4-5", "over": 3.0}, {"law": "cycloidal"}], "lift is left out of 2 segments"),
    "law": ([RISES | {"law": "3-4-6"}], "did you mean '3-4-5'"),
    "dwell": ([RISES, FALLS, {"law": "dwell", "lift": 0.0}], "unknown field"),
    "nothing left": ([RISES | {"over": 3.1}, FALLS | {"over": 3.18}, {"law": "dwell"}], "at least 1 deg"),
    "none": ([], "a list of 1 to 100 segments"),
    "too low": ([RISES | {"lift": -0.09}, FALLS | {"lift": 0.09}, {"law": "dwell"}], "would reach the shaft"),
    "undercut": ([RISES | {"over": 0.3, "lift": 0.05}, FALLS | {"lift": -0.05}, {"law": "dwell"}], "undercuts"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_invalid_cam_is_refused_in_one_line(case: str) -> None:
    segments, told = REFUSED[case]
    with pytest.raises(InvalidInput) as refused:
        scene_from_tables(changed_profile("cam-3-4-5", segments=segments))
    assert told in str(refused.value)
    assert "joints.contact.profile" in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_engine_distance_places_follower_within_shape_error(engine: str) -> None:
    result = validate_kinematic("cam", catalogue_scene("cam-cycloidal"), engine_named(engine))
    assert result.passed
    assert result.errors is not None
    assert result.errors["roller"]["position"]["max"] > 0.1 * result.tolerance.position  # type: ignore[index,operator]


@pytest.mark.parametrize("name", CAMS[:2])
def test_dwell_is_no_dead_centre(name: str) -> None:
    # Where a rise and a fall meet without a dwell, there is one.
    assert dead_centre_angles(catalogue_scene(name)) == ()
    rise = {"law": name.removeprefix("cam-"), "over": "150 deg", "lift": "33 mm"}
    peaked = scene_from_tables(changed_profile(name, segments=[rise, rise | {"lift": "-33 mm"}, {"law": "dwell"}]))
    assert dead_centre_angles(peaked) == pytest.approx((150.0,), abs=1e-3)
