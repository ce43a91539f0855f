"""Colours and marks of runs in the figures of limits: by level, by the decade of the error, by the outcome.

Levels darken from safe to unbounded, so that they can be distinguished in print without colour too.
"""

from __future__ import annotations

import math
from typing import Any

from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from conrod.report.charts.styles import OUTCOME_MARKS
from conrod.report.numbers import ROUNDING
from conrod.runs.trajectory import Outcome
from conrod.studies.limits.grade import ROUGH_ERROR, SAFE_ERROR, Level

LIGHTEST, DARKEST = "#fbfefc", "#9ad2b3"
FIRST, LAST = round(math.log10(ROUNDING)), round(math.log10(SAFE_ERROR))  # decades of a safe error
DECADES = LAST - FIRST
LABELLED = 2  # every so-many-th decade has its number


def _mixed(share: float) -> str:
    mixed = [
        (1.0 - share) * light + share * dark for light, dark in zip(to_rgb(LIGHTEST), to_rgb(DARKEST), strict=True)
    ]
    return to_hex((mixed[0], mixed[1], mixed[2]))


SHADES = tuple(_mixed(k / (DECADES - 1)) for k in range(DECADES))


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


def level_handles(levels: set[str]) -> list[Patch]:
    """Return legend entries of levels, from good to bad, with what they mean."""
    return [
        Patch(facecolor=LEVEL_COLOURS[level.slug], edgecolor="#666666", linewidth=0.4, label=level.slug)
        for level in Level
        if level.slug in levels
    ]


def outcome_handles(outcomes: set[str]) -> list[Line2D]:
    """Return legend entries of ways of ending, in the order of the list of outcomes."""
    return [
        Line2D([], [], label=outcome.slug, **(mark_style(outcome.slug, Level.SAFE.slug)))
        for outcome in Outcome
        if outcome.slug in outcomes and outcome.slug in OUTCOME_MARKS
    ]
