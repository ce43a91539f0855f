"""The machines that the audit computes with are those of the catalogue: one geometry, two ways to its motion."""

from __future__ import annotations

import math

import numpy as np
import pytest

from audits.documents import module_velocities as printed
from audits.documents.module_linkages import SIX_BAR_SPEED, RackLinkage, SixBar
from conrod.exact.motion import PointMotion
from conrod.scenes.catalogue import catalogue_scene

SAME = 1e-12


def at_the_instant(name: str) -> dict[str, PointMotion]:
    scene = catalogue_scene(name)
    return dict(scene.motion([0.0], scene.speed).points)


def size(vector: np.ndarray) -> float:
    return float(np.hypot(*vector))


def test_the_six_bar_has_the_catalogues_points_velocities_and_accelerations() -> None:
    bar, points = SixBar(), at_the_instant("six-bar")
    assert catalogue_scene("six-bar").speed == pytest.approx(SIX_BAR_SPEED, rel=SAME)
    assert np.abs(points["X4"].position[0] - bar.auxiliary).max() < SAME
    for name, own in (("A", "A"), ("B", "B"), ("C", "C"), ("D", "D"), ("X4", "X")):
        velocity, acceleration = points[name].velocity[0], points[name].acceleration[0]
        assert np.abs(bar.velocities[own] - velocity).max() < SAME * 100.0
        assert np.abs(bar.accelerations[own] - acceleration).max() < SAME * 1000.0
    # Negative control: an instant 1e-9 rad on is told apart.
    scene = catalogue_scene("six-bar")
    later = scene.motion([1e-9], scene.speed).point("D").velocity[0]
    assert np.abs(bar.velocities["D"] - later).max() > SAME * 100.0


def test_the_rack_linkage_has_the_catalogues_speeds_and_tangential_accelerations() -> None:
    points, linkage = at_the_instant("rack-and-wheel"), RackLinkage()
    b, c = points["B"], points["C"]
    assert size(b.velocity[0]) == pytest.approx(linkage.speed_b, rel=SAME)
    assert size(c.velocity[0]) == pytest.approx(linkage.speed_c, rel=1e-11)
    assert size(c.velocity[0] - b.velocity[0]) == pytest.approx(linkage.relative, rel=1e-11)
    along = c.velocity[0] / size(c.velocity[0])
    rod = (c.velocity - b.velocity)[0] / size(c.velocity[0] - b.velocity[0])
    across_c, across_rod = linkage.tangential(6.0**2 / 0.3)
    assert abs(float(c.acceleration[0] @ along)) == pytest.approx(across_c, rel=1e-11)
    assert abs(float((c.acceleration - b.acceleration)[0] @ rod)) == pytest.approx(across_rod, rel=1e-11)


def test_the_machine_of_two_sliders_has_the_speeds_of_the_instant_centres() -> None:
    points = at_the_instant("two-slider-linkage")
    for name, speed in (("A", printed.V_A), ("B", printed.V_B), ("C", printed.V_C)):
        assert size(points[name].velocity[0]) == pytest.approx(speed, rel=1e-11)


def test_the_swinging_four_bar_has_the_printed_triangle() -> None:
    points = at_the_instant("swinging-four-bar")
    a, b = points["A"].velocity[0], points["B"].velocity[0]
    assert (size(a), size(b), size(b - a)) == pytest.approx((6.6, 5.8, 6.4), rel=1e-11)
    assert size(points["A"].position[0]) == pytest.approx(0.11, abs=SAME)
    assert math.dist(points["A"].position[0], points["B"].position[0]) == pytest.approx(0.21, abs=SAME)
