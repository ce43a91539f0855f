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
            costs[k] += STRUCK * _overlaps(lines, self._texts).sum() + CROSSED * _overlaps(lines[:1], self._lines).sum()
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
            cost += weight * _overlaps(boxes, others)
        return cost


def _overlaps(outlines: Array | Sequence[Array], others: Sequence[Array]) -> Array:
    """How many of some other convex outlines, corners (M, 2) each, each of some (C, N, 2) overlaps; (C,)."""
    count = np.zeros(len(outlines))
    if not len(outlines):
        return count
    outlines = np.asarray(outlines)
    for corners in {len(other) for other in others}:
        some = np.array([other for other in others if len(other) == corners])
        # Few of a large drawing are anywhere near.
        near = (some.max(axis=1) >= outlines.min(axis=(0, 1))) & (some.min(axis=1) <= outlines.max(axis=(0, 1)))
        count += _overlap(outlines, some[near.all(axis=1)]).sum(axis=1)
    return count


def _overlap(outlines: Array, others: Array) -> NDArray[np.bool_]:
    """False (C, M) where a line parts a convex outline (C, N, 2) from another one (M, K, 2).

    Such a line is along a side of one of the two.
    """
    apart = np.zeros((len(outlines), len(others)), dtype=bool)
    for side in np.moveaxis(np.roll(outlines, -1, axis=1) - outlines, 1, 0):
        normals = np.column_stack([-side[:, 1], side[:, 0]])
        own = np.einsum("cni,ci->cn", outlines, normals)
        apart |= _parted(own[:, None], np.einsum("ci,mki->cmk", normals, others))
    for side in np.moveaxis(np.roll(others, -1, axis=1) - others, 1, 0):
        normals = np.column_stack([-side[:, 1], side[:, 0]])
        own = np.einsum("mki,mi->mk", others, normals)
        apart |= _parted(np.einsum("cni,mi->cmn", outlines, normals), own[None])
    return ~apart


def _parted(one: Array, other: Array) -> NDArray[np.bool_]:
    """True (C, M) where the ranges of two rows of numbers, along the last axis, have nothing in common."""
    return np.asarray((one.max(axis=-1) < other.min(axis=-1)) | (other.max(axis=-1) < one.min(axis=-1)))


def _crossed(segment: Array, starts: Array, stops: Array) -> NDArray[np.bool_]:
    """Crossings (C,) of a segment by ways from starts to stops, (C, 2) each."""
    way, ways = segment[1] - segment[0], stops - starts

    def side(along: Array, arm: Array) -> Array:
        return np.asarray(along[..., 0] * arm[..., 1] - along[..., 1] * arm[..., 0])

    apart = side(way, starts - segment[0]) * side(way, stops - segment[0]) < 0.0
    return np.asarray(apart & (side(ways, segment[0] - starts) * side(ways, segment[1] - starts) < 0.0))
