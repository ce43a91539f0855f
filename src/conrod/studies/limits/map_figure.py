"""Heat map of a pair of axes: the error of each run, where runs fail and how, and where they are undetected."""

from __future__ import annotations

import math
import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Rectangle
from matplotlib.path import Path
from numpy.typing import NDArray

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.charts.canvas import add_legend_above
from conrod.report.charts.styles import preset_title
from conrod.report.numbers import ROUNDING
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.charts import (
    UNDETECTED_COLOUR,
    axis_label,
    axis_places,
    mark_style,
    outcome_handles,
    set_scale,
)
from conrod.studies.limits.maps import LimitMap, MapRun, map_class
from conrod.studies.limits.records import GOOD_LEVELS, ROUGH_ERROR, SAFE_ERROR, Level

SIZE, SCALE = (9.5, 5.3), 46  # of the figure [inch], and width of the map over the width of the scale
LEGEND_COLUMNS = 5
LABEL_WIDTH = 44  # letters
BOUNDARY: dict[str, Any] = {"color": "#111111", "linewidth": 1.1}
UNCLIPPED: dict[str, Any] = {"joinstyle": "round", "clip_on": False}
# Colours of safe runs by the decade of their error, and of other runs.
FIRST_DECADE, LAST_DECADE = round(math.log10(ROUNDING)), round(math.log10(SAFE_ERROR))
DECADES = LAST_DECADE - FIRST_DECADE
SHADES = tuple(map(to_hex, np.linspace(to_rgb("#fbfefc"), to_rgb("#9ad2b3"), DECADES)))
ROUGH, WRONG, FAILED = "#ecd060", "#e6862a", "#c4bcc8"
DECADES_PER_LABEL = 2  # on the scale of colours


def map_figure(found: LimitMap) -> Figure:
    """Draw a map of limits."""
    figure = Figure(figsize=SIZE)
    axes, scale = figure.subplots(1, 2, width_ratios=(SCALE, 1))
    _draw_map(axes, found)
    share = f"{len(found.runs)} of {found.nodes} nodes run ({numbers.percent(len(found.runs) / found.nodes)})"
    axes.set_title(f"{found.scene}, {preset_title(found.engine, found.preset)}: {share}", loc="left")
    _draw_scale(scale)
    add_legend_above(figure, _legend(found), LEGEND_COLUMNS, handlelength=2.0)
    return figure


def _draw_map(axes: Axes, found: LimitMap) -> None:
    across, upwards = AXES[found.x_axis], AXES[found.y_axis]
    x, y = axis_places(across, found.x), axis_places(upwards, found.y)
    edges = cell_edges(x), cell_edges(y)
    colours, standings = (
        np.array([of(run) for run in found.run_by_node.values()]).reshape(found.shape)
        for of in (error_colour, lambda run: map_class(run.level))
    )
    for colour in np.unique(colours):
        area = cells_path(colours == colour, *edges)
        axes.add_patch(PathPatch(area, facecolor=colour, edgecolor=colour, linewidth=0.2, zorder=1, **UNCLIPPED))
    axes.add_patch(PathPatch(borders_path(standings, *edges), fill=False, zorder=3, **BOUNDARY, **UNCLIPPED))
    # A run within ten per cent has only a colour, and no mark.
    marked = [run for run in found.runs if run.level not in GOOD_LEVELS]
    for outcome, undetected in dict.fromkeys((run.outcome, run.undetected) for run in marked):
        runs = [run for run in marked if (run.outcome, run.undetected) == (outcome, undetected)]
        style = mark_style(outcome, undetected) | {"zorder": 6, "clip_on": False}
        axes.plot(x[[run.i for run in runs]], y[[run.j for run in runs]], **style)
    set_scale(axes, "x", across, min(edges[0]), max(edges[0]))
    set_scale(axes, "y", upwards, edges[1][0], edges[1][-1])
    axes.set_xlabel(axis_label(across))
    axes.set_ylabel(textwrap.fill(axis_label(upwards), LABEL_WIDTH))
    axes.grid(visible=False)


