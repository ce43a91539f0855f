"""Results of a validation, as frozen data for ledger, report and command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np

from conrod.comparison.trajectory import COMPARED_QUANTITIES
from conrod.engines import Engine
from conrod.exact.link_rotations import ROTATIONS
from conrod.exact.motion import QUANTITIES, Array
from conrod.execution.result import AS_ASKED, JudgedResult, Plan, SceneResults, misfit_words
from conrod.scenes import Scene

Mode = Literal["kinematic", "dynamic"]


@dataclass(frozen=True)
class Tolerance:
    """Largest allowed errors by quantity, over L, omega L and omega^2 L; None if unjudged.

    Attributes:
        total: position error at the nominal time, over L.
        velocity_rms: velocity error, as rms over the run.
        phase: error of the crank angle at the nominal time [rad].
        rotation, angular_velocity, angular_acceleration: of the driven links, over R, omega R and omega^2 R.
        reason: the laws that the limits follow from, in words.
    """

    position: float | None = None
    velocity: float | None = None
    acceleration: float | None = None
    total: float | None = None
    velocity_rms: float | None = None
    phase: float | None = None
    rotation: float | None = None
    angular_velocity: float | None = None
    angular_acceleration: float | None = None
    reason: str = ""

    def limits(self) -> dict[str, float]:
        """Return the largest allowed errors of the judged quantities, by name."""
        names = (*QUANTITIES, "total", "velocity_rms", "phase", *ROTATIONS)
        return {name: value for name in names if (value := getattr(self, name)) is not None}


@dataclass(frozen=True)
class Curve:
    """Largest error (M,), and its crank angle (M,) [rad], in each of M equal spans of a run."""

    error_angle: Array
    error: Array


@dataclass(frozen=True)
class PoseErrors:
    """Poses of the bodies minus exact poses at the crank angle reached, in the last revolution.

    Attributes:
        angle: crank angles (K,) [rad].
        values: pose errors (K, 3 n) [m, m, rad], in the order of `Mechanism.bodies`.
    """

    angle: Array
    values: Array


@dataclass(frozen=True)
class PointSamples:
    """Samples of a quantity of the scene's output point, in the last revolution of a run.

    Attributes:
        angle: crank angles (K,) [rad] that the crank reached.
        x, y: components (K,) that the engine reports there, in SI.
    """

    angle: Array
    x: Array
    y: Array


@dataclass(frozen=True)
class RefinementPoint:
    """A run of a refinement path: largest errors of all observed points, None unless completed."""

    steps_per_revolution: int
    outcome: str
    position: float | None
    velocity: float | None
    acceleration: float | None


@dataclass(frozen=True)
class DefectVerdict:
    """Verdict on a kind of planted defect: whether it is noticed, and its least noticed size.

    Attributes:
        defect: name of the kind of defect.
        unit: unit of its sizes; empty if it has no size.
        where: place of the change; of several places the one where the verdict notices least.
        size: size that was planted.
        by: quantities out of tolerance with this size, or the outcome of the run; empty if the defect is unnoticed.
        smallest: smallest noticed size, of either sign; None if none is noticed.
        visible: False if no size changes a judged quantity.
    """

    defect: str
    unit: str
    where: str
    size: float
    by: tuple[str, ...]
    smallest: float | None
    visible: bool = True


@dataclass(frozen=True)
class Qualification:
    """Verdicts on planted defects, by the errors of motion and by the errors of forces."""

    motion: tuple[DefectVerdict, ...]
    forces: tuple[DefectVerdict, ...]

    @property
    def notices_nothing(self) -> bool:
        """True if no defect of the motion that has a size is noticed, even at its largest size."""
        return all(one.smallest is None for one in self.motion)


@dataclass(frozen=True, kw_only=True)
class ValidationResult(JudgedResult):
    """Errors of a scene in an engine at constant crank speed, by point, quantity and measure.

    Attributes:
        mode: kinematic, which proves the model, or dynamic, which measures the engine.
        phase: error of the crank angle against the clock [rad], by measure.
        links: errors of the driven links by link, quantity of `ROTATIONS` and measure, see `link_errors`; of rotations
            alone in kinematic mode, and None in reports of before.
        prediction: by quantity, the largest error predicted from constraint violations alone, and its largest distance
            from the measured error.
        misfit: by quantity, where prediction and measurement fit least: their difference, the difference that second
            order and rounding allow, and the crank angle [rad]; and the same for the exact motion in the joint
            equations.
        curves: errors along the run by point and quantity, for figures.
        poses: pose errors of the bodies, for an animated drawing.
        samples: motion of the scene's output point by quantity, for the figure of motion.
        qualified: verdicts on planted defects; None if none were planted.
    """

    quantities: ClassVar[tuple[str, ...]] = COMPARED_QUANTITIES

    parameters: Mapping[str, float]
    settings: Mapping[str, Any] | None = None
    mode: Mode
    steps_per_revolution: int | None = None
    revolutions: float
    errors: Mapping[str, Mapping[str, Mapping[str, float] | None]] | None = None
    closure: Mapping[str, float | None] | None = None
    phase: Mapping[str, float] | None = None
    links: Mapping[str, Mapping[str, Mapping[str, float]]] | None = None
    drive: Mapping[str, float] | None = None
    tolerance: Tolerance = field(default_factory=Tolerance)
    refinement: tuple[RefinementPoint, ...] = ()
    prediction: Mapping[str, Mapping[str, float]] | None = None
    misfit: Mapping[str, Mapping[str, float]] | None = None
    curves: Mapping[str, Mapping[str, Curve]] | None = None
    poses: PoseErrors | None = None
    samples: Mapping[str, PointSamples] | None = None
    qualified: Qualification | None = None

    @property
    def limits(self) -> Mapping[str, float]:
        """Allowed errors by quantity, from `tolerance`."""
        return self.tolerance.limits()

    @property
    def distrust(self) -> str:
        return misfit_words(self.misfit or {})

    def other_failures(self) -> list[str]:
        return ["no planted defect is noticed, of whatever size: no verdict"] if self.notices_no_defect else []

    @property
    def notices_no_defect(self) -> bool:
        """True if defects were planted, and the verdict notices none of any size."""
        return self.qualified is not None and self.qualified.notices_nothing

    def with_qualification(self, found: Qualification | None) -> Self:
        """Return the result with its qualification; it fails if the verdict notices no defect."""
        result = replace(self, qualified=found)
        return replace(result, passed=False) if result.notices_no_defect else result

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        sizes = [point[quantity] for point in (self.errors or {}).values()]
        found = [size[measure] for size in sizes if size is not None]
        # NumPy's max, since Python's would skip a NaN.
        return float(np.max(found)) if found else None

    def largest_rotation(self, quantity: str) -> tuple[str, float | None]:
        """Return the link whose rotation, angular velocity or acceleration is most in error, and that error."""
        found = self.weigh(
            quantity,
            {name: errors[quantity]["max"] for name, errors in (self.links or {}).items() if quantity in errors},
        )
        # NumPy's max, since Python's would skip a NaN.
        worst = list(found)[int(np.argmax(list(found.values())))] if found else ""
        return worst, found.get(worst)

    def out_of_tolerance(self) -> dict[str, tuple[float | None, float]]:
        """Error found and allowed error, by quantity out of tolerance; of links with the link's name."""
        pairs = super().out_of_tolerance()
        return {f"{q.replace('_', ' ')} of {link}" if (link := self._link(q)) else q: pairs[q] for q in pairs}

    def _link(self, name: str) -> str:
        """Name of the link whose rotation a tolerance of this name judges; empty for a point's tolerance."""
        return self.largest_rotation(name)[0] if name in ROTATIONS else ""

    @property
    def acceleration_error(self) -> float | None:
        return self.largest("acceleration")

    def judged_error(self, name: str) -> float | None:
        if name == "phase":
            return None if self.phase is None else self.phase["max"]
        if name in ROTATIONS:
            return self.largest_rotation(name)[1]
        found = list(self.judged_points(name).values())
        return float(np.max(found)) if found else None

    def judged_points(self, name: str) -> Mapping[str, float]:
        """Judged errors by observed point, or by link for rotations, weighed."""
        if name in ROTATIONS:
            links = (self.links or {}).items()
            return self.weigh(name, {link: errors[name]["max"] for link, errors in links if name in errors})
        quantity, measure = name.removesuffix("_rms"), "rms" if name.endswith("_rms") else "max"
        sizes = ((point, errors.get(quantity)) for point, errors in (self.errors or {}).items())
        return self.weigh(name, {point: size[measure] for point, size in sizes if size is not None})

    def _with_tolerances(self, tolerances: Mapping[str, float]) -> Self:
        return replace(self, tolerance=Tolerance(**tolerances, reason=AS_ASKED))


SceneStudy = SceneResults[ValidationResult]  # findings of `conrod validate` on one scene


def empty_result(name: str, scene: Scene, engine: Engine[Any], preset: str | None, plan: Plan) -> ValidationResult:
    """Return a result without measurements; of kinematic mode if the preset is None."""
    kinematic = preset is None
    return ValidationResult(
        scene=name, parameters=scene.parameters, engine=engine.name, engine_version=engine.version, preset=preset,
        mode="kinematic" if kinematic else "dynamic", steps_per_revolution=None if kinematic else plan.steps(scene),
        revolutions=1.0 if kinematic else plan.revolutions,
    )  # fmt: skip


def drawable_runs(results: Sequence[ValidationResult]) -> list[ValidationResult]:
    """Return the dynamic runs with errors and curves to draw."""
    return [r for r in results if r.mode == "dynamic" and r.errors is not None and r.curves]
