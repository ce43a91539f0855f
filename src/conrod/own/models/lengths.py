"""Smallest sets of wrong lengths or misplaced points with which a model is the machine after all."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np

from conrod.errors import InvalidInput
from conrod.own.models.fitting import FrameFit, Search, fitted
from conrod.own.models.references import ALL_LENGTHS, length_names, length_of
from conrod.scenes import Scene

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


# Lengths, and points, that are not as expected.
Change = tuple[tuple[str, ...], tuple[str, ...]]


def solutions(search: Search, start: FrameFit, floor: float) -> tuple[Solution, ...]:
    """The smallest sets of changes that leave nothing, all of one size.

    Args:
        start: the frame that the expected lengths fit best.
        floor: a distance, over the point's length, that is nothing.
    """
    for changes in _changes(search):
        found = [one for change in changes if (one := _solved(search, start, change)) is not None]
        if enough := [one for one in found if one.explanation.left <= floor]:
            return tuple(sorted(enough, key=lambda one: len(one.explanation.misplaced)))
    return ()


def _changes(search: Search) -> Iterator[list[Change]]:
    """Sets of changes, more and more together; all lengths at last."""
    single: list[Change] = [((name,), ()) for name in length_names(search.scene)]
    single += [((), (point,)) for point in search.scan.points]
    for count in range(1, MOST_TOGETHER + 1):
        together = (tuple(zip(*some, strict=True)) for some in combinations(single, count))
        yield [(tuple(chain(*lengths)), tuple(chain(*points))) for lengths, points in together]
    yield [(search.lengths, ())]


def _solved(search: Search, start: FrameFit, change: Change) -> Solution | None:
    """A change with the free parts of the frame, fitted; None where that leads to no machine."""
    (names, points), expected = change, search.scene
    try:
        there, scene = fitted(search, start, expected, names, points)
    except InvalidInput:
        return None
    away = dict(zip(search.scan.points, np.abs(there.displacements).tolist(), strict=True))
    others = [n for n in search.lengths if n not in names and length_of(expected, n) != 0.0]
    factor = length_of(scene, others[0]) / length_of(expected, others[0]) if others else 1.0
    found = {name: factor if name == ALL_LENGTHS else length_of(scene, name) for name in names}
    lengths = tuple(Length(name, length_of(expected, name), value) for name, value in found.items())
    misplaced = tuple(Misplaced(point, away[point]) for point in points)
    return Solution(Explanation(lengths, misplaced, there.largest), scene, there)