def error_colour(run: MapRun) -> str:
    """Return the colour of a run by its error or level."""
    if run.error is None:
        return FAILED
    if run.level != Level.SAFE.slug:
        return ROUGH if run.level == Level.ROUGH.slug else WRONG
    decade = math.floor(math.log10(max(run.error, ROUNDING))) - FIRST_DECADE
    return SHADES[min(max(decade, 0), DECADES - 1)]


def _draw_scale(axes: Axes) -> None:
    """Draw the scale of colours, with the errors at which they change."""
    colours = (*SHADES, ROUGH, WRONG)
    for k, colour in enumerate(colours):
        axes.add_patch(Rectangle((0.0, k), 1.0, 1.0, facecolor=colour, edgecolor="#888888", linewidth=0.3))
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, len(colours)), xticks=[])
    decades = {k - FIRST_DECADE: f"1e{k}" for k in range(FIRST_DECADE, LAST_DECADE, DECADES_PER_LABEL)}
    ticks = decades | {DECADES: f"{100 * SAFE_ERROR:g} %", DECADES + 1: f"{100 * ROUGH_ERROR:g} %"}
    axes.set_yticks(list(ticks), list(ticks.values()))
    axes.yaxis.tick_right()
    axes.yaxis.set_label_position("right")
    axes.set_ylabel("largest position error / L")
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    axes.tick_params(axis="y", length=2.0, labelsize=8.0)


def _legend(found: LimitMap) -> list[Any]:
    """Return legend entries for the kinds of runs on the map."""
    handles: list[Any] = [
        Line2D([], [], label="boundary, run on both sides", **BOUNDARY),
    ]
    failed = {run.outcome for run in found.runs if run.error is None}
    if failed:
        handles += [Patch(color=FAILED, label="fails"), *outcome_handles(failed)]
    if any(run.undetected for run in found.runs):
        handles.append(Patch(color=UNDETECTED_COLOUR, label="red mark: undetected"))
    return handles


# -- cells: a rectangle about each node --------------------------------------------------------------------------------


def cell_edges(places: Array) -> Array:
    """Return edges (n + 1,) of cells about places (n,), at their geometric means."""
    logs = np.log10(places)
    middles = 0.5 * (logs[:-1] + logs[1:])
    edges = np.concatenate([[2.0 * logs[0] - middles[0]], middles, [2.0 * logs[-1] - middles[-1]]])
    return np.asarray(10.0**edges)


def cells_path(inside: NDArray[np.bool_], x: Array, y: Array) -> Path:
    """Return the outline of the cells that are True, joined along columns.

    Args:
        inside: cells (columns, rows).
        x, y: edges of columns and rows."""
    rectangles = []
    for i in range(inside.shape[0]):
        turns = np.flatnonzero(np.diff(np.pad(inside[i].astype(int), 1)))
        for a, b in turns.reshape(-1, 2):
            corners = [(x[i], y[a]), (x[i + 1], y[a]), (x[i + 1], y[b]), (x[i], y[b]), (x[i], y[a])]
            rectangles.append(Path(corners, closed=True))
    return Path.make_compound_path(*rectangles)


def borders_path(kinds: NDArray[Any], x: Array, y: Array) -> Path:
    """Return the edges between cells of different kinds.

    Args:
        kinds: kind of each cell (columns, rows).
        x, y: edges of columns and rows."""
    upright = [[(x[i + 1], y[j]), (x[i + 1], y[j + 1])] for i, j in np.argwhere(kinds[1:] != kinds[:-1])]
    level = [[(x[i], y[j + 1]), (x[i + 1], y[j + 1])] for j, i in np.argwhere((kinds[:, 1:] != kinds[:, :-1]).T)]
    return Path.make_compound_path(*(Path(side) for side in (*upright, *level)))
