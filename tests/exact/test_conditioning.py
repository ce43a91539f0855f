"""Near a change point the ruler itself has few digits: how few is told by fifty of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import mpmath
import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW
from test_exact_motion import POINTS

from conrod.exact.motion import Array, PointDerivatives, Side
from conrod.scenes import Saw, Scene, ShearPress
from conrod.studies.limits.conditioning import USUAL, closed_form_error, fifty_digits, reference_error, worst_angles

ANGLES = np.array([0.3, 1.5707, 2.2, 4.7123, 5.9])
OFF = 1e-11  # planted, relative


def press(distance: float) -> ShearPress:
    return ShearPress(crank=(1.0 - distance) * 0.390)


def saw(distance: float) -> Saw:
    return Saw(offset=(1.0 - distance) * 0.2)


NEAR = {f"{make.__name__}-{d:g}": make(d) for make in (press, saw) for d in (1e-2, 1e-6, 1e-9)}


@pytest.mark.parametrize("name", NEAR)
def test_fifty_digits_of_the_joint_equations_are_those_of_the_closed_form(name: str) -> None:
    scene = NEAR[name]
    told = fifty_digits(scene, ANGLES)
    with mpmath.workdps(50):
        for k, angle in enumerate(ANGLES):
            for point, (x, y) in POINTS[type(scene)](scene, mpmath.mpf(float(angle))).items():
                off = math.hypot(float(told[point][k, 0] - x), float(told[point][k, 1] - y))
                # Some lengths of the mechanism (place of the shaft, directions) are rounded themselves.
                assert off <= 2e-16 * scene.kinematics.size, (point, angle)


@pytest.mark.parametrize("make", [press, saw])
def test_the_closed_form_loses_digits_as_the_change_point_nears(make: type) -> None:
    """Position by the root of the distance."""
    near, nearer = closed_form_error(make(1e-5)), closed_form_error(make(1e-9))
    assert 30.0 <= nearer / near <= 300.0  # 100
    assert USUAL < nearer < 1e-11
    assert reference_error(make(1e-9)) == nearer


@pytest.mark.parametrize("scene", [PRESS, SAW, CAM], ids=lambda scene: scene.kind)
def test_machines_as_they_are_have_all_their_digits(scene: Scene) -> None:
    assert closed_form_error(scene) <= 1e-14
    assert reference_error(scene) is None


@dataclass(frozen=True)
class LongerRod(Saw):
    """A closed form whose rod is not the mechanism's."""

    def _angle_derivatives(self, angle: Array, side: Side) -> Mapping[str, PointDerivatives]:
        return Saw(rod=self.rod * (1.0 + OFF))._angle_derivatives(angle, side)


def test_a_closed_form_with_a_wrong_rod_is_caught() -> None:
    assert closed_form_error(LongerRod()) > 0.3 * OFF


@pytest.mark.parametrize(("scene", "centres"), [(press(1e-9), (90.0, 270.0)), (saw(1e-9), (270.0,))])
def test_angles_crowd_where_the_linkage_nearly_gains_a_freedom(scene: Scene, centres: tuple[float, ...]) -> None:
    angles = worst_angles(scene)
    assert len(angles) < 60
    for centre in centres:
        assert np.sum(np.abs(angles - math.radians(centre)) < math.sqrt(2e-9)) >= 5
