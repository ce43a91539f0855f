"""Exact motion of observed points: position, velocity, acceleration and jerk."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conrod.errors import Named

Array = NDArray[np.float64]

Side = Literal["left", "right"]

QUANTITIES = ("position", "velocity", "acceleration")  # of a point, that engines are compared in

# A function of the crank angle with its first three derivatives at T angles: arrays (T,), or numbers where it is
# constant.
Derivatives: TypeAlias = Sequence[Array | float]
PointDerivatives: TypeAlias = tuple[Derivatives, Derivatives]  # of x and of y [m]

# An angle this close to a break counts as the break, so that rounding of speed x time cannot choose the side.
BREAK_WIDTH = 1e-9  # [rad]
WIDTH_DIRECTIONS, DIRECTIONS_TOGETHER = 1440, 16  # directions in which widths are measured, and how many at once
NEAR_WIDEST = 0.02  # share of the largest width by which one may be less for those beside it to be measured
FREED_NUMBERS = 1 << 20  # 8 MB; see `cache_blocks`


@dataclass(frozen=True)
class Instants:
    """Sample times and the crank's motion at these times, each (T,)."""

    times: Array  # [s]
    angle: Array  # [rad], the crank angle in the document's sense
    rate: Array  # [rad/s]
    acceleration: Array  # [rad/s^2]

    def __getitem__(self, keep: slice | NDArray[Any]) -> Instants:
        return Instants(self.times[keep], self.angle[keep], self.rate[keep], self.acceleration[keep])


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
        """Motion of an observed point by name; UnknownName lists the choices for an unknown name."""
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
        derivatives: gives derivatives of all observed points at crank angles.
        angle: crank angles (T,) [rad].
        speed: crank speed [rad/s], a number or (T,).
        acceleration: crank angular acceleration [rad/s^2], a number or (T,).
        length: number of samples that are computed together.
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


def hermite_interpolation(at: Array, values: Array, derivatives: Array, where: Array) -> Array:
    """Cubic Hermite interpolation (T, n) at places (T,).

    Args:
        at: ascending places (K,).
        values, derivatives: there (K, n).
        where: places (T,) to interpolate at.
    """
    left = np.clip(np.searchsorted(at, where, side="right") - 1, 0, len(at) - 2)
    width = (at[left + 1] - at[left])[:, None]
    t = (where - at[left])[:, None] / width
    start, stop = values[left], values[left + 1]
    rise = stop - start
    a, b = width * derivatives[left] - rise, rise - width * derivatives[left + 1]
    return np.asarray(start + t * rise + t * (1.0 - t) * ((1.0 - t) * a + t * b))


def rotate_planar(vector: tuple[Array | float, Array | float], turn: Array) -> tuple[Array, Array]:
    """Rotate a vector (x, y) of a body's frame by angles (T,) [rad] into the document's directions."""
    cosine, sine = np.cos(turn), np.sin(turn)
    return cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]


def diameter(points: Array) -> float:
    """Largest distance between any two of the points (N, 2), up to a relative 2e-6.

    The largest width over all directions equals the diameter of a set; the directions tried miss it by at most
    1 - cos(pi / 2880) = 6e-7.
    """
    directions = np.linspace(0.0, np.pi, WIDTH_DIRECTIONS, endpoint=False)
    across, flat = np.column_stack([np.cos(directions), np.sin(directions)]), np.ascontiguousarray(points.T)

    def widths(some: Array) -> Array:
        """Widths of the points in some directions, a few at a time, so that all projections fit the cache."""
        blocks = range(0, len(some), DIRECTIONS_TOGETHER)
        return np.concatenate([np.ptp(some[k : k + DIRECTIONS_TOGETHER] @ flat, axis=1) for k in blocks])

    middle = widths(across[DIRECTIONS_TOGETHER // 2 :: DIRECTIONS_TOGETHER])
    # A width changes by at most the diameter times the angle between directions: 8 pi / 1440 to the one in the middle.
    near = ~(middle < (1.0 - NEAR_WIDEST) * middle.max())
    return float(widths(across.reshape(-1, DIRECTIONS_TOGETHER, 2)[near].reshape(-1, 2)).max())


def cache_blocks(count: int, length: int) -> Iterator[slice]:
    """Yield slices of at most `length` that cover `count` samples in order; one empty slice for a count of 0.

    Blocks whose intermediate arrays fit a core's cache take less time than a long series at once.
    """
    # The GNU C library hands freed memory back to the system at once, and has it cleared page by page when it is next
    # needed, which takes as long as the arithmetic; but it keeps up to twice the largest block that was ever freed.
    np.empty(FREED_NUMBERS)
    for first in range(0, max(count, 1), length):
        yield slice(first, min(first + length, count))
