"""The result of one case against the exact motion, as plain values that a ledger can keep."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from conrod.exact.motion import Array

QUANTITIES = ("position", "velocity", "acceleration")
MEASURES = ("max", "rms", "final")
Sizes = Mapping[str, float]


@dataclass(frozen=True)
class Measurement:
    """Outcome and, of a completed run alone, its errors; all normalised as docs/design.md says.

    Attributes:
        errors: point -> position, velocity, acceleration, total -> max, rms, final.
        closure: largest gap of a joint, its rate and its acceleration.
        phase: max and final [rad].
        drive: speed and acceleration.
        prediction: quantity -> largest error predicted from the joints alone, and its largest difference from the
            measured one.
        signed: point -> position, velocity, acceleration -> signed errors (K, 2) at K equally spaced crank angles of
            the last turn, the first at its start.
        extremes: what was watched of a run at its engine's limits, see `conrod.studies.limits.records`.
        beside: what a study's own task found besides; plain values that this study alone reads.
    """

    outcome: str
    reason: str = ""
    errors: Mapping[str, Mapping[str, Sizes]] | None = None
    closure: Sizes | None = None
    phase: Sizes | None = None
    drive: Sizes | None = None
    prediction: Mapping[str, Sizes] | None = None
    signed: Mapping[str, Mapping[str, list[list[float]]]] | None = None
    extremes: Mapping[str, Any] | None = None
    beside: Mapping[str, Any] | None = None

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a quantity over the observed points; None unless the run completed."""
        return None if self.errors is None else max(point[quantity][measure] for point in self.errors.values())

    def signed_of(self, point: str, quantity: str) -> Array:
        """Signed errors (K, 2) of a point; ValueError unless the run completed."""
        if self.signed is None:
            raise ValueError(f"a run that ended as {self.outcome!r} has no errors")
        return np.asarray(self.signed[point][quantity], dtype=float)
