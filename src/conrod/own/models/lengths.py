"""Smallest sets of wrong lengths or misplaced points with which a model is the machine after all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.fitting import (
    FrameFit,
    ObservedPaths,
    distances,
    free_of,
    indistinct,
    least_distances,
    slopes,
    with_distances,
)
from conrod.own.models.frame import GivenFrame
from conrod.own.models.references import ALL_LENGTHS, length_names, length_of, paths_of, with_lengths
from conrod.scenes import Scene

# A direction of the lengths whose trace is this share of the clearest one's leaves none.
NO_TRACE = 1e-7
MOST_TOGETHER = 3


@dataclass(frozen=True)
class Length:
    """One length as it is expected and as it is found [m]; of all lengths together the factor."""

    name: str
    expected: float
    found: float

    @property
    def excess(self) -> float | None:
        """Share by which it is too long; None for one that is expected to be zero."""
        return None if self.expected == 0.0 else self.found / self.expected - 1.0


@dataclass(frozen=True)
class Misplaced:
    """An observed point that is not where it should be on its link, and how far from there [m]."""

    point: str
    away: float


@dataclass(frozen=True)
class Explanation:
    """Lengths and places with which the exact paths lie over those of the model.

    Attributes:
        left: largest distance that they leave, over the point's length.
    """

    lengths: tuple[Length, ...]
    misplaced: tuple[Misplaced, ...]
    left: float


@dataclass(frozen=True)
class Solution:
    """An explanation with the machine of its lengths and the frame that fits it."""

    explanation: Explanation
    scene: Scene
    fit: FrameFit


@dataclass(frozen=True)
class Search:
    """The paths to be explained.

    Attributes:
        floor: a distance, over the point's length, that is rounding or the error of a collision shape.
    """

    scene: Scene
    points: tuple[str, ...]
    observed: ObservedPaths
    given: GivenFrame
    floor: float

    @property
    def lengths(self) -> tuple[str, ...]:
        """Names of the lengths, without that of all together."""
        return tuple(name for name in length_names(self.scene) if name != ALL_LENGTHS)

    @property
    def size(self) -> float:
        """Largest length of the machine [m], to judge small lengths by."""
        return max(abs(length_of(self.scene, name)) for name in self.lengths)


@dataclass(frozen=True)
class _Change:
    """Lengths and points that are not as expected."""

    lengths: tuple[str, ...] = ()
    points: tuple[str, ...] = ()


def solutions(search: Search, start: FrameFit) -> tuple[tuple[Solution, ...], Solution | None]:
    """The smallest sets of changes that leave nothing, all of one size; and the closest one there is.

    Args:
        start: the frame that the expected lengths fit best.
    """
    closest: Solution | None = None
    for changes in _changes(search):
        found = [one for one in (_solved(search, start, change) for change in changes) if one is not None]
        closest = min([*found, *([closest] if closest else [])], key=lambda one: one.explanation.left, default=None)
        enough = [one for one in found if one.explanation.left <= search.floor]
        if enough:
            enough.sort(key=lambda one: len(one.explanation.misplaced))
            return tuple(enough), enough[0]
    return (), closest


def _changes(search: Search) -> Iterator[list[_Change]]:
    """Sets of changes, more and more together; all lengths at last."""
    every = [_Change((name,)) for name in length_names(search.scene)]
    every += [_Change((), (point,)) for point in search.points]
    for count in range(1, MOST_TOGETHER + 1):
        yield [
            _Change(tuple(n for c in some for n in c.lengths), tuple(p for c in some for p in c.points))
            for some in combinations(every, count)
        ]
    yield [_Change(search.lengths)]


class _Fit:
    """The unknowns of a fit in one vector: free parts of the frame, lengths, and places of points on their links."""

    def __init__(self, search: Search, start: FrameFit, change: _Change, scene: Scene) -> None:
        self._search, self._start, self._change, self._scene = search, start, change, scene
        self._frame = free_of(search.given)
        self._rows = [search.points.index(point) for point in change.points]
        self.names = [*self._frame, *change.lengths]  # of the unknowns, but for the places
        places = start.displacements[self._rows]
        frame, lengths = [getattr(start, n) for n in self._frame], [length_of(scene, n) for n in change.lengths]
        self.start = np.concatenate([frame, lengths, places.real, places.imag])
        sizes = [1.0 if name == ALL_LENGTHS else search.size for name in change.lengths]
        self.sizes = np.array([1.0] * len(self._frame) + sizes + [search.size] * (2 * len(self._rows)))

    def split(self, x: Array) -> tuple[FrameFit, Scene]:
        """The frame and the machine of the unknowns."""
        frame, lengths, places = np.split(x, np.cumsum([len(self._frame), len(self._change.lengths)]))
        moved = self._start.displacements.copy()
        half = len(self._rows)
        moved[self._rows] = places[:half] + 1j * places[half:]
        there = replace(self._start, displacements=moved).at(dict(zip(self._frame, frame.tolist(), strict=True)))
        return there, with_lengths(self._scene, self._change.lengths, lengths)

    def left(self, x: Array) -> Array:
        """Distances (P, T)."""
        there, scene = self.split(x)
        return distances(self._search.observed, paths_of(scene, self._search.points), there)


def _solved(search: Search, start: FrameFit, change: _Change) -> Solution | None:
    """A change with the free parts of the frame, fitted; None where that leads to no machine."""
    fit = _Fit(search, start, change, search.scene)
    try:
        there, scene = fit.split(least_distances(fit.left, fit.start, fit.sizes))
    except InvalidInput:
        return None
    there = with_distances(there, search.observed, paths_of(scene, search.points))
    away = dict(zip(search.points, np.abs(there.displacements).tolist(), strict=True))
    misplaced = tuple(Misplaced(point, away[point]) for point in change.points)
    return Solution(Explanation(_lengths(search, scene, change.lengths), misplaced, there.largest), scene, there)


def _lengths(search: Search, found: Scene, names: Sequence[str]) -> tuple[Length, ...]:
    expected = search.scene
    others = [n for n in search.lengths if n not in names and length_of(expected, n) != 0.0]
    factor = length_of(found, others[0]) / length_of(expected, others[0]) if others else 1.0
    return tuple(
        Length(name, length_of(expected, name), factor if name == ALL_LENGTHS else length_of(found, name))
        for name in names
    )


def without_trace(search: Search, at: FrameFit, scene: Scene) -> tuple[tuple[str, ...], ...]:
    """Groups of lengths, and free parts of the frame, that the given points cannot distinguish."""
    fit = _Fit(search, at, _Change(search.lengths), scene)
    return indistinct(slopes(fit.left, fit.start, fit.sizes), fit.names, NO_TRACE)
