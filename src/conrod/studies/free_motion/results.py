"""Findings on an engine's free motion: plain, frozen data that the report and the command line read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from conrod.exact.motion import Array
from conrod.studies.frame.result import Result, SceneResults

QUANTITIES = ("position", "energy")
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
        middles: (M,) [s], of equal spans of time.
        error, energy: the largest in each, normalised.
    """

    middles: Array
    error: Array
    energy: Array


@dataclass(frozen=True)
class ExactSummary:
    """Summary of the exact motion.

    Attributes:
        drift: error of its own balance of energy, over the largest energy that took part.
        continuation: where branches cross, in words; empty where none do.
        turn: the fastest [s].
        unresolved: reason why nothing is judged unless a tolerance is given; empty where the step is short enough.
    """

    drift: float
    continuation: str
    turn: float
    unresolved: str = ""


@dataclass(frozen=True, kw_only=True)
class MotionResult(Result):
    """Errors of a motion in time.

    Attributes:
        exact: what it is held against.
        step: [s]; seconds: what it ran [s].
        leaving: the position error, of the length, whose first instant is reported.
        tolerance: what it is judged by, by quantity; empty where it is only measured.
        errors: of each observed point, distance from its exact place at the same time over L: max, rms, final.
        energy: the engine's less the exact one at the same time, over the largest energy that took part, the same.
        leaves: when the position error of a point is first above `leaving` [s]; None where it stays below.
        order: of position and energy along the refinement path.
    """

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
            # `max` would pass over what is no number.
            found = [sizes[measure] for sizes in (self.errors or {}).values()]
            return float(np.max(found)) if found else None
        return None if self.energy is None else self.energy[measure]

    def _with_tolerances(self, asked: Mapping[str, float]) -> Self:
        return replace(self, tolerance=dict(asked))


@dataclass(frozen=True)
class MotionStudy(SceneResults[MotionResult]):
    """All of one scene, and its exact motion.

    Attributes:
        left_out: loads that drive the crank, and do not act.
    """

    motion: str
    left_out: tuple[str, ...]

    @property
    def exact(self) -> ExactSummary:
        """The exact motion that all are held against."""
        return self.results[0].exact

    @property
    def passed(self) -> bool:
        """True if nothing that is judged failed, and the exact motion is fit to judge by where anything is."""
        judged = any(result.passed is not None for result in self.results)
        return super().passed and (self.exact.drift <= EXACT_DRIFT or not judged)
