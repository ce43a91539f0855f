"""The machines of document 001 move as the document prints, where it is right; their lengths and senses are its own."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from audits.documents.module_linkages import SIX_BAR_POLYGON, SixBar, least_misfit
from conrod.exact.linkage import LinkMotion, instant_quantities
from conrod.exact.motion import Array
from conrod.scenes import Scene, catalogue_scene


def link_motion(scene: Scene, name: str) -> LinkMotion:
    """Motion of a link; crank angle 0 is the printed instant."""
    links = instant_quantities(scene.kinematics, 0.0, scene.speed).links
    return next(link for link in links if link.link == name)


def turning(scene: Scene, name: str) -> float:
    """Angular velocity of a link [rad/s], counter-clockwise positive."""
    return link_motion(scene, name).rate[2]


def speed(scene: Scene, first: str, second: str | None = None) -> float:
    """Speed of an observed point, or of one against another [m/s]."""
    motion = scene.motion(0.0, scene.speed)
    velocity, other = motion.point(first).velocity, motion.point(second).velocity if second else 0.0
    return float(np.linalg.norm(velocity - other))


def normal(scene: Scene, link: str, first: tuple[float, float], second: tuple[float, float]) -> float:
    """Normal acceleration of a point of a link against another one [m/s^2]."""
    return turning(scene, link) ** 2 * math.dist(first, second)


def last_digit_difference(exact: float, printed: str) -> float:
    """Difference in units of the last printed digit."""
    digits = len(printed.partition(".")[2])
    return (exact - float(printed)) * 10.0**digits


Quantity = Callable[[Scene], float]
# Machine, what of it, as printed, and a length whose 1 % is seen in it.
PRINTED: dict[str, tuple[str, Quantity, str, str]] = {
    "5.1 V_A": ("slider-crank", lambda s: speed(s, "A"), "9", "crank.points.A.x"),
    "5.6 V_A": ("swinging-four-bar", lambda s: speed(s, "A"), "6.6", "crank.points.A.x"),
    "5.6 V_B": ("swinging-four-bar", lambda s: speed(s, "B"), "5.8", "coupler.points.B.x"),
    "5.6 V_B/A": ("swinging-four-bar", lambda s: speed(s, "B", "A"), "6.4", "rocker.points.B.x"),
    "5.6 w2": ("swinging-four-bar", lambda s: turning(s, "crank"), "-60", "speed"),
    "4.10 w2": ("two-slider-linkage", lambda s: turning(s, "crank"), "104.72", "speed"),
    "4.10 V_A": ("two-slider-linkage", lambda s: speed(s, "A"), "14.66", "crank.points.A.x"),
    "4.10 w3": ("two-slider-linkage", lambda s: turning(s, "rod-3"), "-21.88", "rod-3.points.B.y"),
    "4.10 V_B": ("two-slider-linkage", lambda s: speed(s, "B"), "12.69", "crank.points.A.x"),
    "4.10 V_C": ("two-slider-linkage", lambda s: speed(s, "C"), "3.8", "rod-5.points.C.y"),
    "6.15 w2": ("six-bar", lambda s: turning(s, "crank"), "-62.83", "speed"),
    "6.15 V_B": ("six-bar", lambda s: speed(s, "B"), "12.2", "rocker.points.O15.x"),
    "6.18 V_B": ("rack-and-wheel", lambda s: speed(s, "B"), "6", "wheel.points.B.x"),
    "6.18 V_rack": ("rack-and-wheel", lambda s: speed(s, "P"), "6", "speed"),
    "6.18 V_C": ("rack-and-wheel", lambda s: speed(s, "C"), "6.9", "rod.points.C.x"),
    "6.18 V_C/B": ("rack-and-wheel", lambda s: speed(s, "C", "B"), "5", "crank.points.C.x"),
    "6.18 w3": ("rack-and-wheel", lambda s: abs(turning(s, "rod")), "20", "rod.points.C.x"),
    "6.18 w4": ("rack-and-wheel", lambda s: turning(s, "wheel"), "20", "speed"),
    "6.18 A_C^n": ("rack-and-wheel", lambda s: normal(s, "crank", (0.13, 0), (0, 0)), "366.23", "rod.points.C.x"),
    "6.18 A_B/C^n": ("rack-and-wheel", lambda s: normal(s, "rod", (0, 0), (0.25, 0)), "100", "crank.points.C.x"),
}


@pytest.mark.parametrize("number", PRINTED)
def test_machine_reproduces_printed_number(number: str) -> None:
    machine, quantity, printed, length = PRINTED[number]
    scene = catalogue_scene(machine)
    assert abs(last_digit_difference(quantity(scene), printed)) <= 0.5 + 1e-9
    # Negative control: a hundredth of a length, or of the speed, shows in the number long before its last digit.
    name = length if length == "speed" else f"bodies.{length}"
    changed = scene.with_parameters(**{name: 1.01 * scene.parameters[name]})
    exact = quantity(scene)
    assert abs(quantity(changed) - exact) > 1e-3 * abs(exact)


def test_six_bar_motion_satisfies_equations_of_its_bars() -> None:
    scene, bars = catalogue_scene("six-bar"), SixBar()
    motion = scene.motion(0.0, scene.speed)
    for name, key in {"A": "A", "B": "B", "C": "C", "D": "D", "X4": "X"}.items():
        np.testing.assert_allclose(motion.point(name).velocity[0], bars.velocities[key], atol=1e-12 * 60)
        np.testing.assert_allclose(motion.point(name).acceleration[0], bars.accelerations[key], atol=1e-12 * 60**2)
    longer = scene.with_parameters(**{"bodies.rocker.points.O15.x": -0.337})
    moved = longer.motion(0.0, longer.speed).point("C").velocity[0]
    assert np.linalg.norm(moved - bars.velocities["C"]) > 0.01


def test_six_bar_stays_within_stated_distance_of_polygon() -> None:
    scene = catalogue_scene("six-bar")
    names = {"X": "X4"}
    worst = {
        pair: abs(speed(scene, *(names.get(letter, letter) for letter in pair)) - printed)
        for pair, printed in SIX_BAR_POLYGON.items()
    }
    assert max(worst, key=lambda pair: worst[pair]) == "X"
    assert worst["X"] == pytest.approx(1.465, abs=5e-4)
    assert speed(scene, "E") == pytest.approx(13.45, abs=5e-3)
    # No pose of the printed lengths does it without a difference that a reader of the polygon would see.
    assert 0.2 < least_misfit() <= worst["X"]


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


def test_piston_motion_matches_slider_crank_closed_form() -> None:
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
def test_rolling_contact_point_acceleration_matches_document(machine: str) -> None:
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
