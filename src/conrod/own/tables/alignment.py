"""How a table's clock, crank and frame stand to the scene's, and the exact motion as the table would have it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array
from conrod.own.tables.samples import Observed, Samples


@dataclass(frozen=True)
class Alignment:
    """What lies between a table and the scene. The default is: nothing.

    Attributes:
        time: the table's clock minus the scene's [s].
        phase: crank angle at the scene's time 0 [rad].
        zero: crank angle where the table's own crank angle is 0 [rad].
        sense: +1, or -1 where the table's crank turns the other way.
        offset: place of the scene's origin in the table's frame [m].
        rotation: turn of the scene's axes in the table's frame [rad].
    """

    time: float = 0.0
    phase: float = 0.0
    zero: float = 0.0
    sense: int = 1
    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0

    def nominal(self, observed: Observed, speed: float) -> Array:
        """Crank angle at the nominal time (T,) [rad]."""
        return np.asarray(self.sense * speed * (observed.times - self.time) + self.phase)

    def reached(self, observed: Observed, speed: float) -> Array:
        """Crank angle by the table's own account (T,) [rad]; where it has none, the nominal one."""
        if observed.angle is None:
            return self.nominal(observed, speed)
        return np.asarray(self.sense * observed.angle + self.zero)

    def rate(self, observed: Observed, speed: float) -> Array | float:
        """Crank speed by the table's own account [rad/s]; the nominal one where it has none."""
        return self.sense * (speed if observed.rate is None else observed.rate)

    def acceleration(self, observed: Observed) -> Array | float:
        """Angular acceleration of the crank by the table's own account [rad/s^2]; 0 where it has none."""
        return 0.0 if observed.acceleration is None else self.sense * observed.acceleration

    def seen(self, vectors: Array, samples: Samples, placed: bool) -> Array:
        """Vectors of the scene (T, 2) as the table's frame has them, in the components (T, c) that it has.

        Args:
            placed: whether they are positions, which a frame's offset moves too.
        """
        c, s = math.cos(self.rotation), math.sin(self.rotation)
        x, y = vectors[:, 0], vectors[:, 1]
        components = (c * x - s * y, s * x + c * y)
        return np.column_stack([components[axis] + (self.offset[axis] if placed else 0.0) for axis in samples.axes])
