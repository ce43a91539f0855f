"""Placement of labels in a drawing: the place that lies on the fewest other texts and lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from conrod.exact.motion import Array

LETTER, HEIGHT = 0.6, 1.5  # width of a letter and height of a line with its white ground, of the font's size
# What a place costs: on another text, on a line, and for being one place further down the list of wishes. A line
# under a text does not drive it far: its white ground makes it readable.
ON_TEXT, ON_LINE, NEXT_WISH = 40.0, 4.0, 3.0


class Room:
    """Texts and lines that are drawn already; lengths in the drawing's unit."""

    def __init__(self, point: float, first: bool = False) -> None:
        """A drawing with nothing on it.

        Args:
            point: length of one point on paper.
            first: whether the first wish is always granted, on a drawing that was laid out by hand.
        """
        self._point, self._first = point, first
        self._texts: list[Array] = []
        self._lines: list[Array] = []

    def box(self, centre: Array, text: str, size: float, turned: float = 0.0) -> Array:
        """Corners (4, 2) of a text of a font size [pt] around its centre (2,), turned by an angle [deg]."""
        turn = math.radians(turned)
        along = 0.5 * LETTER * size * len(text) * self._point * np.array([math.cos(turn), math.sin(turn)])
        up = 0.5 * HEIGHT * size * self._point * np.array([-math.sin(turn), math.cos(turn)])
        return np.asarray(centre + np.array([-along - up, along - up, along + up, -along + up]))

    def mark(self, centre: Array, radius: float) -> None:
        """Texts avoid a symbol as they avoid each other."""
        corners = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
        self._texts.append(centre + radius * corners)

    def take(self, box: Array) -> None:
        """A text is there, as corners (4, 2)."""
        self._texts.append(box)

    def draw(self, line: Array) -> None:
        """Lines from place to place (N, 2) are there."""
        self._lines += [np.array(piece) for piece in pairwise(line)]

    def best(self, places: Sequence[tuple[Array, Sequence[Array]]]) -> int:
        """Index of the best place; each is a text's corners and the lines (2, 2) that come with it, by preference."""
        if self._first:
            return 0
        costs = [NEXT_WISH * k + self._cost(box, lines) for k, (box, lines) in enumerate(places)]
        return int(np.argmin(costs))

    def _cost(self, box: Array, lines: Sequence[Array]) -> float:
        on_texts = sum(not _apart(box, other) for other in self._texts)
        on_lines = sum(not _apart(box, line) for line in self._lines)
        struck = sum(not _apart(line, other) for line in lines for other in self._texts)
        return ON_TEXT * (on_texts + 0.25 * struck) + ON_LINE * on_lines


def _apart(one: Array, other: Array) -> bool:
    """True where some line parts two convex outlines (N, 2), (M, 2), which is along a side of one of them."""
    for outline in (one, other):
        sides = np.roll(outline, -1, axis=0) - outline
        for normal in np.column_stack([-sides[:, 1], sides[:, 0]]):
            a, b = one @ normal, other @ normal
            if a.max() < b.min() or b.max() < a.min():
                return True
    return False
