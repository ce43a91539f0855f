"""Placement of texts in a drawing: of some places the one that lies on the least of what is there already."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.path import Path
from numpy.typing import NDArray

from conrod.exact.motion import Array

LETTER, HEIGHT = 0.6, 1.5  # width of a letter and height of a line with its white ground, of the font's size
SPACING = 3.0  # of the samples [pt] that stand for what is drawn
# What a sample under a text costs; under a line that comes with the text it costs a share. A line under a text does not
# drive it far: its white ground makes it readable.
ON_TEXT, ON_PLATE, ON_LINE, UNDER_LINE = 5.0, 0.6, 1.0, 0.3
NEXT_WISH = 1.0  # for being one place further down the list of wishes


@dataclass(frozen=True)
class Box:
    """A rectangle in the drawing: its centre (2,), half its width and height, and its turn [rad]."""

    centre: Array
    half: tuple[float, float]
    turn: float = 0.0

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """True (N,) for points (N, 2) in it."""
        cos, sin = math.cos(self.turn), math.sin(self.turn)
        own = (points - self.centre) @ np.array([[cos, -sin], [sin, cos]])
        return np.asarray((np.abs(own) <= self.half).all(axis=1))

    def samples(self, spacing: float) -> Array:
        """Points (N, 2) all over it, its edges included."""
        x, y = (np.linspace(-half, half, 2 + int(2.0 * half / spacing)) for half in self.half)
        own = np.column_stack([grid.ravel() for grid in np.meshgrid(x, y)])
        cos, sin = math.cos(self.turn), math.sin(self.turn)
        return np.asarray(self.centre + own @ np.array([[cos, sin], [-sin, cos]]))


class Labels:
    """Texts, lines and plates that are drawn already, as samples; lengths in the drawing's unit."""

    def __init__(self, point: float) -> None:
        """A drawing with nothing on it; `point` is the length of one point on paper."""
        self.point, self._spacing = point, SPACING * point
        self._points, self._costs = [np.empty((0, 2))], [np.empty(0)]

    def width(self, text: str, size: float) -> float:
        """Width of a text of a font size [pt], about."""
        return LETTER * size * len(text) * self.point

    def box(self, centre: Array, text: str, size: float, turn: float = 0.0) -> Box:
        """The place of a text of a font size [pt] around its centre (2,), turned by an angle [rad]."""
        return Box(centre, (0.5 * self.width(text, size), 0.5 * HEIGHT * size * self.point), turn)

    def take(self, box: Box) -> None:
        """A text or a symbol is there."""
        self._add(box.samples(self._spacing), ON_TEXT)

    def mark(self, centre: Array, radius: float) -> None:
        """A symbol is there."""
        self.take(Box(centre, (radius, radius)))

    def cover(self, plate: Array) -> None:
        """A plate is there, as corners (N, 2)."""
        low, high = plate.min(axis=0), plate.max(axis=0)
        reach = 0.5 * (high - low)
        points = Box(low + reach, (float(reach[0]), float(reach[1]))).samples(self._spacing)
        self._add(points[Path(plate).contains_points(points)], ON_PLATE)

    def draw(self, line: Array) -> None:
        """Lines from place to place (N, 2) are there."""
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        at = np.linspace(0.0, along[-1], 2 + int(along[-1] / self._spacing))
        self._add(np.column_stack([np.interp(at, along, values) for values in line.T]), ON_LINE)

    def best(self, wishes: Sequence[tuple[Box, Sequence[Array]]]) -> int:
        """Index of the best place; each is a text's box and the lines (2, 2) that come with it, by preference."""
        points, costs = np.concatenate(self._points), np.concatenate(self._costs)
        found = [
            NEXT_WISH * k
            + costs[box.holds(points)].sum()
            + UNDER_LINE * sum(costs[self._strip(line).holds(points)].sum() for line in lines)
            for k, (box, lines) in enumerate(wishes)
        ]
        return int(np.argmin(np.round(found, 6)))

    def _strip(self, line: Array) -> Box:
        """The neighbourhood of a straight line (2, 2)."""
        (x, y), half = line[1] - line[0], 0.5 * self._spacing
        return Box(line.mean(axis=0), (0.5 * math.hypot(x, y), half), math.atan2(y, x))

    def _add(self, points: Array, cost: float) -> None:
        self._points.append(points)
        self._costs.append(np.full(len(points), cost))
