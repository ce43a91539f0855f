"""An axis along which an engine is driven to its limits: its scale, its ends, and the run at a value."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from conrod.studies.limits.case import LimitCase, Setup

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


def _value(scale: Scale, measure: float) -> float:
    match scale:
        case Scale.COUNT:
            return float(round(math.exp(measure)))
        case Scale.NEARNESS:
            return -math.expm1(measure)
        case _:
            return math.exp(measure)


# -- an axis -----------------------------------------------------------------------------------------------------------

EXPONENT = re.compile(r"(?<=\d)e(?:\+|(-))0*(\d)")
Spans = tuple[tuple[float, float], ...]  # each from a safe value to a failing one


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis.

    Attributes:
        name: on the command line.
        title: in the report.
        label: of a figure's axis, with the unit in which values are given.
        case: the run at a value, or at the nearest one that exists; raises InvalidInput where the machine or the engine
            cannot be given with this value.
        safe_end, failing_end: its usual ends; a listed axis has none.
        allowed: lowest and highest value of a range that may be asked for.
        lacks: why a setup does not have the axis, or None.
        ends: usual ends on a setup, where they depend on it or where there are several ways.
        values: all values of a listed axis.
        text: a value as people read it.
        nearest: the value that is run where this one is asked for; on most axes there are all.
    """

    name: str
    title: str
    label: str
    scale: Scale
    case: Callable[[Setup, float], LimitCase]
    safe_end: float = math.nan
    failing_end: float = math.nan
    allowed: tuple[float, float] = (-math.inf, math.inf)
    lacks: Callable[[Setup], str | None] = lambda setup: None
    ends: Callable[[Setup], Spans] | None = None
    values: Callable[[Setup], tuple[float, ...]] = lambda setup: ()
    text: Callable[[Setup, float], str] = lambda setup, value: f"{value:.4g}"
    nearest: Callable[[float], float] = lambda value: value

    @property
    def listed(self) -> bool:
        """True where each value stands alone."""
        return self.scale is Scale.LISTED

    def refusal(self, setup: Setup) -> str | None:
        """Return None, or why this setup does not have the axis."""
        reason = self.lacks(setup)
        return None if reason is None else f"{reason}: {self.name} does not apply"

    def readable(self, setup: Setup, value: float) -> str:
        """Return the text of a value, powers of ten as figures have them: 1e6 for 1e+06."""
        return EXPONENT.sub(r"e\1\2", self.text(setup, value))

    def between(self, good: float, bad: float) -> float | None:
        """Return the value half-way; None where the two are within two per cent, or none that exists lies between."""
        begin, end = measure_of(self.scale, good), measure_of(self.scale, bad)
        middle = self.nearest(_value(self.scale, 0.5 * (begin + end)))
        return None if abs(end - begin) <= math.log1p(FINE) or middle in (good, bad) else middle

    def spans(self, setup: Setup) -> Spans:
        """Return the ways to walk it."""
        if self.listed:
            values = self.values(setup)
            return ((values[0], values[-1]),)
        return ((self.safe_end, self.failing_end),) if self.ends is None else self.ends(setup)
