"""Scales, colours and marks that the figures of limits share."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.charts.canvas import on_grid
from conrod.report.charts.styles import OUTCOME_MARKS
from conrod.runs.trajectory import Outcome
from conrod.studies.limits.axis import Axis, Scale

FEW_DECADES = 4.5  # in which one, two and five have a tick each
MOST_TICKS = 13
UNDETECTED_COLOUR = "#d40000"  # of runs that are wrong and undetected


def places_on(axis: Axis, values: Iterable[float]) -> Array:
    """Places (N,) of values along an axis: themselves, of nearness what is left to one."""
    places = np.array(list(values), dtype=float)
    if axis.scale is Scale.LISTED:
        return on_grid(places, float(np.ptp(places)))
    logs = np.log10(1.0 - places if axis.scale is Scale.NEARNESS else places)
    return np.asarray(10.0 ** on_grid(logs, float(np.ptp(logs))))


def label_of(axis: Axis) -> str:
    """Label for what `places_on` gives."""
    return f"1 - {axis.label}" if axis.scale is Scale.NEARNESS else axis.label


def set_scale(axes: Axes, which: Literal["x", "y"], axis: Axis, begin: float, end: float, room: float = 0.0) -> None:
    """Give one of two axes the scale of an axis of limits, from one place to another, with ticks.

    Args:
        room: beside both ends, of the whole length.
    """
    if axis.listed:
        beside = room * (end - begin)
        axes.set(**{f"{which}lim": (begin - beside, end + beside)})
    else:
        beside = (end / begin) ** room
        axes.set(**{f"{which}scale": "log", f"{which}lim": (begin / beside, end * beside)})
        drawn = axes.xaxis if which == "x" else axes.yaxis
        subs = (1.0, 2.0, 5.0) if abs(math.log10(end / begin)) < FEW_DECADES else (1.0,)
        drawn.set_major_locator(LogLocator(subs=subs, numticks=MOST_TICKS))
        drawn.set_minor_locator(NullLocator())
        drawn.set_major_formatter(FuncFormatter(lambda value, _: numbers.quantity(value)))


def mark_style(outcome: str, undetected: bool, size: float = 4.4) -> dict[str, Any]:
    """Return arguments of `Axes.plot` for the mark of a way of ending; red where nothing shows it."""
    return {
        "linestyle": "none",
        "marker": OUTCOME_MARKS.get(outcome, "."),
        "markersize": size,
        "markeredgewidth": 0.9,
        "color": UNDETECTED_COLOUR if undetected else "#222222",
    }


def outcome_handles(outcomes: set[str]) -> list[Line2D]:
    """Return legend entries of ways of ending, in the order of the list of outcomes."""
    known = [one.slug for one in Outcome if one.slug in outcomes and one.slug in OUTCOME_MARKS]
    return [Line2D([], [], label=one, **mark_style(one, undetected=False, size=5.0)) for one in known]
