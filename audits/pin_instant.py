"""Velocities and accelerations of a pin-jointed linkage at one instant, from the places of its points alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array

Vectors = Mapping[str, Array]


@dataclass(frozen=True)
class PinInstant:
    """Points at known places; every bar keeps their distance, every guide lets a point move along a line alone.

    Attributes:
        places: by name, (2,) [m].
        bars: pairs of points of one link.
        guides: the direction across the line on which a point slides, (2,).
    """

    places: Vectors
    bars: Sequence[tuple[str, str]]
    guides: Vectors

    def velocities(self, driven: Vectors) -> Vectors:
        """Velocities of all points (2,) [m/s] from those of the driven and the fixed ones.

        From |a - b| constant: (a - b) . (a' - b') = 0.
        """
        return self._solve(driven, [0.0] * len(self.bars))

    def accelerations(self, driven: Vectors, velocities: Vectors) -> Vectors:
        """Accelerations (2,) [m/s^2]: (a - b) . (a'' - b'') = -|a' - b'|^2."""
        return self._solve(driven, [-float(np.sum((velocities[a] - velocities[b]) ** 2)) for a, b in self.bars])

    def _solve(self, driven: Vectors, wanted: Sequence[float]) -> Vectors:
        free = [name for name in self.places if name not in driven]
        column = {name: 2 * k for k, name in enumerate(free)}
        rows: list[Array] = []
        rest: list[float] = []
        for (a, b), value in zip(self.bars, wanted, strict=True):
            known = 0.0
            row, apart = np.zeros(2 * len(free)), self.places[a] - self.places[b]
            for name, sign in ((a, 1.0), (b, -1.0)):
                if name in column:
                    row[column[name] : column[name] + 2] += sign * apart
                else:
                    known += sign * float(apart @ driven[name])
            rows.append(row)
            rest.append(value - known)
        for name, across in self.guides.items():
            row = np.zeros(2 * len(free))
            row[column[name] : column[name] + 2] = across
            rows.append(row)
            rest.append(0.0)
        # Least squares, because auxiliary points are held by more bars than they need; places that fit leave nothing.
        found = np.linalg.lstsq(np.array(rows), np.array(rest), rcond=None)[0]
        return {**driven, **{name: found[k : k + 2] for name, k in column.items()}}


def turned(vector: Array) -> Array:
    """A vector (2,) turned by a right angle, counter-clockwise."""
    return np.array([-vector[1], vector[0]])


def size(vector: Array) -> float:
    """Length of a vector (2,)."""
    return float(np.hypot(*vector))
