"""A machine driven at constant speed and its exact motion, which engines run and are compared with."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Motion, Side
from conrod.mechanism.mechanism import Mechanism


class ExactReference(ABC):
    """The exact motion of a mechanism as a function of the crank angle, and of time at constant speed.

    The motion comes from the generic solver (`Kinematics`) unless a subclass knows it in closed form.
    """

    speed: float  # crank speed [rad/s]; the crank angle is speed x time

    @abstractmethod
    def mechanism(self) -> Mechanism:
        """The declarative description, source of the generic solver and of the engines' models."""

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0, side: Side = "right") -> Motion:
        """Return the exact motion of all observed points at crank angles.

        Args:
            angle: crank angles (T,) [rad].
            speed: crank speed [rad/s], a number or (T,).
            acceleration: crank angular acceleration [rad/s^2], constant in time if the jerk is used.
            side: the limit to take where the acceleration jumps, seen along increasing crank angle.
        """
        return self.kinematics.motion(angle, speed, acceleration, side)

    def break_angles(self) -> tuple[float, ...]:
        """Crank angles [rad] in [0, 2 pi) at which the acceleration or the jerk jumps."""
        return self.kinematics.break_angles

    @property
    def lengths(self) -> Mapping[str, float]:
        """Travel L [m] of each observed point: the largest distance between two of its exact positions.

        Position errors are divided by it (docs/design.md, 'Errors have names').
        """
        return self.kinematics.lengths

    @property
    def period(self) -> float:
        """Time of one crank revolution [s]."""
        return 2.0 * np.pi / abs(self.speed)

    @cached_property
    def kinematics(self) -> Kinematics:
        """The generic solver of this mechanism."""
        return Kinematics(self.mechanism())

    def reference(self, times: ArrayLike, side: Side = "right") -> Motion:
        """Return the exact motion at times (T,) [s] at constant speed; `side` is seen along increasing time."""
        backward: Side = "left" if side == "right" else "right"
        seen = side if self.speed > 0 else backward
        return self.motion(self.speed * np.atleast_1d(np.asarray(times, dtype=float)), self.speed, 0.0, seen)


@dataclass(frozen=True)
class GenericReference(ExactReference):
    """A mechanism without a closed form, solved by Newton iteration on its joint equations."""

    described: Mechanism
    speed: float

    def mechanism(self) -> Mechanism:
        return self.described
