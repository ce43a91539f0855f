"""The torque that a drive gives in the exact motion at constant speed, at any crank angle.

By virtual work: what the bodies' inertia and weight take, M q'' - Q, along the motion q' by the crank angle. It is the
multiplier of the driver's equation in `conrod.reactions`, without the joints' reactions, which do no work.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from conrod.dynamics.coordinates import load_forces
from conrod.engines.left_out_rod import model_form
from conrod.kinematics import Kinematics
from conrod.motion import Array
from conrod.reactions import inertia_forces

PEAK_SAMPLES = 3600  # of a turn
# Of what all bodies take that move through the travel in a radian: a drive that takes no more than that takes nothing.
NOTHING = 1e-12


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
        """Largest magnitude over a turn, or over the driver's span [N m]."""
        start, stop = self._kinematics.span
        middle, width = 0.5 * (start + stop), 0.5 * (stop - start)
        for _ in range(2):  # once around, and once more about the highest sample, since a peak can be sharp
            angles = middle + width * np.linspace(-1.0, 1.0, PEAK_SAMPLES)
            if self._kinematics.mechanism.driver.span is not None:
                angles = np.clip(angles, start, stop)
            sizes = np.abs(self.at(angles))
            middle, width = float(angles[np.argmax(sizes)]), 2.0 * width / PEAK_SAMPLES
        return float(sizes.max())

    @cached_property
    def is_nothing(self) -> bool:
        """Whether the drive takes nothing but rounding: wheels about their own centres, and no gravity."""
        mass = sum(body.mass for body in self._given.bodies)
        return self.peak <= NOTHING * mass * (self._kinematics.travel * self._speed) ** 2

    def at(self, angle: Array) -> Array:
        """Torque (T,) [N m] about the crank, in the sense of the crank angle, at crank angles (T,) [rad]."""
        poses, first, second = (self._form.kept(d) for d in self._kinematics.derivatives(angle, 2))
        rates = first * self._speed
        forces = inertia_forces(self._given, poses, rates, second * self._speed**2)
        forces -= load_forces(self._given, poses, rates, angle / self._speed)
        return np.asarray(np.sum(forces * first, axis=1), dtype=float)
