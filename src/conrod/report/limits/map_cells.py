"""Cells of a map, a rectangle about each node: merged into few areas, the seams between unequal ones, their shades."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from itertools import groupby, pairwise
from typing import TypeVar

import numpy as np
from matplotlib.path import Path

from conrod.exact.motion import Array
from conrod.report.charts.canvas import on_grid, on_log_grid
from conrod.studies.limits.maps import MapRun

# The nearest runs count nearly alone, so that many runs along a boundary do not outweigh one nearby.
POWER = 4


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


Label = TypeVar("Label", bound=Hashable)
Node = tuple[int, int]
Segment = tuple[tuple[float, float], tuple[float, float]]
OUTSIDE = object()  # what lies around a map


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
