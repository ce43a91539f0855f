"""Maps of where an engine fails over two axes: its steps per revolution and another axis."""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from conrod.execution.case import Study
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import spaced_values
from conrod.studies.limits.case import Setup
from conrod.studies.limits.records import Level, LimitResult, is_undetected, level_of

COARSE_STRIDE = 8  # nodes between two lines of the coarse grid
UNKNOWN = -1  # class number of a node that was not run

Node = tuple[int, int]  # indices along the two axes
NodeClass = TypeVar("NodeClass", bound=Hashable)
ClassNumbers = NDArray[np.int_]  # (I, J) of a grid, the number of each node's class, or UNKNOWN


def classify_grid(
    shape: tuple[int, int],
    ask: Callable[[Sequence[Node]], Generator[Any, Any, Mapping[Node, NodeClass]]],
    stride: int = COARSE_STRIDE,
) -> Generator[Any, Any, dict[Node, NodeClass]]:
    """Run a grid's nodes along the boundaries of classes, and return the class of each.

    Three rules select nodes, until none selects another:

    1. Coarse grid: the nodes at the crossings of every n-th row and column.
    2. Bisection: if two known neighbours on a line differ and are not adjacent, the node midway; first on the lines of
       the coarse grid, in the end on all lines.
    3. Boundary tracking: if two corners of a unit cell differ, its other corners.

    A node that was not run is then enclosed by nodes of one class, and inherits that class. An area that lies between
    two coarse lines without crossing one is missed.

    Args:
        shape: number of nodes along the two axes, at least 2 each.
        ask: study that runs some nodes and returns their classes.
        stride: n of the coarse grid, which also has the last row and the last column.
    """
    rows, columns = ((*range(0, length - 1, stride), length - 1) for length in shape)
    found: dict[Node, NodeClass] = {}
    wanted = list(product(rows, columns))
    while wanted:
        found |= yield from ask(wanted)
        wanted = _next_nodes(class_numbers(shape, found), rows, columns)
    return found


def class_numbers(shape: tuple[int, int], labels: Mapping[Node, Hashable]) -> ClassNumbers:
    """Return a grid (I, J) of label numbers, UNKNOWN for nodes without a label."""
    numbers = {label: k for k, label in enumerate(dict.fromkeys(labels.values()))}
    grid = np.full(shape, UNKNOWN)
    for node, label in labels.items():
        grid[node] = numbers[label]
    return grid


def nearest_known_nodes(known: ClassNumbers) -> NDArray[np.int_]:
    """Return the indices (2, I, J) of the known node nearest to each node, in taxicab distance."""
    unknown = known == UNKNOWN
    nearest = ndimage.distance_transform_cdt(unknown, "taxicab", return_distances=False, return_indices=True)
    return np.asarray(nearest, dtype=int)


def _next_nodes(known: ClassNumbers, rows: Iterable[int], columns: Iterable[int]) -> list[Node]:
    """Nodes to run next, by rules 2 and 3 of `classify_grid`, on all lines last."""
    some = {*_boundary_middles(known, rows, columns), *_boundary_corners(known)}
    return sorted(some or _boundary_middles(known, *map(range, known.shape)))


def _boundary_middles(known: ClassNumbers, rows: Iterable[int], columns: Iterable[int]) -> Iterator[Node]:
    """Nodes midway between differing neighbours on some rows and columns."""
    for i in rows:
        yield from ((i, j) for j in _line_middles(known[i]))
    for j in columns:
        yield from ((i, j) for i in _line_middles(known[:, j]))


