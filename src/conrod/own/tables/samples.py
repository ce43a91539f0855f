"""What a table says: sampled motion in SI units, as far as it has columns for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
        rows = self.with_samples(lambda _, samples: replace(samples, values=samples.values[keep]))
        return replace(rows.with_crank(lambda column: column[keep]), times=self.times[keep])

    def with_samples(self, change: Callable[[str, Samples], Samples]) -> Observed:
        """The table with changed samples.

        Args:
            change: makes the new samples from the quantity's name and the old ones.
        """
        points = {
            point: {quantity: change(quantity, samples) for quantity, samples in quantities.items()}
            for point, quantities in self.points.items()
        }
        return replace(self, points=points)

    def with_crank(self, change: Callable[[Array], Array]) -> Observed:
        """The table with changed columns of the crank, as far as it has them."""
        angle, rate, acceleration = (
            None if column is None else change(column) for column in (self.angle, self.rate, self.acceleration)
        )
        return replace(self, angle=angle, rate=rate, acceleration=acceleration)
