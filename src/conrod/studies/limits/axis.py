"""Axis along which an engine is driven to its limits: scale, ends, and run at a value."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from conrod.studies.limits.case import LimitCase, Setup

BOUNDARY_WIDTH = 0.02  # a boundary is found to this share of a value; on a scale of nearness, of 1 - value


class Scale(Enum):
    """Spacing of values on an axis, which defines the midpoint of two values."""

    LOG = "log"  # by ratios
    COUNT = "count"  # whole numbers, by ratios
    NEARNESS = "nearness"  # by ratios of the distance to one
    LISTED = "listed"  # separate values without midpoints


def scale_coordinate(scale: Scale, value: float) -> float:
    """Return the coordinate of a value on a scale: ln(value), or ln(1 - value) for nearness."""
    return math.log(1.0 - value) if scale is Scale.NEARNESS else math.log(value)


def spaced_values(scale: Scale, first: float, last: float, count: int) -> tuple[float, ...]:
    """Return values that are evenly spaced on a scale; fewer if whole numbers do not suffice."""
    begin, end = scale_coordinate(scale, first), scale_coordinate(scale, last)
    inner = [_value_at_coordinate(scale, begin + (end - begin) * k / (count - 1)) for k in range(1, count - 1)]
    return tuple(dict.fromkeys([first, *inner, last]))


def _value_at_coordinate(scale: Scale, coordinate: float) -> float:
    """Return the value at a coordinate, the inverse of `scale_coordinate`."""
    match scale:
        case Scale.COUNT:
            return float(round(math.exp(coordinate)))
        case Scale.NEARNESS:
            return -math.expm1(coordinate)
        case _:
            return math.exp(coordinate)


# -- an axis -----------------------------------------------------------------------------------------------------------

EXPONENT = re.compile(r"(?<=\d)e(?:\+|(-))0*(\d)")
Spans = tuple[tuple[float, float], ...]  # each from a safe value to a failing one


@dataclass(frozen=True, eq=False)
class Axis:
    """An axis of `conrod limits`: a property of a run that is varied until the engine fails.

    Attributes:
        name: name on the command line.
        title: title in the report.
        label: label of a figure's axis, with the unit of the values.
        scale: spacing of the values.
        case: returns the run at a value, or at the nearest possible value; raises InvalidInput if machine or engine
            cannot have this value.
        safe_end, failing_end: usual ends; a listed axis has none.
        allowed: lowest and highest value of a range that a user may ask for.
        missing_reason: returns why a setup does not have the axis, None if it does.
        ends: returns the ends of each walk on a setup, if they depend on the setup or if there are several walks.
        values: returns all values of a listed axis.
        text: returns a value as text for people.
        nearest: returns the possible value nearest to a requested one.
    """

    name: str
    title: str
    label: str
    scale: Scale
    case: Callable[[Setup, float], LimitCase]
    safe_end: float = math.nan
    failing_end: float = math.nan
    allowed: tuple[float, float] = (-math.inf, math.inf)
    missing_reason: Callable[[Setup], str | None] = lambda setup: None
    ends: Callable[[Setup], Spans] | None = None
    values: Callable[[Setup], tuple[float, ...]] = lambda setup: ()
    text: Callable[[Setup, float], str] = lambda setup, value: f"{value:.4g}"
    nearest: Callable[[float], float] = lambda value: value

    @property
    def listed(self) -> bool:
        """True if the axis has a list of values instead of a range."""
        return self.scale is Scale.LISTED

    def refusal(self, setup: Setup) -> str | None:
        """Return why a setup does not have the axis, None if it does."""
        reason = self.missing_reason(setup)
        return None if reason is None else f"{reason}: {self.name} does not apply"

    def value_text(self, setup: Setup, value: float) -> str:
        """Return the text of a value, with powers of ten as in figures: 1e6 for 1e+06."""
        return EXPONENT.sub(r"e\1\2", self.text(setup, value))

    def midpoint(self, good: float, bad: float) -> float | None:
        """Return the value midway between two, None if they are within 2 % or adjacent."""
        begin, end = scale_coordinate(self.scale, good), scale_coordinate(self.scale, bad)
        middle = self.nearest(_value_at_coordinate(self.scale, 0.5 * (begin + end)))
        return None if abs(end - begin) <= math.log1p(BOUNDARY_WIDTH) or middle in (good, bad) else middle

    def spans(self, setup: Setup) -> Spans:
        """Return the ends of each walk along the axis on a setup."""
        if self.listed:
            values = self.values(setup)
            return ((values[0], values[-1]),)
        return ((self.safe_end, self.failing_end),) if self.ends is None else self.ends(setup)
