"""Heat map of a pair of axes: how large the error is, how runs fail, and where that is undetected."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping
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
WHOLE: dict[str, Any] = {"joinstyle": "round", "clip_on": False}
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
    colours = np.array([_colour(found, node) for node in found.shown]).reshape(found.shape)
    for colour in np.unique(colours):
        area = outline(colours == colour, *edges, constant_values=False)
        axes.add_patch(PathPatch(area, facecolor=colour, edgecolor=colour, linewidth=0.2, zorder=1, **WHOLE))
    standings = np.array([standing(run.level) for run in found.shown.values()]).reshape(found.shape)
    for one in np.unique(standings)[1:]:  # what bounds the first bounds another too
        _draw_line(axes, outline(standings == one, *edges, mode="edge"), BOUNDARY)
    for style in (CASING, CORE):
        _draw_line(axes, outline(found.undetected, *edges, constant_values=False), style)
    for style, at in _marked(found):
        axes.plot(x[[run.i for run in at]], y[[run.j for run in at]], zorder=6, clip_on=False, **style)
    for axis, places, ends, set_ticks, set_ends in (
        (across, x, edges[0], axes.set_xticks, axes.set_xlim),
        (upwards, y, edges[1], axes.set_yticks, axes.set_ylim),
    ):
        set_ticks(*AxisScale(axis.scale, float(places.min()), float(places.max()), falling=False).ticks())
        set_ends(ends[0], ends[-1])
    axes.set_xlabel(across.label)
    axes.set_ylabel(textwrap.fill(upwards.label, LABEL_WIDTH))
    axes.grid(visible=False)


def _draw_line(axes: Axes, path: Path, style: Mapping[str, Any]) -> None:
    axes.add_patch(PathPatch(path, fill=False, capstyle="projecting", **style, **WHOLE))


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


def outline(inside: NDArray[np.bool_], x: Array, y: Array, **around: Any) -> Path:
    """The outline of some cells (columns, rows), with the inside on its left; holes in it are lines of their own.

    Args:
        x, y: edges of columns and rows.
        around: arguments of `np.pad` that say what lies around the map.
    """
    padded = np.pad(inside, 1, **around)
    steps: dict[Node, list[Node]] = {}
    for i, j in np.argwhere(padded[1:, 1:-1] != padded[:-1, 1:-1]):
        ends = [(i, j), (i, j + 1)]
        start, stop = ends if padded[i, j + 1] else ends[::-1]
        steps.setdefault(start, []).append(stop)
    for i, j in np.argwhere(padded[1:-1, 1:] != padded[1:-1, :-1]):
        ends = [(i, j), (i + 1, j)]
        start, stop = ends if padded[i + 1, j + 1] else ends[::-1]
        steps.setdefault(start, []).append(stop)
    arriving = Counter(stop for stops in steps.values() for stop in stops)
    # Lines that begin at the edge of the map come first: what is left then closes.
    open_ends = [start for start, stops in steps.items() for _ in range(len(stops) - arriving[start])]
    paths = []
    while steps:
        at = open_ends.pop() if open_ends else next(iter(steps))
        corners = [at]
        while at in steps:
            before, at = at, steps[at].pop()
            if not steps[before]:
                del steps[before]
            if len(corners) > 1 and 0 in {at[0] - corners[-2][0], at[1] - corners[-2][1]}:
                corners.pop()
            corners.append(at)
        places = [(x[i], y[j]) for i, j in corners]
        paths.append(Path(places, closed=corners[0] == corners[-1]))
    return Path.make_compound_path(*paths)
