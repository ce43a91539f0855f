"""Results of a validation of free motion, as frozen data for report and command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from conrod.exact.motion import Array
from conrod.execution.result import JudgedResult, SceneResults

FREE_MOTION_QUANTITIES = ("position", "energy")
# Error of the exact motion's energy balance up to which the exact motion is fit to judge by.
MAX_EXACT_DRIFT = 1e-11


@dataclass(frozen=True)
class StepPoint:
    """A run of a refinement path: largest errors of position and energy, None unless completed."""

    step: float  # [s]
    outcome: str
    position: float | None
    energy: float | None


@dataclass(frozen=True)
class MotionCurves:
    """Largest errors of a run in equal spans of time, for a figure.

    Attributes:
        middles: middles (M,) of the spans [s].
        error, energy: largest position error over L and largest energy error in each span (M,).
    """

    middles: Array
    error: Array
    energy: Array


@dataclass(frozen=True)
class ExactSummary:
    """Summary of the exact motion that runs are compared with.

    Attributes:
        drift: error of its energy balance, over the largest energy that took part.
        continuation: in words, how the motion continues where branches cross; empty if none cross.
        turn: period of the fastest turn [s].
        unresolved: reason why no preset is judged unless a tolerance is given; empty if presets are judged.
    """

    drift: float
    continuation: str
    turn: float
    unresolved: str = ""


@dataclass(frozen=True, kw_only=True)
class MotionResult(JudgedResult):
    """Errors of a scene's free motion in an engine, against the exact motion at the same times.

    Attributes:
        exact: summary of the exact motion.
        step, seconds: step size and duration of the run [s].
        leaving: position error, over L, whose first instant is reported.
        tolerance: allowed errors by quantity; empty if the run is measured and not judged.
        errors: distance of each observed point from its exact position, over L: max, rms, final.
        energy: error of the energy, over the largest energy that took part: max, rms, final.
        leaves: time [s] at which the position error of a point first exceeds `leaving`; None if it never does.
        order: observed order of position and energy along the refinement path.
    """

    quantities: ClassVar[tuple[str, ...]] = FREE_MOTION_QUANTITIES

    preset: str
    motion: str
    exact: ExactSummary
    step: float
    seconds: float
    leaving: float
    tolerance: Mapping[str, float]
    errors: Mapping[str, Mapping[str, float]] | None = None
    energy: Mapping[str, float] | None = None
    leaves: float | None = None
    refinement: tuple[StepPoint, ...] = ()
    curves: MotionCurves | None = None

    @property
    def limits(self) -> Mapping[str, float]:
        return self.tolerance

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        if quantity == "position":
            # NumPy's max, since Python's would skip a NaN.
            found = [sizes[measure] for sizes in (self.errors or {}).values()]
            return float(np.max(found)) if found else None
        return None if self.energy is None else self.energy[measure]

    def judged_error(self, name: str) -> float | None:
        found = list(self.judged_points(name).values())
        return (float(np.max(found)) if found else None) if name == "position" else self.largest(name)

    def judged_points(self, name: str) -> Mapping[str, float]:
        """Judged position errors by observed point, weighed; empty for the energy."""
        sizes = self.errors or {} if name == "position" else {}
        return self.weigh(name, {point: size["max"] for point, size in sizes.items()})

    def _with_tolerances(self, tolerances: Mapping[str, float]) -> Self:
        return replace(self, tolerance=dict(tolerances))


@dataclass(frozen=True)
class MotionStudy(SceneResults[MotionResult]):
    """All results of a scene's free motion.

    Attributes:
        motion: one of `plan.MOTIONS`.
        left_out: names of the loads that can drive the crank and do not act.
    """

    motion: str
    left_out: tuple[str, ...]

    @property
    def exact(self) -> ExactSummary:
        """Summary of the exact motion, which is the same for all results."""
        return self.results[0].exact

    @property
    def passed(self) -> bool:
        """True if no judged result failed, and the exact motion is fit to judge by if any is."""
        judged = any(result.passed is not None for result in self.results)
        return super().passed and (self.exact.drift <= MAX_EXACT_DRIFT or not judged)
