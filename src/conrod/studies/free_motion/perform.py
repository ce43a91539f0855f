"""An engine's free motion against the exact one, along a refinement path of the step."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from conrod.convergence import observed_order
from conrod.engines import Engine
from conrod.engines.free import FreeRun
from conrod.errors import InvalidInput
from conrod.motion import Array
from conrod.studies.free_motion.exact import ExactCourse, crank_angle, places
from conrod.studies.free_motion.plan import PATH, MotionPlan
from conrod.studies.free_motion.results import MotionCurves, MotionResult, StepPoint
from conrod.studies.result_of import sizes_of
from conrod.trajectory import Outcome

CURVE_SAMPLES, SPANS = 721, 240
# A body turned by this much [rad] from the exact branch is on another: soft joints give far less.
OTHER_BRANCH = 0.3


def run_motion(name: str, course: ExactCourse, engine: Engine[Any], preset: str, plan: MotionPlan) -> MotionResult:
    """What an engine makes of a motion: errors with the step, and how they fall with shorter ones."""
    grid = course.grid
    empty = MotionResult(
        name, plan.motion, engine.name, engine.version, preset, grid.step, float(course.motion.times[-1]),
        Outcome.COMPLETED.slug, "", plan.leaving, plan.judged_by(preset),
    )  # fmt: skip
    try:
        runs = [_run(course, engine, preset, divisor) for divisor in PATH]
    except InvalidInput as error:
        # The start and the loads were found good with the exact motion: it is the engine that cannot have them.
        return replace(empty, outcome=Outcome.UNSUPPORTED.slug, reason=str(error))
    points = tuple(_point(course, grid.step / divisor, run) for divisor, run in zip(PATH, runs, strict=True))
    first = runs[0]
    found = replace(
        empty, outcome=first.outcome.slug, reason=first.reason, refinement=points, order=_orders(course, points),
        cpu_seconds=first.cpu_seconds,
    )  # fmt: skip
    return _measured(found, course, first) if first.outcome is Outcome.COMPLETED else found


def _run(course: ExactCourse, engine: Engine[Any], preset: str, divisor: int) -> FreeRun:
    grid, motion = course.grid.finer(divisor), course.motion
    run = engine.free_run(
        course.mechanism, preset, grid.step, grid.steps, motion.poses[0], motion.rates[0], every=grid.every
    )
    return _on_its_branch(course, run) if run.outcome is Outcome.COMPLETED else run


def _on_its_branch(course: ExactCourse, run: FreeRun) -> FreeRun:
    """The run, as flipped where it has gone to another branch than the exact motion at a crossing of branches."""
    if course.turn is None:
        return run
    other = course.turn.off(crank_angle(course.mechanism, run.poses), run.poses) > OTHER_BRANCH
    if not other.any():
        return run
    time = float(run.times[int(np.argmax(other))])
    return replace(run, outcome=Outcome.FLIPPED, reason=f"on the other branch from {time:.4g} s on")


def _measured(empty: MotionResult, course: ExactCourse, run: FreeRun) -> MotionResult:
    mechanism, motion = course.mechanism, course.motion
    errors = _errors(course, run)
    worst = np.max(list(errors.values()), axis=0)
    turned = crank_angle(mechanism, run.poses)
    energy = _energy(course, run)
    late = np.flatnonzero(worst > empty.leaving)
    return replace(
        empty,
        errors={point: sizes_of(error) for point, error in errors.items()},
        angle=sizes_of(np.abs(turned - crank_angle(mechanism, motion.poses))),
        energy=sizes_of(energy),
        leaves=float(run.times[late[0]]) if len(late) else None,
        curves=_curves(run.times, turned, worst, energy),
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
    worst = max(float(error.max()) for error in _errors(course, run).values())
    return StepPoint(step, run.outcome.slug, worst, float(_energy(course, run).max()))


def _orders(course: ExactCourse, points: tuple[StepPoint, ...]) -> dict[str, float | None]:
    orders: dict[str, float | None] = {}
    for quantity in ("position", "energy"):
        pairs = [
            (course.grid.steps * divisor, error)
            for divisor, point in zip(PATH, points, strict=True)
            if (error := getattr(point, quantity)) is not None
        ]
        orders[quantity] = observed_order([n for n, _ in pairs], [e for _, e in pairs]).claimed if pairs else None
    return orders


def _curves(times: Array, angle: Array, error: Array, energy: Array) -> MotionCurves:
    keep = np.unique(np.linspace(0, len(times) - 1, CURVE_SAMPLES).astype(int))
    # The start is exact, and has no place on a logarithmic axis.
    edges = np.linspace(1, len(times), min(SPANS, len(times) - 1) + 1).astype(int)
    spans = list(pairwise(edges))
    largest = (np.array([values[a:b].max() for a, b in spans]) for values in (error, energy))
    middles = np.array([times[a:b].mean() for a, b in spans])
    return MotionCurves(times[keep], angle[keep], middles, *largest)
