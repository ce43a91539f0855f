"""What a table says: sampled motion in SI units, as far as it has columns for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from conrod.exact.motion import Array

QUANTITIES = ("position", "velocity", "acceleration")


@dataclass(frozen=True)
class Samples:
    """One quantity of one point; a table may have one of its two components alone.

    Attributes:
        values: (T, c), SI.
        axes: which component each column is, 0 for x and 1 for y.
    """

    values: Array
    axes: tuple[int, ...]

    @property
    def whole(self) -> bool:
        """Whether both components are there."""
        return len(self.axes) == 2


@dataclass(frozen=True)
class Observed:
    """All that a table says.

    Attributes:
        times: (T,) [s], increasing.
        angle, rate, acceleration: of the crank by the table's own account (T,) [rad, rad/s, rad/s^2], None without.
        points: samples by point and quantity (`QUANTITIES`).
    """

    times: Array
    angle: Array | None
    rate: Array | None
    acceleration: Array | None
    points: Mapping[str, Mapping[str, Samples]]

    @property
    def step(self) -> float:
        """Time from row to row [s], the median."""
        return float(np.median(np.diff(self.times)))

    def has(self, quantity: str) -> bool:
        """Whether any point has the quantity."""
        return any(quantity in samples for samples in self.points.values())

    def thinned(self, most: int) -> Observed:
        """At most so many rows, evenly spread, the first and the last among them."""
        count = len(self.times)
        if count <= most:
            return self
        keep = np.unique(np.rint(np.linspace(0, count - 1, most)).astype(int))
        crank = (None if column is None else column[keep] for column in (self.angle, self.rate, self.acceleration))
        angle, rate, acceleration = crank
        points = {
            name: {quantity: replace(s, values=s.values[keep]) for quantity, s in samples.items()}
            for name, samples in self.points.items()
        }
        return Observed(self.times[keep], angle, rate, acceleration, points)
