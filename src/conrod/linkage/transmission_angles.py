"""Transmission and pressure angles of the driven links, with their extremes over all poses."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from conrod.kinematics import Kinematics
from conrod.linkage.course import Course
from conrod.linkage.state import LinkageState
from conrod.motion import Array
from conrod.transmission import Push, pushes

# An extreme is closed in upon by so many parts of its interval, so many times: to rounding of its value.
PARTS, TIMES = 16, 10


@dataclass(frozen=True)
class Extreme:
    """A value [rad] and the crank angle [rad] where it is taken."""

    value: float
    angle: float


@dataclass(frozen=True)
class TransmissionAngle:
    """The transmission angle of a driven link.

    Attributes:
        driven: the link.
        through: the rod, block or cam that pushes it.
        least, greatest: of the angle in [0, pi] between the line of the push and the normal of the path, over all poses
            (`conrod.transmission.Push.angle`).
    """

    driven: str
    through: str
    least: Extreme
    greatest: Extreme

    @property
    def worst(self) -> Extreme:
        """The least acute transmission angle (Alt): at zero the linkage is locked."""
        other = Extreme(math.pi - self.greatest.value, self.greatest.angle)
        return min(self.least, other, key=lambda extreme: extreme.value)

    @property
    def greatest_pressure_angle(self) -> Extreme:
        """A right angle less the worst transmission angle."""
        return Extreme(0.5 * math.pi - self.worst.value, self.worst.angle)


def transmission_angles(course: Course) -> tuple[TransmissionAngle, ...]:
    """Of every driven link that is guided by the ground; empty where none is pushed by a rod, a block or a cam."""
    found = []
    samples = pushes(course.kinematics, course.samples)
    for k, push in enumerate(samples):
        angles = partial(_angle, course, k)
        least, greatest = _least(course, push.angle, angles, 1.0), _least(course, push.angle, angles, -1.0)
        found.append(TransmissionAngle(push.driven, push.through, least, greatest))
    return tuple(sorted(found, key=lambda angle: (angle.driven, angle.through)))


def pushes_at(kinematics: Kinematics, state: LinkageState) -> list[Push]:
    """The pushes in the pose of a state, by driven link; their arrays have one row."""
    return sorted(pushes(kinematics, state.derivatives[0]), key=lambda push: (push.driven, push.through))


def _angle(course: Course, k: int, parameter: Array) -> Array:
    return pushes(course.kinematics, course.poses(parameter))[k].angle


def _least(course: Course, samples: Array, at: Callable[[Array], Array], sign: float) -> Extreme:
    """The value that is least times a sign, from those at the samples and between them."""
    parameter, values = course.parameter, sign * samples
    k = int(values.argmin())
    low, high = float(parameter[max(k - 1, 0)]), float(parameter[min(k + 1, len(parameter) - 1)])
    if course.periodic and k in {0, len(parameter) - 1}:
        low, high = -float(parameter[1]), float(parameter[1])
    value, place = float(values[k]), float(parameter[k])
    for _ in range(TIMES):
        some = np.linspace(low, high, PARTS + 1)
        here = sign * at(some)
        j = int(here.argmin())
        if here[j] < value:
            value, place = float(here[j]), float(some[j])
        low, high = float(some[max(j - 1, 0)]), float(some[min(j + 1, PARTS)])
    angle = float(course.crank_angle(course.poses(np.array([place])))[0])
    return Extreme(sign * value, angle % (2.0 * math.pi) if course.periodic else angle)
