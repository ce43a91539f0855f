"""Findings on an engine's free motion: plain, frozen data that the report and the command line read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from conrod.exact.motion import Array
from conrod.scenes import Scene

QUANTITIES = ("position", "angle", "energy")
# What the exact motion's own balance of energy keeps.
EXACT_DRIFT = 1e-11


@dataclass(frozen=True)
class StepPoint:
    """One run of a refinement path: its largest errors, None unless it completed."""

    step: float  # [s]
    outcome: str
    position: float | None
    energy: float | None


@dataclass(frozen=True)
class MotionCurves:
    """A run over time, thinned for a figure.

    Attributes:
        times: (K,) [s]; angle: of the crank (K,) [rad].
        middles: (M,) [s], of equal spans of time; error, energy: the largest in each, normalised.
    """

    times: Array
    angle: Array
    middles: Array
    error: Array
    energy: Array


@dataclass(frozen=True)
class MotionResult:
    """One scene, engine and preset. Errors are None unless the run completed.

    Attributes:
        step: [s]; seconds: what it ran [s].
        errors: of each observed point, distance from its exact place at the same time over L: max, rms, final.
        angle: of the crank [rad], the same.
        energy: the engine's less the exact one at the same time, over the largest energy that took part, the same.
        leaves: when the position error of a point is first above `leaving` [s]; None where it stays below.
        order: of position and energy along the refinement path.
        cpu_seconds: of stepping alone [s], of this machine: not for files.
        tolerance: what it is judged by, by quantity; empty where it is only measured.
    """

    scene: str
    motion: str
    engine: str
    engine_version: str
    preset: str
    step: float
    seconds: float
    outcome: str
    reason: str
    leaving: float
    tolerance: Mapping[str, float]
    errors: Mapping[str, Mapping[str, float]] | None = None
    angle: Mapping[str, float] | None = None
    energy: Mapping[str, float] | None = None
    leaves: float | None = None
    refinement: tuple[StepPoint, ...] = ()
    order: Mapping[str, float | None] | None = None
    cpu_seconds: float | None = None
    curves: MotionCurves | None = None

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a quantity, over the observed points where it has several; None where there is none."""
        if self.errors is None or self.angle is None or self.energy is None:
            return None
        if quantity == "position":
            return max(sizes[measure] for sizes in self.errors.values())
        return {"angle": self.angle, "energy": self.energy}[quantity][measure]

    @property
    def exceeded(self) -> dict[str, tuple[float, float]]:
        """Judged quantities that are out of tolerance: what was found and what is allowed."""
        found = {name: self.largest(name) for name in self.tolerance}
        return {
            name: (value, self.tolerance[name])
            for name, value in found.items()
            if value is not None and not value <= self.tolerance[name]
        }

    @property
    def passed(self) -> bool | None:
        """The verdict; None where nothing is judged, or the engine cannot do this."""
        if not self.tolerance or self.outcome == "unsupported":
            return None
        return self.outcome == "completed" and not self.exceeded


@dataclass(frozen=True)
class ExactSummary:
    """Summary of the exact motion.

    Attributes:
        drift: error of its own balance of energy, over the largest energy that took part.
        continuation: where branches cross, in words; empty where none do.
        times: (T,) [s]; angle: of the crank (T,) [rad].
    """

    drift: float
    continuation: str
    times: Array
    angle: Array


@dataclass(frozen=True)
class MotionStudy:
    """All of one scene."""

    name: str
    scene: Scene
    motion: str
    left_out: tuple[str, ...]  # loads that drive the crank, and do not act
    exact: ExactSummary
    results: tuple[MotionResult, ...]

    @property
    def passed(self) -> bool:
        """True if nothing that is judged failed, and the exact motion is fit to judge by."""
        return self.exact.drift <= EXACT_DRIFT and all(result.passed is not False for result in self.results)
