"""Values along an axis: evenly spaced on its scale, and the one half-way between two.

A quantity that is driven from harmless to hopeless.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from enum import Enum
from typing import ClassVar

from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell

FINE = 0.02  # a boundary is found to two per cent of what its scale measures


def measure_of(scale: Scale, value: float) -> float:
    """What equal steps along a scale are equal steps of."""
    return math.log(1.0 - value) if scale is Scale.NEARNESS else math.log(value)


def spaced(scale: Scale, first: float, last: float, count: int) -> tuple[float, ...]:
    """Different values from the first to the last, evenly along the scale; fewer where whole numbers are fewer."""
    begin, end = measure_of(scale, first), measure_of(scale, last)
    inner = [_value(scale, begin + (end - begin) * k / (count - 1)) for k in range(1, count - 1)]
    return tuple(dict.fromkeys([first, *inner, last]))


def between(scale: Scale, good: float, bad: float) -> float | None:
    """The value half-way; None where the two are within two per cent, or no whole number lies between."""
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


class Scale(Enum):
    """How values of an axis are spaced, and so how they are halved."""

    LOG = "log"  # by ratios
    COUNT = "count"  # whole numbers, by ratios
    NEARNESS = "nearness"  # by ratios of the distance to one
    LISTED = "listed"  # each value stands alone: there is nothing to halve


class Axis(ABC):
    """One axis.

    Attributes:
        name: on the command line.
        title: in the report.
        label: of a figure's axis, with the unit in which values are given.
        harmless, hopeless: its usual ends, in that unit; a listed axis has none. See `spans`.
        allowed: lowest and highest value of a range that may be asked for.
        near_singular: whether it leads to machines whose exact motion itself is ill-conditioned.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    label: ClassVar[str]
    scale: ClassVar[Scale]
    harmless: ClassVar[float]
    hopeless: ClassVar[float]
    allowed: ClassVar[tuple[float, float]]
    near_singular: ClassVar[bool] = False

    @abstractmethod
    def refusal(self, case: Case) -> str | None:
        """None, or why this case does not have the axis."""

    @abstractmethod
    def cell(self, case: Case, value: float) -> LimitCell:
        """The run at a value, or at the nearest one that exists.

        Raises:
            InvalidInput: the machine or the engine cannot be given with this value.
        """

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        """The ways to walk it, each from a harmless value to a hopeless one."""
        if self.scale is Scale.LISTED:
            listed = self.values(case)
            return ((listed[0], listed[-1]),)
        return ((self.harmless, self.hopeless),)

    def values(self, case: Case) -> tuple[float, ...]:
        """All values of a listed axis."""
        raise NotImplementedError(f"{self.name} is not a listed axis")

    def nearest(self, value: float) -> float:
        """The value that is run where this one is asked for; on most axes there are all."""
        return value

    def text(self, case: Case, value: float) -> str:
        """A value as people read it."""
        return f"{value:.4g}"
