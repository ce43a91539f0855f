"""The torque that a drive gives in the exact motion at constant speed, at any crank angle.

By virtual work: what the bodies' inertia and weight take, M q'' - Q, along the motion q' by the crank angle. It is the
multiplier of the driver's equation in `conrod.reactions`, without the joints' reactions, which do no work.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from conrod.engines.left_out_rod import model_form
from conrod.kinematics import Kinematics
from conrod.motion import Array
from conrod.reactions import inertia_forces

PEAK_SAMPLES = 3600  # of a turn


class ExactTorque:
    """Of a linkage as an engine is given it: with or without gravity, and without the mass of links left out.

    Args:
        speed: of the crank [rad/s].
        rod: form of links that carry nothing but two pins, see `ROD_FORMS`.
    """

    def __init__(self, kinematics: Kinematics, speed: float, *, gravity: bool, rod: str) -> None:
        self._kinematics, self._speed = kinematics, speed
        self._form = model_form(kinematics.mechanism, rod)
        given = self._form.mechanism
        self._given = given if gravity else replace(given, gravity=(0.0, 0.0))

    @cached_property
    def peak(self) -> float:
        """Largest magnitude over a turn [N m]."""
        middle, width = np.pi, np.pi
        for _ in range(2):  # once around, and once more about the highest sample, since a peak can be sharp
            angles = middle + width * np.linspace(-1.0, 1.0, PEAK_SAMPLES)
            sizes = np.abs(self.at(angles))
            middle, width = float(angles[np.argmax(sizes)]), 2.0 * width / PEAK_SAMPLES
        return float(sizes.max())

    def at(self, angle: Array) -> Array:
        """Torque (T,) [N m] about the crank, in the sense of the crank angle, at crank angles (T,) [rad]."""
        poses, first, second = (self._form.kept(d) for d in self._kinematics.derivatives(angle, 2))
        forces = inertia_forces(self._given, poses, first * self._speed, second * self._speed**2)
        return np.asarray(np.sum(forces * first, axis=1), dtype=float)
