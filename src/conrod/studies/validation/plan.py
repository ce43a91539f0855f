"""Dynamic mode: a scene in an engine, stepped through time, against the exact motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from conrod.engines import Engine
from conrod.engines.capabilities import expected_error
from conrod.engines.engine import default_steps, run_of
from conrod.engines.follower import follower_lift
from conrod.engines.running import whole_run
from conrod.runs.comparison import QUANTITIES as COMPARED
from conrod.runs.comparison import Comparison, ErrorSeries, PointErrors, compare, point_errors
from conrod.runs.convergence import claimed_order
from conrod.runs.trajectory import Outcome, Track, Trajectory
from conrod.scenes import CamFollower, Scene, ShearPress
from conrod.studies.frame.run import prediction_sizes
from conrod.studies.validation.results import QUANTITIES, Curve, RefinementPoint, Result, Tolerance, result_of, sizes_of

# Refinement path: everything a preset states in steps or periods follows the step; nothing else changes.
LINKAGE_PATH, CONTACT_PATH = (8, 4, 2, 1), (16, 8, 4, 2)

CURVE_SAMPLES, ERROR_SPANS = 361, 180


@dataclass(frozen=True)
class Plan:
    """Plan of the runs.

    Attributes:
        steps_per_revolution: None for the scene's own default.
        tolerance: overrides of the derived tolerances, by quantity.
    """

    steps_per_revolution: int | None = None
    revolutions: float = 2.0
    tolerance: Mapping[str, float] | None = None

    def steps(self, scene: Scene) -> int:
        """Steps per revolution for a scene."""
        return self.steps_per_revolution or default_steps(scene)


def _has_contact(scene: Scene) -> bool:
    return bool(scene.kinematics.mechanism.cam_contacts)


def refinement_path(scene: Scene, steps: int) -> tuple[int, ...]:
    """Steps per revolution at which the order is observed."""
    divisors = CONTACT_PATH if _has_contact(scene) else LINKAGE_PATH
    return tuple(dict.fromkeys(max(2, round(steps / d)) for d in divisors))


# -- dynamic mode ----------------------------------------------------------------------------------------------------


def validate_dynamic(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: Plan) -> Result:
    """Measure the engine: one run, its refinement path, and the verdict."""
    steps = plan.steps(scene)
    settings = engine.presets[preset](scene, steps)
    start, revolutions = run_of(scene, steps, plan.revolutions)
    empty = partial(result_of, name, scene, engine, "dynamic", preset=preset, steps=steps)
    refusal = engine.refusal(scene, settings)
    if refusal:
        return empty(outcome=Outcome.UNSUPPORTED, reason=refusal, revolutions=plan.revolutions)
    trajectory = whole_run(engine, scene, settings, revolutions, start)
    result = empty(
        settings=settings.as_dict(), revolutions=revolutions, outcome=trajectory.outcome, reason=trajectory.reason,
        tolerance=_tolerance(scene, engine, preset, settings),
    )  # fmt: skip
    comparison = compare(trajectory, scene) if trajectory.outcome is Outcome.COMPLETED else None
    finest = RefinementPoint(steps, trajectory.outcome.slug, **_worst(comparison.points if comparison else None))
    refinement = _refine(scene, engine, preset, plan, finest, (start, revolutions))
    result = replace(result, refinement=refinement, order=_orders(refinement))
    if comparison is None:
        return judged(result)
    result = judged(_compared(result, scene, trajectory, comparison))
    if not engine.presets[preset].judged or not isinstance(scene, ShearPress):
        return result
    from conrod.studies.validation import printed_table  # of one machine, and loaded for it alone

    if not printed_table.applies(scene):
        return result
    printed = printed_table.compare_with_print(scene, engine, preset)
    met = printed is not None and printed.engine_agrees == printed.exact_agrees
    return replace(result, printed=printed, passed=result.passed and met)


def judged(result: Result, asked: Mapping[str, float] | None = None) -> Result:
    """The result of a run with the verdict by its tolerances.

    Args:
        asked: tolerances by quantity that take the place of its own.
    """
    if result.outcome == Outcome.UNSUPPORTED.slug:
        return result
    if asked:
        result = replace(result, tolerance=Tolerance(**asked, reason="as asked for"))
    passed = result.outcome == Outcome.COMPLETED.slug and not result.exceeded()
    return replace(result, passed=passed if result.tolerance.judged() else None)


def _compared(result: Result, scene: Scene, trajectory: Trajectory, comparison: Comparison) -> Result:
    return replace(
        result,
        errors={p: {q: sizes_of(getattr(e, q).error) for q in COMPARED} for p, e in comparison.points.items()},
        peak={p: {"velocity": k.velocity, "acceleration": k.acceleration} for p, k in comparison.peaks.items()},
        closure=vars(comparison.closure),
        phase={"max": comparison.phase_max, "final": comparison.phase_final},
        drive={"speed": comparison.drive_speed, "acceleration": comparison.drive_acceleration},
        prediction=prediction_sizes(scene, trajectory),
        lift_error=_lift_error(scene, trajectory),
        curves=_curves(trajectory, comparison),
    )


def _tolerance(scene: Scene, engine: Engine[Any], preset: str, settings: Any) -> Tolerance:
    """Tolerance of a run: what the engine's own law allows a judged preset."""
    if not engine.presets[preset].judged:
        return Tolerance()
    law = expected_error(engine, scene, settings)
    if _has_contact(scene):
        return Tolerance(position=law.position, velocity_rms=law.velocity_rms, reason=law.law)
    return Tolerance(law.position, law.velocity, law.acceleration, reason=law.law)


