"""Heat map of a pair of axes: how large the error is, how runs fail, and where that is undetected."""

from __future__ import annotations

import textwrap
from collections.abc import Hashable, Iterator, Mapping, Sequence
from itertools import groupby, pairwise
from typing import Any, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.charts.canvas import on_grid, on_log_grid
from conrod.report.charts.layout import Layout, legend_rows
from conrod.report.charts.styles import OUTCOME_COLOURS, preset_title
from conrod.report.limits.marks import UNDETECTED_COLOUR, AxisScale, draw_scale, error_colour, mark_style, place
from conrod.runs.trajectory import Outcome
from conrod.studies.limits.axes import AXES, Axis
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
# The nearest runs count nearly alone, so that many runs along a boundary do not outweigh one nearby.
POWER = 4

Label = TypeVar("Label", bound=Hashable)
Node = tuple[int, int]
Segment = tuple[tuple[float, float], tuple[float, float]]
OUTSIDE = object()  # what lies around a map


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
    x_edges, y_edges = edges_about(x), edges_about(y)
    nodes = found.shown
    for colour, path in areas(_colours(found, nodes), x_edges, y_edges).items():
        axes.add_patch(PathPatch(path, facecolor=colour, edgecolor=colour, linewidth=0.2, zorder=1))
    lines = seams({node: standing(run.level) for node, run in nodes.items()}, x_edges, y_edges)
    axes.add_collection(LineCollection(lines, zorder=3, capstyle="projecting", **BOUNDARY))
    undetected = seams({node: bool(found.undetected[node]) for node in nodes}, x_edges, y_edges, around=False)
    for k, outline in enumerate((CASING, CORE)):
        axes.add_collection(LineCollection(undetected, zorder=4 + k, capstyle="projecting", clip_on=False, **outline))
    for style, at in _marked(found):
        axes.plot(x[[run.i for run in at]], y[[run.j for run in at]], zorder=6, **style)
    axes.set_xlim(x_edges[0], x_edges[-1])
    axes.set_ylim(y_edges[0], y_edges[-1])
    for axis, places, set_ticks in ((across, x, axes.set_xticks), (upwards, y, axes.set_yticks)):
        set_ticks(*AxisScale(axis.scale, float(places.min()), float(places.max()), falling=False).ticks())
    axes.set_xlabel(across.label)
    axes.set_ylabel(textwrap.fill(upwards.label, LABEL_WIDTH))
    axes.grid(visible=False)


def _places(axis: Axis, values: tuple[float, ...]) -> Array:
    places = np.array([place(axis.scale, value) for value in values])
    return on_grid(places, float(np.ptp(places)))


def _colours(found: LimitMap, nodes: Mapping[Node, MapRun]) -> dict[Node, str]:
    ways = {
        node: OUTCOME_COLOURS[run.outcome] if found.known[node] else NOT_LOOKED_AT
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
    if not found.known.all():
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


# -- cells: a rectangle about each node --------------------------------------------------------------------------------


def shaded_errors(runs: Sequence[MapRun], shape: tuple[int, int]) -> Array:
    """Errors (columns, rows): the runs' own, elsewhere their geometric mean weighted by distance in nodes to the -4.

    What a node's level is does not depend on this.

    Raises:
        ValueError: no run has an error.
    """
    known = [run for run in runs if run.error is not None]
    if not known:
        raise ValueError("there is no error to shade others from")
    at = np.array([(run.i, run.j) for run in known], dtype=float)
    logarithms = np.log10(on_log_grid(np.array([run.error for run in known])))
    i, j = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    squared = (i[..., None] - at[:, 0]) ** 2 + (j[..., None] - at[:, 1]) ** 2
    # At a run itself all weight is its own.
    weights = np.where(squared > 0.0, squared, 1e-9) ** (-POWER / 2)
    return on_log_grid(10.0 ** ((weights @ logarithms) / weights.sum(axis=2)))


def edges_about(places: Array) -> Array:
    """Edges (n + 1,) of cells about places (n,): half-way between them, the outer ones as far out."""
    middles = 0.5 * (places[:-1] + places[1:])
    edges = np.concatenate([[2.0 * places[0] - middles[0]], middles, [2.0 * places[-1] - middles[-1]]])
    return on_grid(edges, float(np.ptp(edges)))


def areas(colours: Mapping[Node, str], x: Array, y: Array) -> dict[str, Path]:
    """The cells of each colour as one path; x and y are the edges of columns and rows."""
    found: dict[str, list[Path]] = {}
    for j in range(len(y) - 1):
        row = [colours[i, j] for i in range(len(x) - 1)]
        for colour, start, stop in _stretches(row):
            corners = [(x[a], y[b]) for a, b in ((start, j), (stop, j), (stop, j + 1), (start, j + 1), (start, j))]
            found.setdefault(colour, []).append(Path(corners, closed=True))
    return {colour: Path.make_compound_path(*paths) for colour, paths in found.items()}


def seams(labels: Mapping[Node, Hashable], x: Array, y: Array, around: Hashable = OUTSIDE) -> list[Segment]:
    """Lines between cells of unequal labels, as long as they can be.

    Args:
        around: label of what surrounds the map; its border is a seam where that differs. None at all by default.
    """

    def label(i: int, j: int) -> Hashable:
        inside = 0 <= i < len(x) - 1 and 0 <= j < len(y) - 1
        return labels[i, j] if inside else around

    def differ(one: Hashable, other: Hashable) -> bool:
        return one != other and OUTSIDE not in (one, other)

    found: list[Segment] = []
    for i in range(len(x)):
        column = [differ(label(i - 1, j), label(i, j)) for j in range(len(y) - 1)]
        found += [((x[i], y[start]), (x[i], y[stop])) for seam, start, stop in _stretches(column) if seam]
    for j in range(len(y)):
        row = [differ(label(i, j - 1), label(i, j)) for i in range(len(x) - 1)]
        found += [((x[start], y[j]), (x[stop], y[j])) for seam, start, stop in _stretches(row) if seam]
    return found


def _stretches(values: Sequence[Label]) -> Iterator[tuple[Label, int, int]]:
    """Equal neighbours taken together: the value, where it starts and where it stops."""
    lengths = [(value, len(list(equal))) for value, equal in groupby(values)]
    stops = np.cumsum([0, *(length for _, length in lengths)]).tolist()
    for (value, _), (start, stop) in zip(lengths, pairwise(stops), strict=True):
        yield value, start, stop
