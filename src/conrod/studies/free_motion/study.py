"""`conrod free`: free motion in engines against the exact motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, ClassVar, Self

import numpy as np

from conrod.comparison.compare import size_of
from conrod.comparison.convergence import claimed_order
from conrod.comparison.run_errors import equal_spans
from conrod.comparison.trajectory import Outcome
from conrod.engines import Engine
from conrod.engines.capabilities import FreeMotionRuns, require_capability
from conrod.engines.tracks import FreeRun
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.execution.case import Study
from conrod.execution.result import JudgedCase, presets_study
from conrod.scenes import Scene
from conrod.studies.free_motion.exact import ExactCourse, exact_course, observed_positions
from conrod.studies.free_motion.plan import FREE, POSITION_TOLERANCE, MotionPlan, drives_crank
from conrod.studies.free_motion.results import (
    ExactSummary,
    MotionCurves,
    MotionResult,
    MotionStudy,
    StepPoint,
)


def run_motion(name: str, course: ExactCourse, engine: Engine[Any], preset: str, plan: MotionPlan) -> MotionResult:
    """Run a free motion in an engine, with steps of other sizes too, and judge its errors."""
    empty = _empty_result(name, course, engine, preset, plan)
    try:
        runs = {divisor: _run_engine(course, engine, preset, divisor) for divisor in course.refinement}
    except InvalidInput as error:
        # The exact motion has accepted start and loads, so it is the engine that does not support them.
        return replace(empty, outcome=Outcome.UNSUPPORTED.slug, reason=str(error))
    points = tuple(_refinement_point(course, divisor, run) for divisor, run in runs.items())
    judged, order = runs[Fraction(1)], _observed_orders(course, points)
    result = replace(empty, outcome=judged.outcome.slug, reason=judged.reason, refinement=points, order=order)
    return (_with_errors(result, course, judged) if result.completed else result).with_verdict()


def _empty_result(name: str, course: ExactCourse, engine: Engine[Any], preset: str, plan: MotionPlan) -> MotionResult:
    judged = engine.presets[preset].judged_free and not course.unresolved
    return MotionResult(
        scene=name, engine=engine.name, engine_version=engine.version, preset=preset, motion=plan.motion,
        exact=ExactSummary(course.motion.drift, course.motion.continuation, course.pace.revolution, course.unresolved),
        step=course.grid.step, seconds=float(course.motion.times[-1]), leaving=plan.leaving,
        tolerance={"position": POSITION_TOLERANCE} if judged else {},
    )  # fmt: skip


def _run_engine(course: ExactCourse, engine: Engine[Any], preset: str, divisor: Fraction) -> FreeRun:
    """Run a motion in an engine from the exact start, with the step size divided."""
    (grid, _), motion = course.grid.with_step_divided(divisor), course.motion
    return require_capability(engine, FreeMotionRuns).free_run(
        course.mechanism,
        preset,
        grid.step,
        grid.steps,
        motion.poses[0],
        motion.rates[0],
        course.pace,
        every=grid.stride,
    )


def _with_errors(empty: MotionResult, course: ExactCourse, run: FreeRun) -> MotionResult:
    """Return the result with the errors of a completed run."""
    errors = _position_errors(course, run)
    worst = np.max(list(errors.values()), axis=0)
    energy = _energy_errors(course, run)
    late = np.flatnonzero(worst > empty.leaving)
    return replace(
        empty,
        errors={point: vars(size_of(error)) for point, error in errors.items()},
        energy=vars(size_of(energy)),
        leaves=float(run.times[late[0]]) if len(late) else None,
        curves=_thinned_curves(run.times, worst, energy),
    )


def _position_errors(course: ExactCourse, run: FreeRun, instants: slice = slice(None)) -> dict[str, Array]:
    """Return the distance (T,) of each observed point from its exact position at some instants, over L."""
    found = observed_positions(course.mechanism, run.poses)
    exact = observed_positions(course.mechanism, course.motion.poses[instants])
    return {name: np.linalg.norm(at - exact[name], axis=1) / course.lengths[name] for name, at in found.items()}


def _energy_errors(course: ExactCourse, run: FreeRun, instants: slice = slice(None)) -> Array:
    """Return the errors (T,) of the energy at some instants, over the largest energy in the exact motion."""
    return np.abs(run.energy - course.motion.energy[instants]) / course.motion.scale


def _refinement_point(course: ExactCourse, divisor: Fraction, run: FreeRun) -> StepPoint:
    """Return a run's point of the refinement path, without errors unless the run completed."""
    grid, every = course.grid.with_step_divided(divisor)
    if run.outcome is not Outcome.COMPLETED:
        return StepPoint(grid.step, run.outcome.slug, None, None)
    instants = slice(0, every * grid.count + 1, every)
    worst = float(np.max([error.max() for error in _position_errors(course, run, instants).values()]))
    return StepPoint(grid.step, run.outcome.slug, worst, float(_energy_errors(course, run, instants).max()))


