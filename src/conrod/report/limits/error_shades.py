"""The colour of a run in one piece, by the size of its error: a shade for each decade, darker where it is larger."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.patches import Rectangle

from conrod.report.limits.marks import LEVEL_COLOURS
from conrod.report.numbers import ROUNDING
from conrod.studies.limits.grade import ROUGH_ERROR, SAFE_ERROR, Level

LIGHTEST, DARKEST = "#fbfefc", "#9ad2b3"
FIRST, LAST = round(math.log10(ROUNDING)), round(math.log10(SAFE_ERROR))  # decades of a safe error
DECADES = LAST - FIRST
TOLD = 2  # every so-many-th decade has its number


def _mixed(share: float) -> str:
    mixed = [
        (1.0 - share) * light + share * dark for light, dark in zip(to_rgb(LIGHTEST), to_rgb(DARKEST), strict=True)
    ]
    return to_hex((mixed[0], mixed[1], mixed[2]))


SHADES = tuple(_mixed(k / (DECADES - 1)) for k in range(DECADES))


def error_colour(level: str, error: float) -> str:
    """The colour of a run that completed, with its largest position error, normalised."""
    if level != Level.SAFE.slug:
        return LEVEL_COLOURS[level]
    decade = math.floor(math.log10(max(error, ROUNDING))) - FIRST
    return SHADES[min(max(decade, 0), DECADES - 1)]


def draw_scale(axes: Axes) -> None:
    """All shades above each other, with the errors at which they change."""
    colours = (*SHADES, LEVEL_COLOURS[Level.ROUGH.slug], LEVEL_COLOURS[Level.WRONG.slug])
    for k, colour in enumerate(colours):
        axes.add_patch(Rectangle((0.0, k), 1.0, 1.0, facecolor=colour, edgecolor="#888888", linewidth=0.3))
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, len(colours))
    decades = {k - FIRST: f"1e{k}" for k in range(FIRST, LAST, TOLD)}
    ticks = decades | {DECADES: f"{100 * SAFE_ERROR:g} %", DECADES + 1: f"{100 * ROUGH_ERROR:g} %"}
    axes.set_yticks(list(ticks), list(ticks.values()))
    axes.set_xticks([])
    axes.yaxis.tick_right()
    axes.yaxis.set_label_position("right")
    axes.set_ylabel("largest position error / L")
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    axes.tick_params(axis="y", length=2.0, labelsize=8.0)
