"""Pairs of axes mapped together: where an engine fails by its steps per revolution and by one thing more."""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from conrod.studies.frame.case import Measurement, Study
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import spaced
from conrod.studies.limits.case import Setup
from conrod.studies.limits.records import Level, is_undetected, level_of

STRIDE = 8
UNKNOWN = -1

Node = tuple[int, int]  # indices along the two axes
Class = TypeVar("Class", bound=Hashable)
Codes = NDArray[np.int_]  # of a grid, a number for each class, or UNKNOWN


def refine(
    shape: tuple[int, int],
    ask: Callable[[Sequence[Node]], Generator[Any, Any, Mapping[Node, Class]]],
    stride: int = STRIDE,
) -> Generator[Any, Any, dict[Node, Class]]:
    """Find the class of every node of a grid; return those of the nodes that were run, in their order.

    Three rules say which nodes are run, all of them until none asks for another:

    1. A coarse grid: every node of some rows that is also in some columns.
    2. Where neighbours along a line differ and lie apart, the one in the middle is run: first along the lines of the
       coarse grid, in the end along all.
    3. Where two corners of a unit cell differ, its other corners are run: so a boundary is followed wherever it leads.

    A node that was never run then lies in an area around which all nodes were run and are of one class: it inherits
    that. What the rules cannot see is an area of a class of its own that slips between two coarse lines.

    Args:
        shape: number of nodes along the two axes, at least 2 each.
        ask: study that runs some nodes and returns their classes.
        stride: of the coarse grid, in nodes. The last row and the last column are in it whatever their distance.
    """
    rows, columns = ((*range(0, length - 1, stride), length - 1) for length in shape)
    found: dict[Node, Class] = {}
    wanted = list(product(rows, columns))
    while wanted:
        found |= yield from ask(wanted)
        wanted = _wanted(codes(shape, found), rows, columns)
    return found


def codes(shape: tuple[int, int], labels: Mapping[Node, Hashable]) -> Codes:
    """Return a grid with a number for each label, and UNKNOWN where there is none."""
    numbers = {label: k for k, label in enumerate(dict.fromkeys(labels.values()))}
    grid = np.full(shape, UNKNOWN)
    for node, label in labels.items():
        grid[node] = numbers[label]
    return grid


def nearest_runs(known: Codes) -> NDArray[np.int_]:
    """Return of every node the run one that is reached from it in the fewest steps along lines; (2, I, J)."""
    unknown = known == UNKNOWN
    nearest = ndimage.distance_transform_cdt(unknown, "taxicab", return_distances=False, return_indices=True)
    return np.asarray(nearest, dtype=int)


def _wanted(known: Codes, rows: Iterable[int], columns: Iterable[int]) -> list[Node]:
    """Nodes that the rules ask for; along all lines only where they ask for nothing along some."""
    some = {*_middles(known, rows, columns), *_corners(known)}
    return sorted(some or _middles(known, *map(range, known.shape)))


def _middles(known: Codes, rows: Iterable[int], columns: Iterable[int]) -> Iterator[Node]:
    """Nodes in the middle of a gap between two that differ, along some rows and columns."""
    for i in rows:
        yield from ((i, j) for j in _gaps(known[i]))
    for j in columns:
        yield from ((i, j) for i in _gaps(known[:, j]))


