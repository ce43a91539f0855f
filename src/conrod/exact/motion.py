"""Exact motion of observed points: position, velocity, acceleration and jerk."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conrod.errors import Named

Array = NDArray[np.float64]

Side = Literal["left", "right"]

# A function of the crank angle with its first three derivatives at T angles: arrays (T,), or numbers where it is
# constant.
Derivatives: TypeAlias = Sequence[Array | float]
PointDerivatives: TypeAlias = tuple[Derivatives, Derivatives]  # of x and of y [m]

# An angle this close to a break counts as the break, so that rounding of speed x time cannot choose the side.
BREAK_WIDTH = 1e-9  # [rad]
# In which widths of a set of points are taken, and how many at a time.
DIRECTIONS, TOGETHER = 1440, 16
KEPT = 1 << 20  # numbers, 8 MB


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
        """Motion of the observed point of a name; UnknownName, with the choices, if there is none."""
        return self.points[name]


def motion_in_time(
    derivatives: Callable[[Array], Mapping[str, PointDerivatives]],
    angle: Array,
    speed: ArrayLike,
    acceleration: ArrayLike,
    length: int,
) -> Motion:
    """Motion in time from derivatives by the crank angle, at constant angular acceleration (chain rule).

    Args:
        derivatives: those of all observed points at given crank angles.
        angle: crank angles (T,) [rad].
        speed: crank speed [rad/s], a number or (T,).
        acceleration: crank angular acceleration [rad/s^2], a number or (T,).
        length: samples that are computed together.
    """
    # Zeros in one block of memory cost the system least; all x stand together and all y.
    found: defaultdict[str, Array] = defaultdict(lambda: np.zeros((4, 2, len(angle))))
    rates = [np.asarray(value, dtype=float) for value in (speed, acceleration)]
    for rows in cache_blocks(len(angle), length):
        w, turning = (np.broadcast_to(one, angle.shape)[rows] if one.ndim else one for one in rates)
        powers: tuple[Array | float, ...] = (1.0, w, w**2, w**3)
        for name, planar in derivatives(angle[rows]).items():
            for axis, along in enumerate(planar):
                filled = found[name][:, axis, rows]
                for zeros, values, factor in zip(filled, along, powers, strict=True):
                    # What stays zero is not touched, which spares the system its memory.
                    if isinstance(values, np.ndarray) or values != 0.0:
                        np.multiply(values, factor, out=zeros)
                if turning.ndim or turning != 0.0:
                    filled[2] += along[1] * turning
                    filled[3] += 3.0 * along[2] * w * turning
    points = {name: PointMotion(*motion.transpose(0, 2, 1)) for name, motion in found.items()}
    return Motion(angle, Named(points, "observed point"))


def hermite(at: Array, values: Array, slopes: Array, where: Array) -> Array:
    """Cubic Hermite interpolation (T, n) at places (T,) of values and slopes (K, n) at growing places (K,)."""
    left = np.clip(np.searchsorted(at, where, side="right") - 1, 0, len(at) - 2)
    width = (at[left + 1] - at[left])[:, None]
    t = (where - at[left])[:, None] / width
    start, stop = values[left], values[left + 1]
    rise = stop - start
    a, b = width * slopes[left] - rise, rise - width * slopes[left + 1]
    return np.asarray(start + t * rise + t * (1.0 - t) * ((1.0 - t) * a + t * b))


def turned(way: tuple[Array | float, Array | float], turn: Array) -> tuple[Array, Array]:
    """A way (x, y) of a body's frame in the document's directions, at turns (T,) [rad]."""
    cosine, sine = np.cos(turn), np.sin(turn)
    return cosine * way[0] - sine * way[1], sine * way[0] + cosine * way[1]


def diameter(points: Array) -> float:
    """Largest distance between any two of the points (N, 2), up to a relative 2e-6.

    The largest width over directions equals the diameter of a set; so many directions miss it by at most
    1 - cos(pi / 2880) = 6e-7.
    """
    directions = np.linspace(0.0, np.pi, DIRECTIONS, endpoint=False)
    across, flat = np.column_stack([np.cos(directions), np.sin(directions)]), np.ascontiguousarray(points.T)
    # A few directions at a time: what they make of all points then fits the cache.
    widths = [np.ptp(across[k : k + TOGETHER] @ flat, axis=1).max() for k in range(0, DIRECTIONS, TOGETHER)]
    return float(max(widths))


def cache_blocks(count: int, length: int) -> Iterator[slice]:
    """Slices of at most `length` that cover a series of `count` samples, in order; an empty one if it has none.

    In blocks whose intermediate arrays stay in a core's own cache a long series takes less time than all at once.
    """
    # The GNU C library hands freed memory back to the system at once, and has it cleared page by page when it is next
    # needed, which takes as long as the arithmetic; but it keeps up to twice the largest block that was ever freed.
    np.empty(KEPT)
    for first in range(0, max(count, 1), length):
        yield slice(first, min(first + length, count))