def _refine(
    scene: Scene, engine: Engine[Any], preset: str, plan: Plan, finest: RefinementPoint, stretch: tuple[float, float]
) -> tuple[RefinementPoint, ...]:
    """The refinement path; `finest` is the run that is judged, over a stretch from a start angle."""
    points = []
    path = refinement_path(scene, finest.steps_per_revolution)
    # Of one pass all take the part that the longest steps have room for.
    start, revolutions = run_of(scene, min(path), plan.revolutions)
    for n in path:
        if (n, (start, revolutions)) == (finest.steps_per_revolution, stretch):
            points.append(finest)
            continue
        trajectory = whole_run(engine, scene, engine.presets[preset](scene, n), revolutions, start)
        completed = trajectory.outcome is Outcome.COMPLETED
        sizes = _worst(point_errors(trajectory, scene) if completed else None)
        points.append(RefinementPoint(n, trajectory.outcome.slug, **sizes))
    return tuple(points)


def _worst(errors: Mapping[str, PointErrors] | None) -> dict[str, float | None]:
    """Largest errors over all observed points; None for a run that did not complete."""
    if errors is None:
        return dict.fromkeys(QUANTITIES)
    return {q: max(float(getattr(e, q).size.max) for e in errors.values()) for q in QUANTITIES}


def _orders(refinement: tuple[RefinementPoint, ...]) -> dict[str, float | None]:
    return {q: claimed_order((p.steps_per_revolution, getattr(p, q)) for p in refinement) for q in QUANTITIES}


def _lift_error(scene: Scene, trajectory: Trajectory) -> float | None:
    if not isinstance(scene, CamFollower):
        lift = follower_lift(scene.kinematics) if _has_contact(scene) else None
        return lift.error(trajectory.points[lift.point].position.values) if lift else None
    reached = trajectory.points["roller"].position.values[:, 1].max() - scene.base_radius - scene.roller_radius
    return abs(float(reached) / scene.full_lift - 1.0)


# -- results ---------------------------------------------------------------------------------------------------------


def _curves(trajectory: Trajectory, comparison: Comparison) -> dict[str, dict[str, Curve]]:
    """The last full turn of each measured quantity, thinned, and its error over the whole run."""
    return {
        name: {q: _curve(getattr(tracks, q), getattr(comparison.points[name], q)) for q in QUANTITIES}
        for name, tracks in trajectory.points.items()
    }


def _curve(track: Track, errors: ErrorSeries) -> Curve:
    angle = track.instants.angle
    turn = np.flatnonzero(np.abs(angle[-1] - angle) <= 2.0 * np.pi + 1e-9)
    keep = turn[np.unique(np.linspace(0, len(turn) - 1, CURVE_SAMPLES).astype(int))]
    edges = np.linspace(0, len(angle), min(ERROR_SPANS, len(angle)) + 1).astype(int)
    spans = list(pairwise(edges))
    worst = np.array([errors.error[a:b].max() for a, b in spans])
    middle = np.array([errors.angle[a:b].mean() for a, b in spans])
    return Curve(angle[keep], track.values[keep], middle, worst)
