"""Heat map of a pair of axes: how large the error is, how runs fail, and where that is undetected."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.charts.canvas import on_grid
from conrod.report.charts.styles import engine_title
from conrod.report.limits.axis_scale import AxisScale, place, tick_text
from conrod.report.limits.map_cells import Node, areas, edges_about, seams, shaded_errors
from conrod.report.limits.marks import OUTCOME_COLOURS, UNDETECTED_COLOUR, draw_scale, error_colour, mark_style
from conrod.runs.trajectory import Outcome
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Axis
from conrod.studies.limits.maps import LimitMap, MapRun, standing

WIDTH, PANEL_HEIGHT = 9.5, 4.2  # [inch]
LEFT, RIGHT, BOTTOM, TITLE, LEGEND_ROW = 1.05, 1.15, 0.52, 0.28, 0.21  # [inch]
SCALE_GAP, SCALE_WIDTH = 0.16, 0.16  # [inch]
LEGEND_COLUMNS = 4
LABEL_WIDTH = 44  # letters
NOT_LOOKED_AT = "#a8a8a8"  # of nodes that fail in a way not looked at
MARK_SIZE = 4.4  # [pt]
BOUNDARY: dict[str, Any] = {"color": "#111111", "linewidth": 1.1}
RAN: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 1.8, "color": "#555555"}
# White beneath the red: it is seen on dark colours, and without colour.
CASING: dict[str, Any] = {"color": "white", "linewidth": 3.0}
CORE: dict[str, Any] = {"color": UNDETECTED_COLOUR, "linewidth": 1.5}


def map_figure(found: LimitMap) -> Figure:
    """Draw the map of one preset of one engine on one scene."""
    handles, labels = _legend(found)
    legend = LEGEND_ROW * -(-len(handles) // LEGEND_COLUMNS)
    height = BOTTOM + PANEL_HEIGHT + TITLE + legend
    figure = Figure(figsize=(WIDTH, height))
    wide = WIDTH - LEFT - RIGHT
    axes = figure.add_axes((LEFT / WIDTH, BOTTOM / height, wide / WIDTH, PANEL_HEIGHT / height))
    _draw(axes, found)
    axes.set_title(_title(found), loc="left")
    at = ((WIDTH - RIGHT + SCALE_GAP) / WIDTH, BOTTOM / height, SCALE_WIDTH / WIDTH, PANEL_HEIGHT / height)
    draw_scale(figure.add_axes(at))
    figure.legend(
        handles,
        labels,
        loc="upper center",
        ncol=LEGEND_COLUMNS,
        bbox_to_anchor=(0.5, 1.0),
        borderpad=0.2,
        columnspacing=1.6,
        handler_map={tuple: HandlerTuple(ndivide=1)},
    )
    return figure


def _title(found: LimitMap) -> str:
    share = f"{len(found.runs)} of {found.nodes} nodes run ({numbers.percent(found.share)})"
    return f"{found.scene}, {engine_title(found.engine)} {found.preset}: {share}"


# -- panel -------------------------------------------------------------------------------------------------------------


def _draw(axes: Axes, found: LimitMap) -> None:
    across, upwards = AXES[found.x_axis], AXES[found.y_axis]
    x, y = _places(across, found.x), _places(upwards, found.y)
    x_edges, y_edges = edges_about(x), edges_about(y)
    nodes = {(i, j): found.at((i, j)) for i in range(len(x)) for j in range(len(y))}
    for colour, path in areas(_colours(found, nodes), x_edges, y_edges).items():
        axes.add_patch(PathPatch(path, facecolor=colour, edgecolor=colour, linewidth=0.2, zorder=1))
    lines = seams({node: standing(run.level) for node, run in nodes.items()}, x_edges, y_edges)
    axes.add_collection(LineCollection(lines, zorder=3, capstyle="projecting", **BOUNDARY))
    undetected = seams({node: found.is_undetected(node) for node in nodes}, x_edges, y_edges, around=False)
    for k, outline in enumerate((CASING, CORE)):
        axes.add_collection(LineCollection(undetected, zorder=4 + k, capstyle="projecting", clip_on=False, **outline))
    for style, at in _marked(found):
        axes.plot(x[[run.i for run in at]], y[[run.j for run in at]], zorder=6, **style)
    axes.set_xlim(x_edges[0], x_edges[-1])
    axes.set_ylim(y_edges[0], y_edges[-1])
    axes.set_xticks(*_ticks(across, x))
    axes.set_yticks(*_ticks(upwards, y))
    axes.set_xlabel(across.label)
    axes.set_ylabel(textwrap.fill(upwards.label, LABEL_WIDTH))
    axes.grid(visible=False)


def _places(axis: Axis, values: tuple[float, ...]) -> Array:
    places = np.array([place(axis.scale, value) for value in values])
    return on_grid(places, float(np.ptp(places)))


def _ticks(axis: Axis, places: Array) -> tuple[list[float], list[str]]:
    ticks = AxisScale(axis.scale, float(places.min()), float(places.max()), falling=False).ticks()
    return [place(axis.scale, value) for value in ticks], [tick_text(axis.scale, value) for value in ticks]


def _colours(found: LimitMap, nodes: Mapping[Node, MapRun]) -> dict[Node, str]:
    ways = {
        node: OUTCOME_COLOURS[run.outcome] if found.is_known(node) else NOT_LOOKED_AT
        for node, run in nodes.items()
        if run.error is None
    }
    if len(ways) == len(nodes):
        return ways
    errors = shaded_errors(found.runs, (len(found.x), len(found.y)))
    return {node: ways.get(node) or error_colour(run.level, float(errors[node])) for node, run in nodes.items()}


def _marked(found: LimitMap) -> Iterator[tuple[dict[str, Any], list[MapRun]]]:
    """The runs of each mark: a dot for one in one piece, a mark for each way of failing."""
    yield RAN, [run for run in found.runs if run.error is not None]
    for outcome in Outcome:
        failed = [run for run in found.runs if run.error is None and run.outcome == outcome.slug]
        if failed:
            yield mark_style(outcome.slug, failed[0].level, MARK_SIZE) | {"markeredgewidth": 0.8}, failed


# -- legend ------------------------------------------------------------------------------------------------------------


def _legend(found: LimitMap) -> tuple[list[Any], list[str]]:
    """Only what occurs."""
    entries: list[tuple[Any, str]] = [
        ((_swatch(OUTCOME_COLOURS[run.outcome]), _mark(run)), run.outcome)
        for run in {run.outcome: run for run in found.runs if run.error is None}.values()
    ]
    entries.sort(key=lambda entry: [outcome.slug for outcome in Outcome].index(entry[1]))
    if not all(found.is_known(node) for node in product(range(len(found.x)), range(len(found.y)))):
        entries.append((_swatch(NOT_LOOKED_AT), "fails, in one of these ways"))
    if any(run.undetected for run in found.runs):
        outline = (Line2D([], [], **CASING), Line2D([], [], **CORE))
        entries.append((outline, "undetected: no warning, finite numbers"))
    entries.append((Line2D([], [], **BOUNDARY), "boundary, run on both sides"))
    entries.append((Line2D([], [], **RAN | {"markersize": 4.0}), "a run (between: from the runs around)"))
    return [handle for handle, _ in entries], [text for _, text in entries]


def _swatch(colour: str) -> Patch:
    return Patch(facecolor=colour, edgecolor="#666666", linewidth=0.4)


def _mark(run: MapRun) -> Line2D:
    return Line2D([], [], **(mark_style(run.outcome, run.level, MARK_SIZE + 0.6) | {"markeredgewidth": 0.8}))
