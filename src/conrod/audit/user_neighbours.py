"""What printed values beside a printed value make of it: its components or its size, and the rows before and after."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from conrod.audit.judging import Neighbour
from conrod.audit.user_rows import Row
from conrod.motion import Array

# Rows that a value is interpolated from: more reach farther from it and spoil it if one of them is wrong.
NEAREST = (4, 2)
DECISIVE = 2.0


def neighbours(row: Row, rows: Sequence[Row]) -> Iterator[Neighbour]:
    """All that other rows of a table say about one.

    Args:
        rows: of the same machine and point.
    """
    yield from _of_components(row, rows)
    yield from _of_rows(row, rows)


def _of_components(row: Row, rows: Sequence[Row]) -> Iterator[Neighbour]:
    """The size from both components, or a component from the size and the other."""
    beside = {
        other.axis: other
        for other in rows
        if other is not row and (other.derivative, other.degrees) == (row.derivative, row.degrees)
    }
    others = [beside.get(axis) for axis in ("x", "y", "size") if axis != row.axis]
    if None in others:
        return
    first, second = (_converted(other, row) for other in others if other is not None)
    halves = [0.5 * other.item.number.last * row.factor / other.factor for other in others if other is not None]
    text = " beside ".join(f"{other.item.quantity} = {other.item.number.text}" for other in others if other is not None)
    if row.axis == "size":
        yield Neighbour(text, math.hypot(first, second), sum(halves))
    elif second > abs(first):
        # The size comes last; the sign is the print's own.
        value = math.copysign(math.sqrt(second**2 - first**2), row.item.number.value)
        yield Neighbour(text, value, (second * halves[1] + abs(first) * halves[0]) / abs(value))


def _converted(other: Row, row: Row) -> float:
    """Another row's print in the unit of this one."""
    return other.item.number.value * row.factor / other.factor


def _of_rows(row: Row, rows: Sequence[Row]) -> Iterator[Neighbour]:
    """The value interpolated from the nearest rows of the same quantity, one print at each angle.

    Lagrange's polynomial through the printed values; how far it may be off is what rounding of the prints does to it,
    and what the same polynomial through the exact values leaves.
    """
    series = {o.degrees: o for o in rows if o.group == row.group and o.degrees != row.degrees}
    for count in NEAREST:
        near = sorted(sorted(series, key=lambda degrees: abs(degrees - row.degrees))[:count])
        # Only between rows on both sides: beyond the last one a polynomial knows nothing.
        if len(near) < count or not near[0] < row.degrees < near[-1]:
            continue
        some = [series[degrees] for degrees in near]
        weights = _lagrange(np.array(near), row.degrees)
        value = float(weights @ [other.item.number.value for other in some])
        rounding = float(np.abs(weights) @ [0.5 * other.item.number.last for other in some])
        curve = abs(float(weights @ [other.exact for other in some]) - row.exact)
        # A contradiction as large as what the polynomial itself may be off proves nothing.
        if abs(value - row.item.number.value) > DECISIVE * (rounding + curve):
            told = ", ".join(f"{degrees:g}" for degrees in near)
            yield Neighbour(f"interpolation between the rows at {told} deg", value, rounding + curve)


def _lagrange(places: Array, at: float) -> Array:
    """Weights (N,) of the values at N places in the value of their polynomial at another place."""
    apart = places[:, None] - places[None, :]
    np.fill_diagonal(apart, 1.0)
    reach = np.where(np.eye(len(places), dtype=bool), 1.0, at - places[None, :])
    return np.asarray(np.prod(reach / apart, axis=1))
