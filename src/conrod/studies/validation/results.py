"""Results of a validation: plain, frozen data that the ledger keeps, and that report and command line read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from conrod.engines import Engine
from conrod.exact.motion import Array
from conrod.runs.comparison import size_of
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene

Mode = Literal["kinematic", "dynamic"]
QUANTITIES = ("position", "velocity", "acceleration")


@dataclass(frozen=True)
class Tolerance:
    """Limits on errors, normalised as errors are; None where a quantity is not judged."""

    position: float | None = None
    velocity: float | None = None
    acceleration: float | None = None
    total: float | None = None
    velocity_rms: float | None = None
    reason: str = ""

    def judged(self) -> dict[str, float]:
        """The quantities that are judged."""
        names = (*QUANTITIES, "total", "velocity_rms")
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


@dataclass(frozen=True)
class Result:
    """One scene, engine, preset and mode. Errors are None unless the run completed."""

    scene: str
    parameters: Mapping[str, float]
    engine: str
    engine_version: str
    preset: str | None
    settings: Mapping[str, Any] | None
    mode: Mode
    steps_per_revolution: int | None
    revolutions: float
    outcome: str
    reason: str
    errors: Mapping[str, Mapping[str, Mapping[str, float] | None]] | None
    peak: Mapping[str, Mapping[str, float]] | None  # exact, m/s and m/s^2
    closure: Mapping[str, float | None] | None
    phase: Mapping[str, float] | None  # rad
    drive: Mapping[str, float] | None
    order: Mapping[str, float | None] | None
    tolerance: Tolerance
    passed: bool | None
    refinement: tuple[RefinementPoint, ...] = ()
    # By quantity: largest error predicted from the joints' gaps alone, and how far it is from the measured one at most.
    prediction: Mapping[str, Mapping[str, float]] | None = None
    printed: PrintedCells | None = None
    lift_error: float | None = None  # of a cam: |largest lift reached - full lift| / full lift
    curves: Mapping[str, Mapping[str, Curve]] | None = None  # point -> quantity, for figures

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a quantity over the observed points, None where there is none."""
        if self.errors is None:
            return None
        sizes = [point[quantity] for point in self.errors.values()]
        values = [size[measure] for size in sizes if size is not None]
        return max(values) if values else None

    def exceeded(self) -> dict[str, tuple[float | None, float]]:
        """Judged quantities that are out of tolerance: what was found (None: nothing) and what is allowed."""
        pairs = {name: (self._found(name), allowed) for name, allowed in self.tolerance.judged().items()}
        return {name: pair for name, pair in pairs.items() if pair[0] is None or not pair[0] <= pair[1]}

    def _found(self, tolerance: str) -> float | None:
        """The error that a tolerance of this name is compared with."""
        if tolerance.endswith("_rms"):
            return self.largest(tolerance.removesuffix("_rms"), "rms")
        return self.largest(tolerance)


@dataclass(frozen=True)
class SceneStudy:
    """All results of one scene."""

    name: str
    scene: Scene
    results: tuple[Result, ...]

    @property
    def passed(self) -> bool:
        """No judged result is out of tolerance."""
        return all(result.passed is not False for result in self.results)


def sizes_of(errors: Array) -> dict[str, float]:
    """Max, rms and final value of a non-negative series, by name."""
    return vars(size_of(errors))


def result_of(
    name: str,
    scene: Scene,
    engine: Engine[Any],
    mode: Mode,
    *,
    preset: str | None = None,
    settings: Mapping[str, Any] | None = None,
    steps: int | None = None,
    revolutions: float,
    outcome: Outcome = Outcome.COMPLETED,
    reason: str = "",
    errors: Mapping[str, Mapping[str, Mapping[str, float] | None]] | None = None,
    tolerance: Tolerance | None = None,
) -> Result:
    """A result of one scene, engine and mode; no figures but those given."""
    return Result(
        scene=name, parameters=scene.parameters, engine=engine.name, engine_version=engine.version, preset=preset,
        settings=settings, mode=mode, steps_per_revolution=steps, revolutions=revolutions, outcome=outcome.slug,
        reason=reason, errors=errors, peak=None, closure=None, phase=None, drive=None, order=None,
        tolerance=tolerance or Tolerance(), passed=None,
    )  # fmt: skip
