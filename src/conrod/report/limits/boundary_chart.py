"""The boundary chart: how far along an axis each engine and preset is safe, and what comes beyond."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from conrod.report.charts.layout import Layout, legend_rows, rows_axis
from conrod.report.charts.styles import OUTCOME_MARKS, preset_title
from conrod.report.limits.marks import (
    LEVEL_COLOURS,
    UNDETECTED_COLOUR,
    AxisScale,
    level_handles,
    mark_style,
    outcome_handles,
)
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.records import Level
from conrod.studies.limits.results import Probe, Walk, stretches

WIDTH, LANE = 9.5, 0.42  # [inch]
LEFT, RIGHT, TOP, BOTTOM = 2.1, 0.25, 0.2, 0.52  # margins [inch]
HALF_BAR, HALF_TICK = 0.27, 0.09  # of a lane
UNDETECTED: dict[str, Any] = {"color": UNDETECTED_COLOUR, "linewidth": 3.2}  # [pt]
BELOW = 0.075  # of a lane
LEGEND_COLUMNS, LEGEND_ROW = 7, 0.19  # [inch]
INSIDE, ABOVE, UP = 5.0, 3.5, 0.46  # marks on a bar and above one that is too narrow for them [pt], of a lane
NARROW = 0.013  # of the width
SEAM, TICK_COLOUR = 0.9, "#555555"  # [pt]
MARK_APART = 0.022  # of the width: closer marks would cover each other


def has_boundaries(walk: Walk) -> bool:
    """Return whether a walk has something between two ends."""
    return bool(walk.boundaries) and len(walk.probes) > 1


def boundary_chart(walks: Sequence[Walk]) -> Figure:
    """Draw a bar along one axis for each engine and preset; one walk at least has boundaries.

    Walks that go both ways from one value share a bar.
    """
    together = [walk for walk in walks if has_boundaries(walk)]
    lanes = list(dict.fromkeys(preset_title(walk.engine, walk.preset) for walk in together))
    axis = AXES[together[0].axis]
    scale = AxisScale.of(axis.scale, together)
    handles = _legend(together)
    layout = Layout(WIDTH, TOP + LEGEND_ROW * legend_rows(handles, LEGEND_COLUMNS) + LANE * len(lanes) + BOTTOM)
    axes = layout.axes(LEFT, BOTTOM, WIDTH - LEFT - RIGHT, LANE * len(lanes))
    for walk in together:
        _draw_walk(axes, scale, lanes.index(preset_title(walk.engine, walk.preset)), walk)
    scale.apply(axes, axis.label)
    rows_axis(axes, lanes)
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")
    axes.spines["left"].set_visible(False)
    layout.legend(handles, LEGEND_COLUMNS, 0.04, columnspacing=1.6)
    return layout.figure


def _draw_walk(axes: Axes, scale: AxisScale, lane: int, walk: Walk) -> None:
    found = stretches(walk)
    edges = _edges(scale, found)
    marked: dict[bool, list[float]] = {True: [], False: []}
    for (shown, *_), (start, end) in zip(found, pairwise(edges), strict=True):
        _draw_stretch(axes, lane, shown, start, end)
        inside, centre = abs(end - start) >= NARROW * scale.span, 0.5 * (start + end)
        free = all(abs(centre - other) >= MARK_APART * scale.span for other in marked[inside])
        if shown.outcome in OUTCOME_MARKS and free:
            marked[inside].append(centre)
            # On its bar, or above one that is too narrow to hold it.
            style = mark_style(shown.outcome, shown.level if inside else Level.SAFE.slug, INSIDE if inside else ABOVE)
            axes.plot([centre], [lane if inside else lane - UP], zorder=5, clip_on=inside, **style)
    for edge, (one, other) in zip(edges[1:-1], pairwise(found), strict=True):
        if one[0].level == other[0].level:
            axes.vlines([edge], lane - HALF_BAR, lane + HALF_BAR, color="white", linewidth=SEAM, zorder=3)
    places = scale.places(probe.value for probe in walk.probes)
    axes.vlines(places, lane - HALF_BAR - HALF_TICK, lane - HALF_BAR, color=TICK_COLOUR, linewidth=0.6, zorder=3)


def _draw_stretch(axes: Axes, lane: int, shown: Probe, start: float, end: float) -> None:
    """A bar of the level's colour, underlined where it is undetected."""
    low, wide = (min(start, end), lane - HALF_BAR), abs(end - start)
    axes.add_patch(Rectangle(low, wide, 2 * HALF_BAR, facecolor=LEVEL_COLOURS[shown.level], linewidth=0.0))
    if shown.undetected:
        axes.plot([start, end], [lane + HALF_BAR + BELOW] * 2, zorder=4, solid_capstyle="butt", **UNDETECTED)


def _edges(scale: AxisScale, found: Sequence[Sequence[Probe]]) -> list[float]:
    """Places where colours change: half-way between the last run of one stretch and the first of the next."""
    ends = [scale.places((alike[0].value, alike[-1].value)) for alike in found]
    middles = [0.5 * (one[1] + other[0]) for one, other in pairwise(ends)]
    return [float(ends[0][0]), *(float(middle) for middle in middles), float(ends[-1][1])]


def _legend(walks: Sequence[Walk]) -> list[object]:
    """Only what occurs."""
    probes = [probe for walk in walks for probe in walk.probes]
    return [
        *level_handles({probe.level for probe in probes}),
        *([Line2D([], [], label="undetected", **UNDETECTED)] if any(probe.undetected for probe in probes) else []),
        *outcome_handles({probe.outcome for probe in probes}),
        Line2D([], [], linestyle="none", marker="|", markersize=5.0, color=TICK_COLOUR, label="a run"),
    ]
