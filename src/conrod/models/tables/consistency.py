"""Columns of a table that contradict its own columns of the quantity that they are the rate of."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from conrod.exact.motion import Array
from conrod.models.tables.columns import AXES, MOTION
from conrod.models.tables.errors import TableComparison

# A change that integrals miss by this share of its normalising size, and by more than noise leaves, is a contradiction.
MAX_MISSED_CHANGE = 0.02
NOISE_FACTOR = 4.0  # standard deviations of noise that are allowed
MIN_ROWS = 8


def contradictory_quantities(table: TableComparison) -> tuple[str, ...]:
    """Names of velocity and acceleration, each if its integral contradicts the table's own columns.

    The trapezoidal rule over the rows is compared with the same rule on the exact motion, so that rows that lie far
    apart do not count: with the table v, a and the exact V, A, |v - v(0) - sum a dt - (V - V(0) - sum A dt)|.
    """
    if len(table.times) < MIN_ROWS:
        return ()
    return tuple(
        rate
        for of, rate in pairwise(MOTION)
        if any(missed > allowed for missed, allowed in _missed_changes(table, of, rate))
    )


def _missed_changes(table: TableComparison, of: str, rate: str) -> Iterator[tuple[float, float]]:
    """Yield by rate column the largest change that its integral misses, and the limit, normalised."""
    for point in table.scene.lengths:
        size = table.normalising_size(of, point)
        for axis in AXES:
            columns = [f"{point}.{MOTION[quantity][0]}{axis}" for quantity in (of, rate)]
            if any(column not in table.values for column in columns):
                continue
            k, exact = AXES.index(axis), table.motion_at_own_crank.point(point)
            off, off_rate = (
                table.values[column] - getattr(exact, quantity)[:, k]
                for column, quantity in zip(columns, (of, rate), strict=True)
            )
            missed = np.abs(off - off[0] - _integral(off_rate, table.times)).max() / size
            step, count = float(np.median(np.diff(table.times))), len(table.times)
            noise = NOISE_FACTOR * (2.0 * noise_of(off) + step * np.sqrt(count) * noise_of(off_rate)) / size
            yield float(missed), MAX_MISSED_CHANGE + noise


def _integral(values: Array, times: Array) -> Array:
    """Integral (T,) of values (T,) from the first time, by the trapezoidal rule."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(times))])


def noise_of(values: Array) -> float:
    """Standard deviation of the noise of a smooth series (T,), from its third differences, whose variance is 20 s^2."""
    return float(np.median(np.abs(np.diff(values, 3)))) / (0.6745 * math.sqrt(20.0))