def _observed_orders(course: ExactCourse, points: tuple[StepPoint, ...]) -> dict[str, float | None]:
    """Return the observed orders of position and energy; None where errors do not fall evenly."""
    steps = [int(divisor / course.refinement[0]) for divisor in course.refinement]
    return {
        quantity: claimed_order(zip(steps, (getattr(point, quantity) for point in points), strict=True))
        for quantity in ("position", "energy")
    }


def _thinned_curves(times: Array, error: Array, energy: Array) -> MotionCurves:
    """Return the largest errors in equal spans of time, from errors (T,) at times (T,) [s]."""
    # The start is exact, and has no place on a logarithmic axis.
    spans = equal_spans(len(times) - 1).add(times[1:], error[1:], energy[1:])
    return MotionCurves(*np.array([(at.mean(), off.max(), lost.max()) for at, off, lost in spans]).T)


@dataclass(frozen=True)
class MotionCase(JudgedCase[MotionResult]):
    """Free motion of a scene in an engine with a preset, along its refinement path."""

    study: ClassVar[str] = "motion"
    result_type: ClassVar[type[Any]] = MotionResult

    plan: MotionPlan
    known_course: ExactCourse | None = field(default=None, repr=False, compare=False)

    @property
    def effort(self) -> float:
        """Number of bodies, as costs grow with it."""
        return len(self.scene.kinematics.mechanism.bodies)

    @property
    def course(self) -> ExactCourse:
        """Exact motion of the scene; raises InvalidInput as `exact_course`."""
        return self.known_course or exact_course(*self.shared_arguments)

    @property
    def shared_arguments(self) -> tuple[str, Scene, MotionPlan]:
        return self.name, self.scene, replace(self.plan, tolerance=None)

    shared_call = staticmethod(exact_course)

    def with_shared(self, result: ExactCourse) -> Self:
        return replace(self, known_course=result)

    def empty_result(self) -> MotionResult:
        return _empty_result(self.name, self.course, self.loaded_engine, str(self.preset), self.plan)

    def perform(self) -> MotionResult:
        return run_motion(self.name, self.course, self.loaded_engine, str(self.preset), self.plan)

    def case_fields(self) -> dict[str, Any]:
        """The scene's name alone: a result of free motion has no parameters."""
        return {"scene": self.name}

    def run_fields(self) -> dict[str, Any]:
        """Plain values of the key: the motion, its duration and step, and the error that ends it."""
        fields = {name: getattr(self.plan, name) for name in ("motion", "seconds", "step", "leaving")}
        rounded = {} if self.plan.step_factor == 1.0 else {"step_factor": self.plan.step_factor}
        refined = {"refinement": "coarser where it can be"} if self.plan.step is None else {}
        return {"settings": {}} | fields | rounded | refined


def motion_study(
    scenes: Mapping[str, Scene],
    engines: Sequence[Engine[Any]],
    presets: Mapping[str, tuple[str, ...]],
    plan: MotionPlan,
) -> Study[list[MotionStudy]]:
    """Study of the free motion of scenes; arguments as for `presets_study`."""
    found = yield from presets_study(MotionCase, scenes, engines, presets, plan)
    return [MotionStudy(s.name, s.scene, s.results, plan.motion, inactive_loads(s.scene, plan)) for s in found]


def inactive_loads(scene: Scene, plan: MotionPlan) -> tuple[str, ...]:
    """Return the names of the loads that can drive the crank, and that the plan leaves out."""
    mechanism = scene.kinematics.mechanism
    return tuple(load.name for load in mechanism.loads if plan.motion == FREE and drives_crank(load, mechanism))
