"""Names beside points of a diagram, placed so that they cover neither each other nor what is marked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array

Place = tuple[float, float]

# Directions from a point, best first: a front has nothing of its own below it and to its left.
DIRECTIONS = ((-0.8, -0.6), (-1.0, 0.0), (-0.3, -1.0), (-0.9, 0.45), (0.3, -1.0), (0.9, -0.45), (0.0, 1.0), (0.9, 0.45))
DISTANCES = (12.0, 16.0, 22.0, 30.0, 40.0, 52.0)  # [pt]
FAR = 13.0  # [pt]: a name at this distance or more needs a line to its point
MARKED = 4.5  # half the side of a marked point [pt]
ON_NAME, OUTSIDE, ON_MARK, ON_DOT = 1000.0, 1000.0, 60.0, 1.0


@dataclass(frozen=True)
class Box:
    """A rectangle about a place [pt]."""

    x: float
    y: float
    half_width: float
    half_height: float

    def touches(self, other: Box) -> bool:
        """Whether the two overlap."""
        wide = abs(self.x - other.x) < self.half_width + other.half_width
        return wide and abs(self.y - other.y) < self.half_height + other.half_height

    def count(self, places: Array, reach: float) -> int:
        """How many squares about places (K, 2), of half a side `reach`, overlap it."""
        wide = np.abs(places[:, 0] - self.x) < self.half_width + reach
        return int((wide & (np.abs(places[:, 1] - self.y) < self.half_height + reach)).sum())

    def inside(self, width: float, height: float) -> bool:
        """Whether it lies within a panel whose lower left corner is the origin."""
        left, low = self.x - self.half_width, self.y - self.half_height
        return left >= 0.0 and low >= 0.0 and self.x + self.half_width <= width and self.y + self.half_height <= height


@dataclass(frozen=True)
class Name:
    """A text at an offset [pt] from its point, centred."""

    text: str
    offset: Place

    @property
    def needs_line(self) -> bool:
        """Whether it is too far from its point to be read as its name without a line."""
        return self.offset[0] ** 2 + self.offset[1] ** 2 >= FAR**2


def placed_names(
    texts: Sequence[str], at: Sequence[Place], marks: Sequence[Place], dots: Sequence[Place], panel: Place, size: float
) -> list[Name]:
    """Place a name beside each point, one after the other, where it covers least.

    Args:
        texts: the names.
        at: their points [pt] from the lower left corner of the panel.
        marks: points that should stay free: those that are named, and those of highlighted curves [pt].
        dots: points that may be covered where nothing else is left [pt].
        panel: width and height of the panel [pt].
        size: of the font [pt].
    """
    stay_free, may_cover = _places(marks), _places(dots)
    taken: list[Box] = []
    names = []
    for text, point in zip(texts, at, strict=True):
        size_of = (0.36 * size * len(text), 0.6 * size)
        tried = []
        for distance in DISTANCES:
            for rank, (dx, dy) in enumerate(DIRECTIONS):
                offset = (distance * dx, distance * dy)
                box = Box(point[0] + offset[0], point[1] + offset[1], *size_of)
                burden = ON_NAME * sum(box.touches(other) for other in taken)
                burden += ON_MARK * box.count(stay_free, MARKED) + ON_DOT * box.count(may_cover, 1.0)
                burden += OUTSIDE * (not box.inside(*panel)) + 0.1 * distance + 0.1 * rank
                tried.append((burden, offset, box))
        _, offset, box = min(tried, key=lambda one: one[0])
        taken.append(box)
        names.append(Name(text, offset))
    return names


def _places(places: Sequence[Place]) -> Array:
    return np.asarray(places, dtype=float).reshape(-1, 2)
