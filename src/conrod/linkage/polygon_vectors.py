"""A velocity or acceleration polygon as data: its vectors and the places that they lead to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from conrod.motion import Array

Kind = Literal["absolute", "relative", "sliding", "normal", "tangential", "coriolis"]


@dataclass(frozen=True)
class PolygonVector:
    """One vector of a polygon.

    Attributes:
        name: as the course writes it: V_A, V_B/A, A^n_B/A, A^t_B/A, A^c_B/B4.
        start, stop: places in the polygon that it leads from and to, keys of `Polygon.places`.
        value: (2,) [m/s] or [m/s^2].
        kind: what it is.
        link: the link whose turning gives it; None for others.
    """

    name: str
    start: str
    stop: str
    value: Array
    kind: Kind
    link: str | None


@dataclass(frozen=True)
class Polygon:
    """A velocity or acceleration polygon.

    Attributes:
        quantity: "velocity" or "acceleration".
        places: end of the absolute velocity or acceleration of each point, in small letters, (2,) [m/s] or [m/s^2];
            the pole O at (0, 0); and the corners between a normal and a tangential part.
        vectors: in the order in which they are drawn.
    """

    quantity: Literal["velocity", "acceleration"]
    places: Mapping[str, Array]
    vectors: tuple[PolygonVector, ...]

    @property
    def size(self) -> float:
        """The longest vector [m/s] or [m/s^2]."""
        return max((float(np.linalg.norm(vector.value)) for vector in self.vectors), default=0.0)

    @property
    def gap(self) -> float:
        """The farthest that a vector misses the place that it leads to, against the longest vector [1]."""
        misses = [
            float(np.linalg.norm(self.places[vector.start] + vector.value - self.places[vector.stop]))
            for vector in self.vectors
        ]
        return max(misses, default=0.0) / (self.size or 1.0)

    def vector(self, name: str) -> PolygonVector:
        """The vector of a name; KeyError if there is none."""
        found = {vector.name: vector for vector in self.vectors}
        return found[name]
