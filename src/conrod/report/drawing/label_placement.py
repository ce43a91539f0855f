"""Placement of labels in a drawing: the place that lies on the fewest other texts and lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conrod.exact.motion import Array

LETTER, HEIGHT = 0.6, 1.5  # width of a letter and height of a line with its white ground, of the font's size
# What a place costs: on another text, on a plate, on a line, and for being one place further down the list of wishes.
# A line under a text does not drive it far: its white ground makes it readable.
ON_TEXT, ON_PLATE, ON_LINE, NEXT_WISH = 40.0, 25.0, 4.0, 1.5
# And for lines that come with it: through a text, or the first of them across a line.
STRUCK, CROSSED = 10.0, 2.0
# Around a point: for each [pt] away from it, beyond a line, at another point or on another side than the best.
# Such a label finds a place off all lines more often, and is driven further from them.
AWAY, BEYOND_LINE, ASIDE, OFF_LINES = 0.1, 4.0, 0.8, 3.0
NEAR, STEP, RINGS, DIRECTIONS = 4.0, 5.0, 8, 24  # where a label may be tried around its point [pt]
COARSE = 20  # samples of a curve that labels take for a straight piece
CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


class LabelPlacement:
    """Texts and lines that are drawn already; lengths in the drawing's unit."""

    def __init__(self, point: float, first: bool = False) -> None:
        """A drawing with nothing on it.

        Args:
            point: length of one point on paper, kept as an attribute.
            first: whether the first wish is always granted, on a drawing that was laid out by hand.
        """
        self.point, self._first = point, first
        self._texts: list[Array] = []
        self._lines: list[Array] = []
        self._plates: list[Array] = []

    def width(self, text: str, size: float) -> float:
        """Width of a text of a font size [pt], about."""
        return LETTER * size * len(text) * self.point

    def box(self, centre: Array, text: str, size: float, turned: float = 0.0) -> Array:
        """Corners (4, 2) of a text of a font size [pt] around its centre (2,), turned by an angle [deg]."""
        turn = math.radians(turned)
        along = 0.5 * self.width(text, size) * np.array([math.cos(turn), math.sin(turn)])
        up = 0.5 * HEIGHT * size * self.point * np.array([-math.sin(turn), math.cos(turn)])
        return np.asarray(centre + np.array([-along - up, along - up, along + up, -along + up]))

    def mark(self, centre: Array, radius: float) -> None:
        """Texts avoid a symbol as they avoid each other."""
        self._texts.append(centre + radius * CORNERS)

    def take(self, box: Array) -> None:
        """A text is there, as corners (4, 2)."""
        self._texts.append(box)

    def cover(self, plate: Array) -> None:
        """A convex plate is there, as corners (N, 2)."""
        self._plates.append(plate)

    def draw(self, line: Array) -> None:
        """Lines from place to place (N, 2) are there."""
        self._lines += [np.array(piece) for piece in pairwise(line)]

    def draw_curve(self, curve: Array) -> None:
        """A curve of many samples (N, 2) is there, in straight pieces."""
        self.draw(curve[:: min(len(curve) - 1, COARSE)])

    def best(self, places: Sequence[tuple[Array, Sequence[Array]]]) -> int:
        """Index of the best place; each is a text's corners and the lines (2, 2) that come with it, by preference."""
        if self._first:
            return 0
        costs = NEXT_WISH * np.arange(len(places)) + self._cost(np.array([box for box, _ in places]))
        for k, (_, lines) in enumerate(places):
            costs[k] += STRUCK * sum(bool(_overlap(line[None], text)[0]) for line in lines for text in self._texts)
            costs[k] += CROSSED * sum(
                bool(_overlap(line[None], other)[0]) for line in lines[:1] for other in self._lines
            )
        return int(np.argmin(costs))

    def beside(self, points: Array, extent: Array, paper: Array, towards: Array | None = None) -> Array:
        """Centre (2,) of the best place for a label around some points, which it takes.

        Args:
            points: where it belongs, the best first; (N, 2).
            extent: width and height of the label.
            paper: upper right corner of the paper, which begins at the origin.
            towards: the side (2,) of a point that it had best be on; None for any.
        """
        turns = np.arange(DIRECTIONS) * 2.0 * math.pi / DIRECTIONS
        k, ring, turn = (grid.ravel() for grid in np.meshgrid(range(len(points)), range(RINGS), turns, indexing="ij"))
        away, reach = np.column_stack([np.cos(turn), np.sin(turn)]), (NEAR + STEP * ring) * self.point
        centres = points[k] + away * reach[:, None] + 0.5 * away * extent
        cost = AWAY * reach / self.point + ASIDE * k + self._cost(centres[:, None] + 0.5 * extent * CORNERS, OFF_LINES)
        cost += ON_TEXT * np.any((centres < 0.5 * extent) | (centres + 0.5 * extent > paper), axis=1)
        # What parts a label from its point, which may lie on a line itself.
        starts = points[k] + 0.5 * NEAR * self.point * away
        cost += BEYOND_LINE * sum(_crossed(line, starts, centres) for line in self._lines)
        if towards is not None:
            cost += ASIDE * (1.0 - away @ towards)
        # Rounded, so that the last bit of a cost does not choose between two places.
        best = np.round(centres[int(np.round(cost, 6).argmin())], 2)
        self.take(best + 0.5 * extent * CORNERS)
        return np.asarray(best)

    def _cost(self, boxes: Array, off_lines: float = 1.0) -> Array:
        """Of texts with corners (C, 4, 2) on others and on lines, these by a factor; (C,)."""
        cost = np.zeros(len(boxes))
        covered = (self._texts, ON_TEXT), (self._plates, ON_PLATE), (self._lines, off_lines * ON_LINE)
        for others, weight in covered:
            for other in others:
                cost += weight * _overlap(boxes, other)
        return cost


def _overlap(outlines: Array, other: Array) -> NDArray[np.bool_]:
    """False (C,) for those of some convex outlines (C, N, 2) that a line parts from another outline (M, 2).

    Such a line is along a side of one of the two.
    """
    apart = np.zeros(len(outlines), dtype=bool)
    for k in range(outlines.shape[1]):
        side = outlines[:, (k + 1) % outlines.shape[1]] - outlines[:, k]
        normals = np.column_stack([-side[:, 1], side[:, 0]])
        apart |= _parted(np.einsum("cni,ci->cn", outlines, normals), normals @ other.T)
    for side in np.roll(other, -1, axis=0) - other:
        normal = np.array([-side[1], side[0]])
        apart |= _parted(outlines @ normal, (other @ normal)[None])
    return ~apart


def _parted(one: Array, other: Array) -> NDArray[np.bool_]:
    """True (C,) where the ranges of two rows of numbers have nothing in common."""
    return np.asarray((one.max(axis=1) < other.min(axis=1)) | (other.max(axis=1) < one.min(axis=1)))


def _crossed(segment: Array, starts: Array, stops: Array) -> NDArray[np.bool_]:
    """Crossings (C,) of a segment by ways from starts to stops, (C, 2) each."""
    way, ways = segment[1] - segment[0], stops - starts

    def side(along: Array, arm: Array) -> Array:
        return np.asarray(along[..., 0] * arm[..., 1] - along[..., 1] * arm[..., 0])

    apart = side(way, starts - segment[0]) * side(way, stops - segment[0]) < 0.0
    return np.asarray(apart & (side(ways, segment[0] - starts) * side(ways, segment[1] - starts) < 0.0))
