"""Results of a validation: plain, frozen data that the ledger keeps, and that report and command line read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Self

import numpy as np

from conrod.exact.motion import Array
from conrod.studies.frame.case import QUANTITIES
from conrod.studies.frame.result import AS_ASKED, Result, SceneResults, misfit_words

Mode = Literal["kinematic", "dynamic"]


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
    """The largest error (M,) in each of M equal spans of the crank angle [rad], for a figure."""

    error_angle: Array
    error: Array


@dataclass(frozen=True)
class PoseErrors:
    """Pose of every body less its exact pose at the crank angle reached, over the last turn or the pass.

    Attributes:
        angle: (K,) [rad] of the crank.
        values: (K, 3 n) [m, m, rad], stacked as in `Mechanism.bodies`.
    """

    angle: Array
    values: Array


@dataclass(frozen=True)
class RefinementPoint:
    """One run of a refinement path: largest errors over all observed points, None unless completed."""

    steps_per_revolution: int
    outcome: str
    position: float | None
    velocity: float | None
    acceleration: float | None


@dataclass(frozen=True)
class Noticed:
    """Verdict on one kind of defect, planted into the run that it is on.

    Attributes:
        defect: its name.
        unit: of its sizes; empty where it has none.
        where: what was changed; of several places the one where the verdict sees least.
        size: that was planted.
        by: quantities that were out of tolerance then, or how the run was said to have ended; empty if unnoticed.
        smallest: size from which on it is noticed, whatever its sign; None where none is.
        visible: False where no size changes anything that is judged.
    """

    defect: str
    unit: str
    where: str
    size: float
    by: tuple[str, ...]
    smallest: float | None
    visible: bool = True


@dataclass(frozen=True)
class Qualified:
    """Planted defects that a verdict on a run notices: that on its motion, and that on its forces."""

    motion: tuple[Noticed, ...]
    forces: tuple[Noticed, ...]

    @property
    def blind(self) -> bool:
        """True where no defect that has a size is noticed, however large it is."""
        return all(one.smallest is None for one in self.motion)


@dataclass(frozen=True, kw_only=True)
class ValidationResult(Result):
    """Errors of a scene at constant crank speed, by point, quantity and measure.

    Attributes:
        phase: [rad].
        prediction: by quantity the largest error predicted from the joints' gaps alone, and how far it is from the
            measured one at most.
        misfit: by quantity the difference of the two, what second order and rounding allow, and the crank angle [rad],
            where they fit least; and the same of the exact motion and its own joint equations.
        curves: by point and quantity, for figures.
        poses: how far the bodies are off, for a moving drawing.
        qualified: what the verdict notices of planted defects; None where that was not asked for.
    """

    parameters: Mapping[str, float]
    settings: Mapping[str, Any] | None = None
    mode: Mode
    steps_per_revolution: int | None = None
    revolutions: float
    errors: Mapping[str, Mapping[str, Mapping[str, float] | None]] | None = None
    closure: Mapping[str, float | None] | None = None
    phase: Mapping[str, float] | None = None
    drive: Mapping[str, float] | None = None
    tolerance: Tolerance = field(default_factory=Tolerance)
    refinement: tuple[RefinementPoint, ...] = ()
    prediction: Mapping[str, Mapping[str, float]] | None = None
    misfit: Mapping[str, Mapping[str, float]] | None = None
    curves: Mapping[str, Mapping[str, Curve]] | None = None
    poses: PoseErrors | None = None
    qualified: Qualified | None = None

    @property
    def limits(self) -> Mapping[str, float]:
        return self.tolerance.judged()

    @property
    def distrust(self) -> str:
        return misfit_words(self.misfit or {})

    def faults(self) -> list[str]:
        return ["no planted defect is noticed, of whatever size: no verdict"] if self.no_verdict else []

    @property
    def no_verdict(self) -> bool:
        """True where it is known that the verdict notices nothing."""
        return self.qualified is not None and self.qualified.blind

    def with_qualified(self, found: Qualified | None) -> Self:
        """The result with what its verdict notices, which has to be something."""
        result = replace(self, qualified=found)
        return replace(result, passed=False) if result.no_verdict else result

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        sizes = [point[quantity] for point in (self.errors or {}).values()]
        found = [size[measure] for size in sizes if size is not None]
        # `max` would pass over what is no number.
        return float(np.max(found)) if found else None

    @property
    def acceleration_error(self) -> float | None:
        return self.largest("acceleration")

    def judged_error(self, name: str) -> float | None:
        if name == "phase":
            return None if self.phase is None else self.phase["max"]
        return self.largest(name.removesuffix("_rms"), "rms" if name.endswith("_rms") else "max")

    def _with_tolerances(self, asked: Mapping[str, float]) -> Self:
        return replace(self, tolerance=Tolerance(**asked, reason=AS_ASKED))


SceneStudy = SceneResults[ValidationResult]


def drawable_runs(results: Sequence[ValidationResult]) -> list[ValidationResult]:
    """Return the dynamic runs with errors and curves to draw."""
    return [r for r in results if r.mode == "dynamic" and r.errors is not None and r.curves]
