"""Scales of axes: how values are spaced and halved, from even steps to ratios of the distance to one."""

from __future__ import annotations

import math
from enum import Enum

FINE = 0.02  # a boundary is found to two per cent of what its scale measures


class Scale(Enum):
    """Spacing of values on an axis, and so how they are halved."""

    LOG = "log"  # by ratios
    COUNT = "count"  # whole numbers, by ratios
    NEARNESS = "nearness"  # by ratios of the distance to one
    LISTED = "listed"  # each value stands alone: there is nothing to halve


def measure_of(scale: Scale, value: float) -> float:
    """Return what equal steps along a scale are equal steps of."""
    return math.log(1.0 - value) if scale is Scale.NEARNESS else math.log(value)


def spaced(scale: Scale, first: float, last: float, count: int) -> tuple[float, ...]:
    """Return values from the first to the last, evenly along the scale; fewer where whole numbers are fewer."""
    begin, end = measure_of(scale, first), measure_of(scale, last)
    inner = [_value(scale, begin + (end - begin) * k / (count - 1)) for k in range(1, count - 1)]
    return tuple(dict.fromkeys([first, *inner, last]))


def between(scale: Scale, good: float, bad: float) -> float | None:
    """Return the value half-way; None where the two are within two per cent, or no whole number lies between."""
    begin, end = measure_of(scale, good), measure_of(scale, bad)
    if abs(end - begin) <= math.log1p(FINE):
        return None
    middle = _value(scale, 0.5 * (begin + end))
    return None if middle in (good, bad) else middle


def _value(scale: Scale, measure: float) -> float:
    match scale:
        case Scale.COUNT:
            return float(round(math.exp(measure)))
        case Scale.NEARNESS:
            return -math.expm1(measure)
        case _:
            return math.exp(measure)
