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

Classes may come in groups. Boundaries between groups are followed whatever they cost; those between classes of one
group afterwards, and only as long as an allowance lasts: where the class changes from node to node, as the way does in
which a chaotic motion ends, there is no boundary to follow, and nothing is gained by running every node.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Mapping
from itertools import product
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

STRIDE = 8
UNKNOWN = -1

Node = tuple[int, int]  # indices along the two axes
Class = TypeVar("Class", bound=Hashable)
Codes = NDArray[np.int_]  # a number for each class, or UNKNOWN
# Yields the nodes to be run next, is sent their classes, returns the class of every node that was run.
Refinement = Generator[tuple[Node, ...], Mapping[Node, Class], dict[Node, Class]]


def refine(
    shape: tuple[int, int],
    stride: int = STRIDE,
    group_of: Callable[[Class], Hashable] = lambda found: found,
    allowance: float = 1.0,
) -> Refinement[Class]:
    """Find the class of every node of a grid; return those of the nodes that were run, in their order.

    Args:
        shape: number of nodes along the two axes, at least 2 each.
        stride: of the coarse grid, in nodes. The last row and the last column are in it whatever their distance.
        group_of: the group of a class; each is its own unless something else is said.
        allowance: runs over nodes beyond which no boundary within a group is followed.

    Raises:
        ValueError: a grid or a stride without meaning.
    """
    if min(shape) < 2 or stride < 1:
        raise ValueError(f"a grid of {shape[0]} x {shape[1]} nodes cannot be refined from every {stride}th")
    lines = _coarse(shape[0], stride), _coarse(shape[1], stride)
    found: dict[Node, Class] = {}
    groups, classes = _Codes(shape), _Codes(shape)
    wanted = [(i, j) for i in lines[0] for j in lines[1]]
    while wanted:
        answers = yield tuple(wanted)
        for node in wanted:
            found[node] = answers[node]
            groups.set(node, group_of(answers[node]))
            classes.set(node, answers[node])
        wanted = groups.wanted(*lines)
        if not wanted:
            wanted = classes.wanted(*lines)
            if len(found) + len(wanted) > allowance * shape[0] * shape[1]:
                break
    return found


def nearest_runs(shape: tuple[int, int], run: Iterable[Node]) -> dict[Node, Node]:
    """Return of every node the run one that is reached from it in the fewest steps along the grid's lines."""
    sources = {node: node for node in sorted(run)}
    ahead = deque(sources)
    while ahead:
        here = ahead.popleft()
        for node in _neighbours(here, shape):
            if node not in sources:
                sources[node] = sources[here]
                ahead.append(node)
    return sources


def known_nodes(shape: tuple[int, int], found: Mapping[Node, Class]) -> set[Node]:
    """Return the nodes whose class is known: those that were run, and areas of others surrounded by one class."""
    known, reached = set(found), set(found)
    for start in product(range(shape[0]), range(shape[1])):
        if start not in reached:
            area, around = _area(start, shape, found)
            reached |= area
            if len(around) == 1:
                known |= area
    return known


def _area(start: Node, shape: tuple[int, int], found: Mapping[Node, Class]) -> tuple[set[Node], set[Class]]:
    """Nodes that are joined to one without a run between, and the classes of the runs about them."""
    area, around, ahead = {start}, set(), [start]
    while ahead:
        for node in _neighbours(ahead.pop(), shape):
            if node in found:
                around.add(found[node])
            elif node not in area:
                area.add(node)
                ahead.append(node)
    return area, around


def _neighbours(node: Node, shape: tuple[int, int]) -> list[Node]:
    i, j = node
    beside = ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1))
    return [(k, m) for k, m in beside if 0 <= k < shape[0] and 0 <= m < shape[1]]


def _coarse(length: int, stride: int) -> tuple[int, ...]:
    return (*range(0, length - 1, stride), length - 1)


class _Codes:
    """A grid with a number for every label that is known so far."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self._numbers: dict[Hashable, int] = {}
        self._known = np.full(shape, UNKNOWN)

    def set(self, node: Node, label: Hashable) -> None:
        """Label a node."""
        self._known[node] = self._numbers.setdefault(label, len(self._numbers))

    def wanted(self, rows: Iterable[int], columns: Iterable[int]) -> list[Node]:
        """Return the nodes that the rules ask for; along all lines only where they ask for nothing along some."""
        some = {*_middles(self._known, rows, columns), *_corners(self._known)}
        return sorted(some or _middles(self._known, *map(range, self._known.shape)))


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
    corners = np.stack([known[:-1, :-1], known[:-1, 1:], known[1:, :-1], known[1:, 1:]])
    unknown = corners == UNKNOWN
    least = np.where(unknown, np.iinfo(known.dtype).max, corners).min(axis=0)
    crossed = corners.max(axis=0) > least
    wanted = np.zeros(known.shape, dtype=bool)
    wanted[:-1, :-1] |= crossed
    wanted[:-1, 1:] |= crossed
    wanted[1:, :-1] |= crossed
    wanted[1:, 1:] |= crossed
    return [(int(i), int(j)) for i, j in np.argwhere(wanted & (known == UNKNOWN))]
