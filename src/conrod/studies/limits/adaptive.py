"""Classes of all nodes of a grid, from runs along the boundaries between classes alone.

Three rules say which nodes are run, all of them until none asks for another:

1. A coarse grid: every node of some rows that is also in some columns.
2. Where neighbours along a line differ and lie apart, the one in the middle is run: first along the lines of the coarse
   grid, in the end along all.
3. Where two corners of a unit cell differ, its other corners are run. A boundary is followed by this rule from wherever
   it was met, out of a coarse cell through any side, bent or not.

A node that was never run then lies in an area around which all nodes were run and are of one class: it inherits that.
So a boundary is found, whole, if it parts two nodes of the coarse grid or joins one that does. What the rules cannot
see is an area of a class of its own without a node of the coarse grid in it: an island, or a strip from edge to edge,
that slips between two coarse lines.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

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