def _line_middles(line: ClassNumbers) -> list[int]:
    """Indices midway between known neighbours of a line that differ and are not adjacent."""
    at = np.flatnonzero(line != UNKNOWN)
    first, last = at[:-1], at[1:]
    apart = (line[first] != line[last]) & (last - first > 1)
    middles: list[int] = ((first[apart] + last[apart]) // 2).tolist()
    return middles


def _boundary_corners(known: ClassNumbers) -> list[Node]:
    """Unknown corners of unit cells with two known corners that differ."""
    cells = [(slice(i, known.shape[0] - 1 + i), slice(j, known.shape[1] - 1 + j)) for i in (0, 1) for j in (0, 1)]
    corners = np.stack([known[cell] for cell in cells])
    least = np.where(corners == UNKNOWN, np.iinfo(known.dtype).max, corners).min(axis=0)
    crossed = corners.max(axis=0) > least
    wanted = np.zeros(known.shape, dtype=bool)
    for cell in cells:
        wanted[cell] |= crossed
    return [(int(i), int(j)) for i, j in np.argwhere(wanted & (known == UNKNOWN))]


# Ends of the axes that are mapped with the steps per revolution; None is the most steps per revolution.
MAPPED_AXES: dict[str, tuple[float | None, float]] = {
    "mass-ratio": (1e-6, 1e6),
    "nearness": (0.1, 1.0 - 1e-9),
    "stabilisation": (None, 0.1),
}
STEPS_REDUCTION = 250.0  # usual steps over the fewest: 1000 .. 4 for a linkage, 20000 .. 80 for a cam
# Columns and rows. Runs are in proportion to the length of the boundaries, so a finer map runs a smaller share.
MAP_RESOLUTION = (65, 65)
ASSEMBLED_LEVELS = {level.slug for level in (Level.SAFE, Level.ROUGH, Level.WRONG)}
FAILED = "failed"


class MapRun(NamedTuple):
    """A node of a map that was run.

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
    """Map of two axes for one preset of one engine on one scene.

    Attributes:
        x_axis, y_axis: names of the axes.
        x, y: values of the columns and of the rows, in the axes' units.
        runs: the nodes that were run; every other node inherits from the nearest of them.
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
        """Number of nodes of the full grid."""
        return len(self.x) * len(self.y)

    @cached_property
    def run_by_node(self) -> dict[Node, MapRun]:
        """The run nearest to each node, by the node's indices (i, j)."""
        nearest = nearest_known_nodes(class_numbers(self.shape, {(run.i, run.j): None for run in self.runs}))
        run_at = {(run.i, run.j): run for run in self.runs}
        return {node: run_at[tuple(nearest[:, *node].tolist())] for node in np.ndindex(self.shape)}


def map_class(level: str) -> str:
    """Return the class of a level on a map: safe, rough, wrong, or failed for all worse levels."""
    return level if level in ASSEMBLED_LEVELS else FAILED


def grid_values(setup: Setup, other: str, resolution: tuple[int, int]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the values of the steps and of another axis, the columns and rows of a map.

    There are fewer columns if there are not enough whole numbers.
    """
    (columns, rows), (first, last) = resolution, MAPPED_AXES[other]
    steps = spaced_values(AXES["steps"].scale, float(setup.steps), setup.steps / STEPS_REDUCTION, columns)
    return steps, spaced_values(AXES[other].scale, float(setup.steps) if first is None else first, last, rows)


def map_search(
    setup: Setup, other: str, resolution: tuple[int, int] = MAP_RESOLUTION, stride: int = COARSE_STRIDE
) -> Study[LimitMap]:
    """Map steps and another axis along the boundaries of safe, rough, wrong and failed.

    Raises:
        InvalidInput: machine or engine cannot have some of the values.
    """
    x, y = grid_values(setup, other, resolution)
    runs: dict[Node, MapRun] = {}

    def ask(nodes: Sequence[Node]) -> Study[Mapping[Node, str]]:
        # By rows, each of which is one machine, so that its cached tables are reused.
        cases = {
            (i, j): AXES[other].case(replace(setup, steps_per_revolution=round(x[i])), y[j])
            for i, j in sorted(nodes, key=lambda node: (node[1], node[0]))
        }
        results = yield tuple(cases.values())
        runs.update({node: _map_run(node, results[case.key]) for node, case in cases.items()})
        return {node: map_class(runs[node].level) for node in nodes}

    yield from classify_grid((len(x), len(y)), ask, stride)
    return LimitMap(*setup.names, "steps", other, x, y, tuple(runs[node] for node in sorted(runs)))


def _map_run(node: Node, result: LimitResult) -> MapRun:
    """Findings on a node from its result."""
    level, error = level_of(result).slug, result.largest("position")
    return MapRun(*node, level, result.outcome, is_undetected(result), error)
