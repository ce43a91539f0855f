"""An engine's free motion against the exact one, along a refinement path of the step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from conrod.engines import Engine
from conrod.engines.capabilities import FreeMotionRuns, require_capability
from conrod.engines.tracks import FreeRun
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.runs.comparison import size_of
from conrod.runs.convergence import claimed_order
from conrod.runs.run_errors import equal_spans
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.frame.case import Study
from conrod.studies.frame.result import EngineCase, presets_study
from conrod.studies.free_motion.exact import ExactCourse, exact_course, places
from conrod.studies.free_motion.plan import FREE, LENGTH_ERROR, PATH, MotionPlan, drives
from conrod.studies.free_motion.results import (
    QUANTITIES,
    ExactSummary,
    MotionCurves,
    MotionResult,
    MotionStudy,
    StepPoint,
)


def run_motion(name: str, course: ExactCourse, engine: Engine[Any], preset: str, plan: MotionPlan) -> MotionResult:
    """Run a motion in an engine: errors with the step, and their decrease with shorter ones."""
    empty = _started(name, course, engine, preset, plan)
    try:
        runs = [_run(course, engine, preset, divisor) for divisor in PATH]
    except InvalidInput as error:
        # The start and the loads were found good with the exact motion: it is the engine that cannot have them.
        return replace(empty, outcome=Outcome.UNSUPPORTED.slug, reason=str(error))
    points = tuple(_point(course, course.grid.step / divisor, run) for divisor, run in zip(PATH, runs, strict=True))
    first = runs[0]
    found = replace(
        empty, outcome=first.outcome.slug, reason=first.reason, refinement=points, order=_orders(course, points)
    )
    return (_measured(found, course, first) if found.completed else found).with_verdict()


def _started(name: str, course: ExactCourse, engine: Engine[Any], preset: str, plan: MotionPlan) -> MotionResult:
    return MotionResult(
        scene=name, engine=engine.name, engine_version=engine.version, preset=preset, motion=plan.motion,
        exact=ExactSummary(course.motion.drift, course.motion.continuation, course.pace.revolution, course.unresolved),
        step=course.grid.step, seconds=float(course.motion.times[-1]), leaving=plan.leaving,
        tolerance={"position": LENGTH_ERROR} if engine.presets[preset].judged_free and not course.unresolved else {},
    )  # fmt: skip


def _run(course: ExactCourse, engine: Engine[Any], preset: str, divisor: int) -> FreeRun:
    grid, motion = course.grid.finer(divisor), course.motion
    return require_capability(engine, FreeMotionRuns).free_run(
        course.mechanism, preset, grid.step, grid.steps, motion.poses[0], motion.rates[0], course.pace, every=grid.every
    )


def _measured(empty: MotionResult, course: ExactCourse, run: FreeRun) -> MotionResult:
    errors = _errors(course, run)
    worst = np.max(list(errors.values()), axis=0)
    energy = _energy(course, run)
    late = np.flatnonzero(worst > empty.leaving)
    return replace(
        empty,
        errors={point: vars(size_of(error)) for point, error in errors.items()},
        energy=vars(size_of(energy)),
        leaves=float(run.times[late[0]]) if len(late) else None,
        curves=_curves(run.times, worst, energy),
    )


def _errors(course: ExactCourse, run: FreeRun) -> dict[str, Array]:
    """Distance of each observed point from its exact place at the same time, over L; (T,)."""
    found, exact = places(course.mechanism, run.poses), places(course.mechanism, course.motion.poses)
    return {name: np.linalg.norm(place - exact[name], axis=1) / course.lengths[name] for name, place in found.items()}


def _energy(course: ExactCourse, run: FreeRun) -> Array:
    return np.abs(run.energy - course.motion.energy) / course.motion.scale


def _point(course: ExactCourse, step: float, run: FreeRun) -> StepPoint:
    if run.outcome is not Outcome.COMPLETED:
        return StepPoint(step, run.outcome.slug, None, None)
    worst = float(np.max([error.max() for error in _errors(course, run).values()]))
    return StepPoint(step, run.outcome.slug, worst, float(_energy(course, run).max()))


def _orders(course: ExactCourse, points: tuple[StepPoint, ...]) -> dict[str, float | None]:
    steps = [course.grid.steps * divisor for divisor in PATH]
    return {
        quantity: claimed_order(zip(steps, (getattr(point, quantity) for point in points), strict=True))
        for quantity in ("position", "energy")
    }


def _curves(times: Array, error: Array, energy: Array) -> MotionCurves:
    # The start is exact, and has no place on a logarithmic axis.
    spans = equal_spans(len(times) - 1).add(times[1:], error[1:], energy[1:])
    return MotionCurves(*np.array([(at.mean(), off.max(), lost.max()) for at, off, lost in spans]).T)


@dataclass(frozen=True)
class MotionCase(EngineCase[MotionResult]):
    """A scene's motion without a prescribed crank in an engine with a preset, along its refinement path."""

    study: ClassVar[str] = "motion"
    kind: ClassVar[type[Any]] = MotionResult
    quantities: ClassVar[tuple[str, ...]] = QUANTITIES
    version: ClassVar[int] = 5  # a run on another branch has errors, as all have that complete

    plan: MotionPlan

    @property
    def effort(self) -> float:
        return len(self.scene.kinematics.mechanism.bodies)

    @property
    def course(self) -> ExactCourse:
        """The exact motion; raises InvalidInput as `exact_course`."""
        return exact_course(self.name, self.scene, replace(self.plan, tolerance=None))

    def empty_result(self) -> MotionResult:
        return _started(self.name, self.course, self.loaded_engine, str(self.preset), self.plan)

    def run(self) -> MotionResult:
        return run_motion(self.name, self.course, self.loaded_engine, str(self.preset), self.plan)

    def case_fields(self) -> dict[str, Any]:
        return {"scene": self.name}

    def key_fields(self) -> dict[str, Any]:
        return {"settings": {}} | {name: getattr(self.plan, name) for name in ("motion", "seconds", "step", "leaving")}


def motion_study(
    scenes: Mapping[str, Scene],
    engines: Sequence[Engine[Any]],
    presets: Mapping[str, tuple[str, ...]],
    plan: MotionPlan,
) -> Study[list[MotionStudy]]:
    """The study of some scenes; arguments as of `presets_study`."""
    found = yield from presets_study(MotionCase, scenes, engines, presets, plan)
    return [MotionStudy(s.name, s.scene, s.results, plan.motion, left_out(s.scene, plan)) for s in found]


def left_out(scene: Scene, plan: MotionPlan) -> tuple[str, ...]:
    """Names of the loads that drive the crank, and do not act."""
    mechanism = scene.kinematics.mechanism
    return tuple(load.name for load in mechanism.loads if plan.motion == FREE and drives(load, mechanism))