def _gaps(line: Codes) -> list[int]:
    at = np.flatnonzero(line != UNKNOWN)
    first, last = at[:-1], at[1:]
    apart = (line[first] != line[last]) & (last - first > 1)
    middles: list[int] = ((first[apart] + last[apart]) // 2).tolist()
    return middles


def _corners(known: Codes) -> list[Node]:
    """Unknown corners of the unit cells of which two corners differ."""
    cells = [(slice(i, known.shape[0] - 1 + i), slice(j, known.shape[1] - 1 + j)) for i in (0, 1) for j in (0, 1)]
    corners = np.stack([known[cell] for cell in cells])
    least = np.where(corners == UNKNOWN, np.iinfo(known.dtype).max, corners).min(axis=0)
    crossed = corners.max(axis=0) > least
    wanted = np.zeros(known.shape, dtype=bool)
    for cell in cells:
        wanted[cell] |= crossed
    return [(int(i), int(j)) for i, j in np.argwhere(wanted & (known == UNKNOWN))]


# The axes that are mapped with the steps per revolution, with their ends; None is as many steps as the finest run takes
# for a turn.
PAIRS: dict[str, tuple[float | None, float]] = {
    "mass-ratio": (1e-6, 1e6),
    "nearness": (0.1, 1.0 - 1e-9),
    "stabilisation": (None, 0.1),
}
# From the usual steps down to so many times fewer: 1000 .. 4 of a linkage, 20000 .. 80 of a cam.
FEWER = 250.0
# Columns and rows. A boundary costs runs in proportion to its length, so a finer map needs a smaller share of them.
RESOLUTION = (65, 65)
IN_ONE_PIECE = {level.slug for level in (Level.SAFE, Level.ROUGH, Level.WRONG)}
FAILED = "failed"


class MapRun(NamedTuple):
    """A node that was run.

    Attributes:
        i, j: its column and its row.
        level, outcome, undetected: see `conrod.studies.limits.records`.
        error: largest position error, normalised; None unless the run completed.
    """

    i: int
    j: int
    level: str
    outcome: str
    undetected: bool
    error: float | None


@dataclass(frozen=True)
class LimitMap:
    """A pair of axes mapped for one preset of one engine on one scene.

    Attributes:
        x_axis, y_axis: names of the axes.
        x, y: values of the columns and of the rows, in the axes' units.
        runs: the nodes that were run; every other one has what it shows from the nearest of them.
    """

    scene: str
    engine: str
    preset: str
    x_axis: str
    y_axis: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    runs: tuple[MapRun, ...]

    @property
    def shape(self) -> tuple[int, int]:
        """Number of columns and rows."""
        return len(self.x), len(self.y)

    @property
    def nodes(self) -> int:
        """Runs of the full grid."""
        return len(self.x) * len(self.y)

    @cached_property
    def shown(self) -> dict[Node, MapRun]:
        """Of every node the run that it stands for, or inherits from; it is the node's own if its i and j are."""
        nearest = nearest_runs(codes(self.shape, {(run.i, run.j): None for run in self.runs}))
        run_at = {(run.i, run.j): run for run in self.runs}
        return {node: run_at[tuple(nearest[:, *node].tolist())] for node in np.ndindex(self.shape)}


def standing(level: str) -> str:
    """Return the class that divides a map: safe, rough, wrong, or failed in whatever way."""
    return level if level in IN_ONE_PIECE else FAILED


def grid_of(setup: Setup, other: str, resolution: tuple[int, int]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return values of the steps and of another axis; of the steps fewer where there are fewer whole numbers."""
    (columns, rows), (first, last) = resolution, PAIRS[other]
    steps = spaced(AXES["steps"].scale, float(setup.steps), setup.steps / FEWER, columns)
    return steps, spaced(AXES[other].scale, float(setup.steps) if first is None else first, last, rows)


def map_search(
    setup: Setup, other: str, resolution: tuple[int, int] = RESOLUTION, stride: int = STRIDE
) -> Study[LimitMap]:
    """Map a pair, running along the boundaries of safe, rough, wrong and failed; see `conrod.studies.limits.maps`.

    Raises:
        InvalidInput: the machine or the engine cannot be given with some values.
    """
    x, y = grid_of(setup, other, resolution)
    runs: dict[Node, MapRun] = {}

    def ask(nodes: Sequence[Node]) -> Study[Mapping[Node, str]]:
        # By rows, each of which is one machine: what is computed from it is then still at hand.
        cases = {
            (i, j): AXES[other].case(replace(setup, steps_per_revolution=round(x[i])), y[j])
            for i, j in sorted(nodes, key=lambda node: (node[1], node[0]))
        }
        results = yield tuple(cases.values())
        runs.update({node: _run(node, results[case.key]) for node, case in cases.items()})
        return {node: standing(runs[node].level) for node in nodes}

    yield from refine((len(x), len(y)), ask, stride)
    return LimitMap(*setup.who, "steps", other, x, y, tuple(runs[node] for node in sorted(runs)))


def _run(node: Node, measurement: Measurement) -> MapRun:
    level, error = level_of(measurement).slug, measurement.largest("position")
    return MapRun(*node, level, measurement.outcome, is_undetected(measurement), error)
