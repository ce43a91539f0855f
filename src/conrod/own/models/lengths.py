"""What explains that a model is not the machine: one length or one misplaced point first, then pairs, then three."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.fitting import Laid, Sighting, free_of, indistinct, least_distances, miss, relaid, slopes
from conrod.own.models.frame import GivenFrame
from conrod.own.models.references import ALL_LENGTHS, length_names, length_of, paths_of, with_lengths
from conrod.scenes import Scene

# A direction of the lengths whose trace is this share of the clearest one's leaves none.
NO_TRACE = 1e-7
MOST_TOGETHER = 3


@dataclass(frozen=True)
class Length:
    """One length as it was wanted and as it is found [m]; of all lengths together the factor."""

    name: str
    wanted: float
    found: float

    @property
    def excess(self) -> float | None:
        """Share by which it is too long; None for one that was to be zero."""
        return None if self.wanted == 0.0 else self.found / self.wanted - 1.0


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
        scene: the machine with these lengths.
    """

    lengths: tuple[Length, ...]
    misplaced: tuple[Misplaced, ...]
    left: float
    scene: Scene
    laid: Laid


@dataclass(frozen=True)
class Search:
    """What is fitted.

    Attributes:
        floor: a distance, over the point's length, that is rounding or the error of a collision shape.
    """

    scene: Scene
    points: tuple[str, ...]
    seen: Sighting
    given: GivenFrame
    floor: float

    @property
    def size(self) -> float:
        """Of the machine [m], to tell small lengths by."""
        return max(abs(length_of(self.scene, n)) for n in length_names(self.scene) if n != ALL_LENGTHS)


@dataclass(frozen=True)
class _Change:
    """What is not as it was wanted."""

    lengths: tuple[str, ...] = ()
    points: tuple[str, ...] = ()


def explanations(search: Search, start: Laid) -> tuple[tuple[Explanation, ...], Explanation | None]:
    """The smallest sets of changes that leave nothing, all of one size; and the closest one there is.

    Args:
        start: the frame that the wanted lengths fit best.
    """
    closest: Explanation | None = None
    for changes in _changes(search):
        found = [e for e in (_explained(search, start, change) for change in changes) if e is not None]
        closest = min([*found, *([closest] if closest else [])], key=lambda e: e.left, default=None)
        enough = sorted((e for e in found if e.left <= search.floor), key=lambda e: len(e.misplaced))
        if enough:
            return tuple(enough), enough[0]
    return (), closest


def _changes(search: Search) -> Iterator[list[_Change]]:
    """Sets of changes, more and more together; all lengths at last."""
    names = length_names(search.scene)
    every = [*(_Change((name,)) for name in names), *(_Change((), (point,)) for point in search.points)]
    for count in range(1, MOST_TOGETHER + 1):
        yield [
            _Change(tuple(n for c in some for n in c.lengths), tuple(p for c in some for p in c.points))
            for some in combinations(every, count)
        ]
    yield [_Change(tuple(name for name in names if name != ALL_LENGTHS))]


class _Fit:
    """The unknowns of a fit in one vector: what of the frame is free, lengths, and places of points on their links."""

    def __init__(self, search: Search, start: Laid, change: _Change, scene: Scene | None = None) -> None:
        self._search, self._start, self._change = search, start, change
        self._scene = search.scene if scene is None else scene
        self._frame = free_of(search.given)
        self._rows = [search.points.index(point) for point in change.points]
        places = start.places[self._rows]
        self.start = np.concatenate(
            [
                np.array([getattr(start, name) for name in self._frame]),
                np.array([length_of(self._scene, name) for name in change.lengths]),
                places.real,
                places.imag,
            ]
        )
        lengths = [1.0 if name == ALL_LENGTHS else search.size for name in change.lengths]
        self.sizes = np.array([1.0] * len(self._frame) + lengths + [search.size] * (2 * len(self._rows)))

    @property
    def names(self) -> list[str]:
        """Of the unknowns, but for the places."""
        return [*self._frame, *self._change.lengths]

    def split(self, x: Array) -> tuple[Laid, Scene]:
        """The frame and the machine of the unknowns."""
        frame, lengths, places = np.split(x, np.cumsum([len(self._frame), len(self._change.lengths)]))
        moved = self._start.places.copy()
        half = len(self._rows)
        moved[self._rows] = places[:half] + 1j * places[half:]
        there = replace(self._start, places=moved).at(dict(zip(self._frame, frame.tolist(), strict=True)))
        return there, with_lengths(self._scene, self._change.lengths, lengths)

    def left(self, x: Array) -> Array:
        """Distances (P, T)."""
        there, scene = self.split(x)
        return miss(self._search.seen, paths_of(scene, self._search.points), there)


def _explained(search: Search, start: Laid, change: _Change) -> Explanation | None:
    """A change with what of the frame is free, fitted; None where that leads to no machine."""
    fit = _Fit(search, start, change)
    try:
        there, scene = fit.split(least_distances(fit.left, fit.start, fit.sizes))
    except InvalidInput:
        return None
    there = relaid(there, search.seen, paths_of(scene, search.points))
    away = dict(zip(search.points, np.abs(there.places).tolist(), strict=True))
    misplaced = tuple(Misplaced(point, away[point]) for point in change.points)
    return Explanation(_told(search.scene, scene, change.lengths), misplaced, there.largest, scene, there)


def _told(wanted: Scene, found: Scene, names: Sequence[str]) -> tuple[Length, ...]:
    told = []
    for name in names:
        if name == ALL_LENGTHS:
            others = [n for n in length_names(wanted) if n not in names and length_of(wanted, n) != 0.0]
            factor = length_of(found, others[0]) / length_of(wanted, others[0]) if others else 1.0
            told.append(Length(name, 1.0, factor))
        else:
            told.append(Length(name, length_of(wanted, name), length_of(found, name)))
    return tuple(told)


def without_trace(search: Search, at: Laid, scene: Scene) -> tuple[tuple[str, ...], ...]:
    """Groups of lengths, and what of the frame is free, that the given points cannot tell apart."""
    fit = _Fit(search, at, _Change(tuple(name for name in length_names(scene) if name != ALL_LENGTHS)), scene)
    return indistinct(slopes(fit.left, fit.start, fit.sizes), fit.names, NO_TRACE)
