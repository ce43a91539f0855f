"""Machines of document 001 that are drawn in symbols or without numbers: they move as its formulas say."""

from __future__ import annotations

import math

import numpy as np
import pytest
from document_machines import link_motion, turning

from conrod.exact.motion import Array
from conrod.scenes.catalogue import catalogue_scene


def turned_angles(values: Array) -> float:
    """How far a direction (T, 2) swings [rad]."""
    return float(np.ptp(np.unwrap(np.arctan2(values[:, 1], values[:, 0]))))


def test_web_cutter_is_a_crank_rocker() -> None:
    scene = catalogue_scene("web-cutter")
    assert scene.kinematics.turns_fully
    assert scene.mechanism().driver.span is None
    motion = scene.motion(np.linspace(0.0, 2.0 * np.pi, 721), scene.speed)
    assert 0.5 < turned_angles(motion.point("C").position - [0.3, 0.0]) < np.pi
    # Negative control: of the crank pin the same measure is a whole turn.
    assert turned_angles(motion.point("B").position) == pytest.approx(2.0 * np.pi)


def test_piston_moves_as_the_closed_form_of_a_slider_crank_says() -> None:
    scene = catalogue_scene("one-cylinder-engine")
    r, rod, angle = 0.03, 0.11, np.linspace(0.0, 2.0 * np.pi, 73)
    sine, root = r * np.sin(angle), np.sqrt(rod**2 - (r * np.sin(angle)) ** 2)
    exact = -r * np.cos(angle) - (r**2 * np.cos(2.0 * angle) * root**2 + (sine * r * np.cos(angle)) ** 2) / root**3
    found = scene.motion(angle, scene.speed).point("B").acceleration[:, 0] / scene.speed**2
    np.testing.assert_allclose(found, exact, atol=1e-14)
    with pytest.raises(AssertionError):
        np.testing.assert_allclose(found, 1.01 * exact, atol=1e-14)


ROLLING = {
    "rolling-on-convex": (0.05, 0.15, 1.0),
    "rolling-on-concave": (0.06, 0.2, -1.0),
    "rolling-on-flat": (0.08, math.inf, 1.0),
}


@pytest.mark.parametrize("machine", ROLLING)
def test_contact_point_of_a_rolling_wheel_has_the_acceleration_of_the_document(machine: str) -> None:
    scene = catalogue_scene(machine)
    r, track, side = ROLLING[machine]
    point, centre = (scene.motion(0.0, scene.speed).point(name) for name in "DC")
    share = 1.0 if math.isinf(track) else track / (track + side * r)
    if not math.isinf(track):
        assert turning(scene, "wheel") == pytest.approx(side * scene.speed * (track + side * r) / r, rel=1e-13)
    expected = turning(scene, "wheel") ** 2 * r * share
    towards = (centre.position[0] - point.position[0]) / r
    assert np.linalg.norm(point.velocity) < 1e-14
    np.testing.assert_allclose(point.acceleration[0], expected * towards, atol=1e-12 * expected)
    # Negative control: a point that is 1 % of the radius off the rim neither stands still nor has that acceleration.
    inner = scene.with_parameters(**{"bodies.wheel.points.D.y": -0.99 * r}).motion(0.0, scene.speed).point("D")
    assert np.linalg.norm(inner.velocity) > 1e-3
    assert abs(np.linalg.norm(inner.acceleration) - expected) > 1e-3 * expected


def test_wheel_on_the_flat_track_is_speeding_up_or_slowing_down_where_it_is_judged() -> None:
    assert abs(link_motion(catalogue_scene("rolling-on-flat"), "wheel").acceleration[2]) > 1.0
