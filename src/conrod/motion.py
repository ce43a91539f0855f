"""Exact motion of observed points: position, velocity, acceleration and jerk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Side = Literal["left", "right"]

# An angle this close to a break counts as the break, so that rounding of speed x time cannot choose the side.
BREAK_WIDTH = 1e-9  # [rad]


@dataclass(frozen=True)
class PointMotion:
    """Motion of one point; each array is (T, 2) in m, m/s, m/s^2, m/s^3."""

    position: Array
    velocity: Array
    acceleration: Array
    jerk: Array


@dataclass(frozen=True)
class Motion:
    """Motion of all observed points at given crank angles."""

    angle: Array  # (T,) [rad]
    points: Mapping[str, PointMotion]

    def point(self, name: str) -> PointMotion:
        """Motion of the observed point of a name; KeyError if there is none."""
        return self.points[name]


@dataclass(frozen=True)
class Break:
    """A crank angle where the acceleration or the jerk of a point jumps, with the values on both sides."""

    angle: float  # [rad], in [0, 2 pi)
    point: str
    left_acceleration: Array  # (2,) [m/s^2]
    right_acceleration: Array  # (2,) [m/s^2]
    left_jerk: Array  # (2,) [m/s^3]
    right_jerk: Array  # (2,) [m/s^3]


def point_motion(derivatives: tuple[Array, Array, Array, Array], speed: Array, acceleration: Array) -> PointMotion:
    """Motion in time from derivatives by the crank angle, at constant angular acceleration (chain rule).

    Args:
        derivatives: x, x', x'', x''' by the crank angle, each (T, 2) [m].
        speed: crank speed (T,) [rad/s].
        acceleration: crank angular acceleration (T,) [rad/s^2].
    """
    x, x1, x2, x3 = derivatives
    w, a = speed[:, None], acceleration[:, None]
    return PointMotion(x, x1 * w, x2 * w**2 + x1 * a, x3 * w**3 + 3.0 * x2 * w * a)


def breaks_between(left: Motion, right: Motion) -> tuple[Break, ...]:
    """Breaks from the motion on both sides of the same angles."""
    return tuple(
        Break(
            float(angle),
            name,
            left.point(name).acceleration[i],
            right.point(name).acceleration[i],
            left.point(name).jerk[i],
            right.point(name).jerk[i],
        )
        for i, angle in enumerate(right.angle)
        for name in right.points
    )


def diameter(points: Array) -> float:
    """Largest distance between any two of the points (N, 2), up to a relative 2e-6.

    The largest width over directions equals the diameter of a set; 1440 directions miss it by at most
    1 - cos(pi / 2880) = 6e-7.
    """
    directions = np.linspace(0.0, np.pi, 1440, endpoint=False)
    along = points @ np.vstack([np.cos(directions), np.sin(directions)])
    return float(np.ptp(along, axis=0).max())
