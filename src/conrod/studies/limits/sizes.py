"""Max, rms and final value of series that come in pieces, as `conrod.studies.measurement` has them of whole ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from conrod.comparison import QUANTITIES, PointErrors
from conrod.motion import Array
from conrod.trajectory import BodyTracks

ORDERS = ("position", "velocity", "acceleration")


@dataclass
class RunningSize:
    """Of one series."""

    largest: float = 0.0
    squares: float = 0.0
    count: int = 0
    final: float = 0.0

    def add(self, values: Array) -> None:
        """Take in what follows."""
        if len(values) == 0:
            return
        self.largest = max(self.largest, float(values.max()))
        self.squares += float(values @ values)
        self.count += len(values)
        self.final = float(values[-1])

    def as_dict(self) -> dict[str, float]:
        """Max, rms and final value."""
        return {"max": self.largest, "rms": float(np.sqrt(self.squares / max(self.count, 1))), "final": self.final}


@dataclass
class RunningErrors:
    """Of all observed points, of the joints and of the drive."""

    points: dict[str, dict[str, RunningSize]] = field(default_factory=dict)
    closure: dict[str, RunningSize] = field(default_factory=lambda: {order: RunningSize() for order in ORDERS})
    phase: RunningSize = field(default_factory=RunningSize)
    speed: RunningSize = field(default_factory=RunningSize)
    acceleration: RunningSize = field(default_factory=RunningSize)

    def add(
        self, points: Mapping[str, PointErrors], closure: Mapping[str, Array], bodies: BodyTracks, speed: float
    ) -> None:
        """Take in a piece of a run at a crank speed [rad/s].

        Args:
            closure: largest gap of a joint, its rate and its acceleration at each sample, normalised.
        """
        for name, errors in points.items():
            sizes = self.points.setdefault(name, {quantity: RunningSize() for quantity in QUANTITIES})
            for quantity in QUANTITIES:
                sizes[quantity].add(getattr(errors, quantity).error)
        for order, gaps in closure.items():
            self.closure[order].add(gaps)
        position = bodies.position.instants
        self.phase.add(np.abs(position.angle - speed * position.times))
        self.speed.add(np.abs(bodies.velocity.instants.rate / speed - 1.0))
        self.acceleration.add(np.abs(bodies.acceleration.instants.acceleration) / speed**2)
