"""Axes, colours and marks that the figures of limits share.

Levels darken from safe to unbounded, so that they can be distinguished in print without colour too.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from conrod.exact.motion import Array
from conrod.report.charts.canvas import on_grid
from conrod.report.charts.styles import OUTCOME_MARKS
from conrod.report.numbers import ROUNDING
from conrod.runs.trajectory import Outcome
from conrod.studies.limits.records import ROUGH_ERROR, SAFE_ERROR, Level
from conrod.studies.limits.results import Walk
from conrod.studies.limits.scale import Scale

MOST_TICKS = 13
ROOM = 0.02  # beside the ends, of the whole length
ROUND = (1.0, 2.0, 5.0)
LIGHTEST, DARKEST = "#fbfefc", "#9ad2b3"
FIRST, LAST = round(math.log10(ROUNDING)), round(math.log10(SAFE_ERROR))  # decades of a safe error
DECADES = LAST - FIRST
LABELLED = 2  # every so-many-th decade has its number


SHADES = tuple(map(to_hex, np.linspace(to_rgb(LIGHTEST), to_rgb(DARKEST), DECADES)))


# -- colours and marks ------------------------------------------------------------------------------------------------


def error_colour(level: str, error: float) -> str:
    """Return the colour of a run that completed, with its largest position error, normalised."""
    if level != Level.SAFE.slug:
        return LEVEL_COLOURS[level]
    decade = math.floor(math.log10(max(error, ROUNDING))) - FIRST
    return SHADES[min(max(decade, 0), DECADES - 1)]


def draw_scale(axes: Axes) -> None:
    """Draw all shades above each other, with the errors at which they change."""
    colours = (*SHADES, LEVEL_COLOURS[Level.ROUGH.slug], LEVEL_COLOURS[Level.WRONG.slug])
    for k, colour in enumerate(colours):
        axes.add_patch(Rectangle((0.0, k), 1.0, 1.0, facecolor=colour, edgecolor="#888888", linewidth=0.3))
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, len(colours))
    decades = {k - FIRST: f"1e{k}" for k in range(FIRST, LAST, LABELLED)}
    ticks = decades | {DECADES: f"{100 * SAFE_ERROR:g} %", DECADES + 1: f"{100 * ROUGH_ERROR:g} %"}
    axes.set_yticks(list(ticks), list(ticks.values()))
    axes.set_xticks([])
    axes.yaxis.tick_right()
    axes.yaxis.set_label_position("right")
    axes.set_ylabel("largest position error / L")
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    axes.tick_params(axis="y", length=2.0, labelsize=8.0)


LEVEL_COLOURS = {
    Level.SAFE.slug: "#d9efe2",
    Level.ROUGH.slug: "#ecd060",
    Level.WRONG.slug: "#e6862a",
    Level.BROKEN.slug: "#a03c5e",
    Level.UNBOUNDED.slug: "#332f45",
}
DARK = (Level.BROKEN.slug, Level.UNBOUNDED.slug)
# Of runs that are wrong and undetected.
UNDETECTED_COLOUR = "#d40000"


def mark_style(outcome: str, level: str, size: float = 5.0) -> dict[str, Any]:
    """Return arguments of `Axes.plot` for the mark of a way of ending, on the colour of a level."""
    hue = "white" if level in DARK else "black"
    return {
        "linestyle": "none",
        "marker": OUTCOME_MARKS[outcome],
        "markersize": size,
        "color": hue,
        "markeredgewidth": 1.1,
        "markeredgecolor": hue,
    }


def outcome_handles(outcomes: set[str]) -> list[Line2D]:
    """Return legend entries of ways of ending, in the order of the list of outcomes."""
    return [
        Line2D([], [], label=outcome.slug, **(mark_style(outcome.slug, Level.SAFE.slug)))
        for outcome in Outcome
        if outcome.slug in outcomes and outcome.slug in OUTCOME_MARKS
    ]


# -- the scale of an axis ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class AxisScale:
    """The scale that some walks of one axis share.

    Attributes:
        low, high: smallest and largest place of a value.
        falling: whether values fall from the safe end to the failing one.
    """

    scale: Scale
    low: float
    high: float
    falling: bool

    @classmethod
    def of(cls, scale: Scale, walks: Sequence[Walk]) -> AxisScale:
        """Return the scale that holds all probes; walks both ways from one value have the smaller values left."""
        places = [place(scale, probe.value) for walk in walks for probe in walk.probes]
        ways = {walk.falling for walk in walks if len(walk.probes) > 1}
        return cls(scale, min(places), max(places), ways == {True})

    @property
    def span(self) -> float:
        """Length of the axis, in its own places."""
        return self.high - self.low

    def places(self, values: Iterable[float]) -> Array:
        """Return the places (N,) of some values, on the grid that is drawn."""
        return on_grid(np.array([place(self.scale, value) for value in values]), self.span)

    def apply(self, axes: Axes, label: str) -> None:
        """Give the horizontal axis its ends, its ticks and its label."""
        room = max(ROOM * (self.high - self.low), 1e-3)
        ends = (self.low - room, self.high + room)
        axes.set_xlim(*(reversed(ends) if self.falling else ends))
        axes.set_xticks(*self.ticks())
        axes.set_xlabel(label)

    def ticks(self) -> tuple[list[float], list[str]]:
        """Return places of ticks, and their texts."""
        values = self._round_values()
        return [place(self.scale, value) for value in values], [tick_text(self.scale, value) for value in values]

    def _round_values(self) -> list[float]:
        """Return round values between the ends: one, two and five of each decade, or decades where these are many."""
        if self.scale is Scale.LISTED:
            step = next(s for s in (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 1e9) if self.span / s <= MOST_TICKS)
            return [step * k for k in _whole(self.low / step, self.high / step)]
        if self.scale is Scale.NEARNESS:
            nines = [1.0 - 10.0**-k for k in _whole(max(1.0, self.low), self.high)]
            return [0.1, *nines] if self.low < 0.1 else nines
        decades = range(math.floor(self.low), math.ceil(self.high) + 1)
        fine = [m * 10.0**k for k in decades for m in ROUND if self._holds(math.log10(m) + k)]
        if len(fine) <= MOST_TICKS:
            return fine
        whole = [10.0**k for k in decades if self._holds(k)]
        every = -(-len(whole) // MOST_TICKS)
        # Counted from one, which every long axis has in it.
        return [value for value in whole if round(math.log10(value)) % every == 0]

    def _holds(self, where: float) -> bool:
        return self.low - 1e-9 <= where <= self.high + 1e-9


def _whole(low: float, high: float) -> range:
    """Whole numbers between two."""
    return range(math.ceil(low - 1e-9), math.floor(high + 1e-9) + 1)


def place(scale: Scale, value: float) -> float:
    """Return where a value stands: decades for numbers, decades of the distance to one for nearness, else the value."""
    if scale is Scale.LISTED:
        return value
    return -math.log10(1.0 - value) if scale is Scale.NEARNESS else math.log10(value)


def tick_text(scale: Scale, value: float) -> str:
    """Return a round value, short."""
    if scale is Scale.NEARNESS and value > 0.9991:
        return f"1 - 1e{round(math.log10(1.0 - value))}"
    if scale is Scale.LISTED or 1e-3 < value < 99999.0:
        return f"{value:.6g}"
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")
