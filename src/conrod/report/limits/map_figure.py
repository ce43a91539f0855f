"""Heat map of a pair of axes: how large the error is, how runs fail, and where that is undetected."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.charts.canvas import Layout, legend_rows, on_grid
from conrod.report.charts.styles import OUTCOME_COLOURS, preset_title
from conrod.report.limits.marks import UNDETECTED_COLOUR, AxisScale, draw_scale, error_colour, mark_style, place
from conrod.runs.trajectory import Outcome
from conrod.studies.limits.adaptive import Node
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
BOUNDARY: dict[str, Any] = {"color": "#111111", "linewidth": 1.1, "zorder": 3}
RAN: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 1.8, "color": "#555555"}
# White beneath the red: it is seen on dark colours, and without colour.
CASING: dict[str, Any] = {"color": "white", "linewidth": 3.0, "zorder": 4}
CORE: dict[str, Any] = {"color": UNDETECTED_COLOUR, "linewidth": 1.5, "zorder": 5}


def map_figure(found: LimitMap) -> Figure:
    """Draw the map of one preset of one engine on one scene."""
    handles, labels = _legend(found)
    layout = Layout(WIDTH, BOTTOM + PANEL_HEIGHT + TITLE + LEGEND_ROW * legend_rows(handles, LEGEND_COLUMNS))
    axes = layout.axes(LEFT, BOTTOM, WIDTH - LEFT - RIGHT, PANEL_HEIGHT)
    _draw(axes, found)
    axes.set_title(_title(found), loc="left")
    draw_scale(layout.axes(WIDTH - RIGHT + SCALE_GAP, BOTTOM, SCALE_WIDTH, PANEL_HEIGHT))
    style: dict[str, Any] = {"borderpad": 0.2, "columnspacing": 1.6}
    layout.legend(handles, LEGEND_COLUMNS, 0.0, labels=labels, handler_map={tuple: HandlerTuple(ndivide=1)}, **style)
    return layout.figure


def _title(found: LimitMap) -> str:
    share = f"{len(found.runs)} of {found.nodes} nodes run ({numbers.percent(found.share)})"
    return f"{found.scene}, {preset_title(found.engine, found.preset)}: {share}"


# -- panel -------------------------------------------------------------------------------------------------------------


def _draw(axes: Axes, found: LimitMap) -> None:
    across, upwards = AXES[found.x_axis], AXES[found.y_axis]
    x, y = _places(across, found.x), _places(upwards, found.y)
    edges = edges_about(x), edges_about(y)
    for colour, path in areas({node: _colour(found, node) for node in found.shown}, *edges).items():
        axes.add_patch(PathPatch(path, facecolor=colour, edgecolor=colour, linewidth=0.2, zorder=1))
    standings = np.array([standing(run.level) for run in found.shown.values()]).reshape(found.shape)
    draw_seams(axes, standings, *edges, BOUNDARY, mode="edge")
    for outline in (CASING, CORE):
        draw_seams(axes, found.undetected, *edges, outline, constant_values=False)
    for style, at in _marked(found):
        axes.plot(x[[run.i for run in at]], y[[run.j for run in at]], zorder=6, **style)
    for axis, places, ends, set_ticks, set_ends in (
        (across, x, edges[0], axes.set_xticks, axes.set_xlim),
        (upwards, y, edges[1], axes.set_yticks, axes.set_ylim),
    ):
        set_ticks(*AxisScale(axis.scale, float(places.min()), float(places.max()), falling=False).ticks())
        set_ends(ends[0], ends[-1])
    axes.set_xlabel(across.label)
    axes.set_ylabel(textwrap.fill(upwards.label, LABEL_WIDTH))
    axes.grid(visible=False)


def _places(axis: Axis, values: tuple[float, ...]) -> Array:
    places = np.array([place(axis.scale, value) for value in values])
    return on_grid(places, float(np.ptp(places)))


def _colour(found: LimitMap, node: Node) -> str:
    run = found.shown[node]
    if run.error is not None:
        return error_colour(run.level, run.error)
    return OUTCOME_COLOURS[run.outcome] if found.known[node] else NOT_LOOKED_AT


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
    if not found.known.all():
        entries.append((_swatch(NOT_LOOKED_AT), "fails, in one of these ways"))
    if any(run.undetected for run in found.runs):
        outline = (Line2D([], [], **CASING), Line2D([], [], **CORE))
        entries.append((outline, "undetected: no warning, finite numbers"))
    entries.append((Line2D([], [], **BOUNDARY), "boundary, run on both sides"))
    entries.append((Line2D([], [], **RAN | {"markersize": 4.0}), "a run (between: the nearest run)"))
    return [handle for handle, _ in entries], [text for _, text in entries]


def _swatch(colour: str) -> Patch:
    return Patch(facecolor=colour, edgecolor="#666666", linewidth=0.4)


def _mark(run: MapRun) -> Line2D:
    return Line2D([], [], **(mark_style(run.outcome, run.level, MARK_SIZE + 0.6) | {"markeredgewidth": 0.8}))


# -- cells: a rectangle about each node --------------------------------------------------------------------------------


def edges_about(places: Array) -> Array:
    """Edges (n + 1,) of cells about places (n,): half-way between them, the outer ones as far out."""
    middles = 0.5 * (places[:-1] + places[1:])
    edges = np.concatenate([[2.0 * places[0] - middles[0]], middles, [2.0 * places[-1] - middles[-1]]])
    return on_grid(edges, float(np.ptp(edges)))


def areas(colours: Mapping[Node, str], x: Array, y: Array) -> dict[str, Path]:
    """The cells of each colour as one path, neighbours in a row as one; x and y are the edges of columns and rows."""
    found: dict[str, list[Path]] = {}
    for j in range(len(y) - 1):
        start = 0
        for colour, cells in groupby(colours[i, j] for i in range(len(x) - 1)):
            stop = start + len(list(cells))
            corners = [(x[a], y[b]) for a, b in ((start, j), (stop, j), (stop, j + 1), (start, j + 1), (start, j))]
            found.setdefault(colour, []).append(Path(corners, closed=True))
            start = stop
    return {colour: Path.make_compound_path(*paths) for colour, paths in found.items()}


def draw_seams(axes: Axes, labels: NDArray[Any], x: Array, y: Array, style: Mapping[str, Any], **around: Any) -> None:
    """Draw lines between cells of unequal labels (columns, rows).

    Args:
        x, y: edges of columns and rows.
        around: arguments of `np.pad` that say what lies around the map.
    """
    across, upwards = (np.pad(labels, width, **around) for width in (((1, 1), (0, 0)), ((0, 0), (1, 1))))
    lines = [((x[i], x[i]), (y[j], y[j + 1])) for i, j in np.argwhere(across[1:] != across[:-1])]
    lines += [((x[i], x[i + 1]), (y[j], y[j])) for i, j in np.argwhere(upwards[:, 1:] != upwards[:, :-1])]
    # One curve, broken between lines.
    places = np.array([[(*ends, np.nan) for ends in line] for line in lines]).reshape(-1, 2, 3)
    axes.plot(places[:, 0].ravel(), places[:, 1].ravel(), solid_capstyle="projecting", clip_on=False, **style)
