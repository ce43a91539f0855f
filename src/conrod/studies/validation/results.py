"""Results of a validation: plain, frozen data that the ledger keeps, and that report and command line read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Self

import numpy as np

from conrod.exact.motion import Array
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.frame.result import AS_ASKED, Result, SceneResults

Mode = Literal["kinematic", "dynamic", "motor"]


@dataclass(frozen=True)
class Tolerance:
    """Limits on errors, normalised as errors are; None where a quantity is not judged."""

    position: float | None = None
    velocity: float | None = None
    acceleration: float | None = None
    total: float | None = None
    velocity_rms: float | None = None
    phase: float | None = None  # [rad]
    reason: str = ""

    def judged(self) -> dict[str, float]:
        """The quantities that are judged."""
        names = (*QUANTITIES, "total", "velocity_rms", "phase")
        return {name: value for name in names if (value := getattr(self, name)) is not None}


@dataclass(frozen=True)
class Curve:
    """A measured quantity and its error against the crank angle, thinned for a figure.

    Attributes:
        angle: (K,) [rad] of the crank.
        values: (K, 2), SI.
        error_angle, error: (M,) the largest error in each of M equal spans of the crank angle.
    """

    angle: Array
    values: Array
    error_angle: Array
    error: Array


@dataclass(frozen=True)
class RefinementPoint:
    """One run of a refinement path: largest errors over all observed points, None unless completed."""

    steps_per_revolution: int
    outcome: str
    position: float | None
    velocity: float | None
    acceleration: float | None


@dataclass(frozen=True)
class PrintedCells:
    """Comparison of a run with a printed table, cell by cell.

    Attributes:
        cells: printed cells.
        exact_agrees: cells that the exact motion rounds to.
        engine_agrees: of these, cells that the engine meets within 0.55 of the last printed unit.
        worst: largest distance of the engine from a printed cell among these, in last printed units.
    """

    cells: int
    exact_agrees: int
    engine_agrees: int
    worst: float


@dataclass(frozen=True, kw_only=True)
class ValidationResult(Result):
    """Errors of a scene at constant crank speed, by point, quantity and measure.

    Attributes:
        peak: exact [m/s, m/s^2], by point.
        phase: [rad].
        prediction: by quantity the largest error predicted from the joints' gaps alone, and how far it is from the
            measured one at most.
        lift_error: of a cam, |largest lift reached - full lift| / full lift.
        curves: by point and quantity, for figures.
    """

    parameters: Mapping[str, float]
    settings: Mapping[str, Any] | None = None
    mode: Mode
    steps_per_revolution: int | None = None
    revolutions: float
    errors: Mapping[str, Mapping[str, Mapping[str, float] | None]] | None = None
    peak: Mapping[str, Mapping[str, float]] | None = None
    closure: Mapping[str, float | None] | None = None
    phase: Mapping[str, float] | None = None
    drive: Mapping[str, float] | None = None
    tolerance: Tolerance = field(default_factory=Tolerance)
    refinement: tuple[RefinementPoint, ...] = ()
    prediction: Mapping[str, Mapping[str, float]] | None = None
    printed: PrintedCells | None = None
    lift_error: float | None = None
    curves: Mapping[str, Mapping[str, Curve]] | None = None

    @property
    def limits(self) -> Mapping[str, float]:
        return self.tolerance.judged()

    def faults(self) -> list[str]:
        found = self.printed
        if found is None or found.engine_agrees == found.exact_agrees:
            return []
        return [f"the printed table, {found.engine_agrees} of {found.exact_agrees} cells met"]

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        sizes = [point[quantity] for point in (self.errors or {}).values()]
        found = [size[measure] for size in sizes if size is not None]
        # `max` would pass over what is no number.
        return float(np.max(found)) if found else None

    def judged_error(self, name: str) -> float | None:
        if name == "phase":
            return None if self.phase is None else self.phase["max"]
        return self.largest(name.removesuffix("_rms"), "rms" if name.endswith("_rms") else "max")

    def _held_to(self, asked: Mapping[str, float]) -> Self:
        return replace(self, tolerance=Tolerance(**asked, reason=AS_ASKED))


SceneStudy = SceneResults[ValidationResult]
