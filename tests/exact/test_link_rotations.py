"""Rotations of links: against the points that links carry, by differences, and their ranges over a revolution."""

from __future__ import annotations

import math

import numpy as np
import pytest

from conrod.exact.link_rotations import link_rotations, rotating_links
from conrod.scenes import scene_named

ANGLES = np.linspace(0.3, 6.0, 41)


def test_saw_rod_rotates_as_its_closed_form_says() -> None:
    """The rod's angle phi obeys l sin(phi) = e - r sin(theta): from the crank pin up to the slide."""
    saw = scene_named("saw-40rpm")
    r, length, e = (saw.parameters[name] for name in ("crank", "rod", "offset"))
    rotation, omega, _ = link_rotations(saw.kinematics, ANGLES, saw.speed)
    sine = (e - r * np.sin(ANGLES)) / length
    rod = saw.kinematics.mechanism.body_index["rod"]
    assert np.abs(np.sin(rotation[:, rod]) - sine).max() < 1e-12
    rate = -r * np.cos(ANGLES) * saw.speed / (length * np.cos(rotation[:, rod]))
    assert np.abs(omega[:, rod] - rate).max() < 1e-12


@pytest.mark.parametrize("name", ["saw-40rpm", "six-bar", "planetary-gear", "geneva"])
def test_rates_are_derivatives_of_the_rotation_in_time(name: str) -> None:
    scene, h = scene_named(name), 1e-4
    low, high = scene.kinematics.span
    angles = np.linspace(low + 0.1 * (high - low), high - 0.1 * (high - low), 17)
    rate, gain = 1.3 * scene.speed, 0.7 * scene.speed**2

    def at(seconds: float) -> tuple[np.ndarray, ...]:  # type: ignore[type-arg]
        turned = angles + rate * seconds + 0.5 * gain * seconds**2
        return link_rotations(scene.kinematics, turned, rate + gain * seconds, gain)

    before, now, after = (at(side * h / abs(scene.speed)) for side in (-1.0, 0.0, 1.0))
    for k in (1, 2):
        slope = (after[k - 1] - before[k - 1]) / (2.0 * h / abs(scene.speed))
        assert np.abs(slope - now[k]).max() < 1e-4 * abs(scene.speed) ** k


def test_wheels_count_on_and_sliders_do_not_rotate() -> None:
    saw = scene_named("saw-40rpm").kinematics
    assert rotating_links(saw) == ("rod",)
    assert saw.rotation_ranges["slider"] < 1e-12
    assert saw.rotation_ranges["crank"] == pytest.approx(2.0 * math.pi)
    gear = scene_named("planetary-gear").kinematics
    start, one, two = (link_rotations(gear, [turns * 2.0 * math.pi], 1.0, order=0)[0][0] for turns in range(3))
    assert one - start == pytest.approx(np.array(list(gear.rotation_ranges.values())) * np.sign(one - start))
    assert two - start == pytest.approx(2.0 * (one - start))
