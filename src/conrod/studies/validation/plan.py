"""Dynamic mode: a scene in an engine, stepped through time, against the exact motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from conrod.engines import Engine
from conrod.engines.capabilities import expected_error
from conrod.engines.engine import default_steps, run_of
from conrod.engines.follower import follower_lift
from conrod.engines.numerics import largest_derivatives, phase_bound
from conrod.engines.running import whole_run
from conrod.runs.comparison import (
    Comparison,
    ErrorSeries,
    PointErrors,
    compare,
    largest_in_spans,
    last_turn,
    point_errors,
)
from conrod.runs.convergence import claimed_order
from conrod.runs.trajectory import Outcome, Track, Trajectory
from conrod.scenes import CamFollower, Scene, ShearPress
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.frame.result import refine
from conrod.studies.frame.run import errors_of, prediction_sizes
from conrod.studies.validation.results import Curve, RefinementPoint, Tolerance, ValidationResult

CLOCK_LAW = "phase: rounding, steps x eps x angle; total: position's and |dx/dθ| / L times the phase's"
RIPPLE_LAW = CLOCK_LAW.replace(";", ", and the drive's ripple, energy exchanged / (flywheel ω²), of every turn;")


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


def validate_dynamic(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: Plan) -> ValidationResult:
    """Measure the engine: one run, its refinement path, and the verdict."""
    steps = plan.steps(scene)
    settings = engine.presets[preset](scene, steps)
    start, revolutions = run_of(scene, steps, plan.revolutions)
    empty = started(name, scene, engine, preset, plan)
    refusal = engine.refusal(scene, settings)
    if refusal:
        return replace(empty, outcome=Outcome.UNSUPPORTED.slug, reason=refusal)
    trajectory = whole_run(engine, scene, settings, revolutions, start)
    result = replace(
        empty, settings=settings.as_dict(), revolutions=revolutions, outcome=trajectory.outcome.slug,
        reason=trajectory.reason, tolerance=_tolerance(scene, engine, preset, settings, revolutions, start),
    )  # fmt: skip
    comparison = compare(trajectory, scene) if result.completed else None

    def point(n: int, turns: float, start: float) -> RefinementPoint:
        run = whole_run(engine, scene, engine.presets[preset](scene, n), turns, start)
        return _point(n, run, point_errors(run, scene) if run.outcome is Outcome.COMPLETED else None)

    finest = _point(steps, trajectory, comparison.points if comparison else None)
    points = refine(scene, steps, plan.revolutions, finest, point)
    order = {q: claimed_order((p.steps_per_revolution, getattr(p, q)) for p in points) for q in QUANTITIES}
    result = replace(result, refinement=points, order=order)
    if comparison is None:
        return result.judged()
    result = replace(
        result,
        **errors_of(comparison),
        peak={p: {"velocity": k.velocity, "acceleration": k.acceleration} for p, k in comparison.peaks.items()},
        prediction=prediction_sizes(scene, trajectory),
        lift_error=_lift_error(scene, trajectory),
        curves=_curves(trajectory, comparison),
    )
    if engine.presets[preset].judged and isinstance(scene, ShearPress):
        from conrod.studies.validation import printed_table  # of one machine, and loaded for it alone

        if printed_table.applies(scene):
            result = replace(result, printed=printed_table.compare_with_print(scene, engine, preset))
    return result.judged()


def started(name: str, scene: Scene, engine: Engine[Any], preset: str | None, plan: Plan) -> ValidationResult:
    """A result of which nothing is measured yet; in kinematic mode where there is no preset."""
    kinematic = preset is None
    return ValidationResult(
        scene=name, parameters=scene.parameters, engine=engine.name, engine_version=engine.version, preset=preset,
        mode="kinematic" if kinematic else "dynamic", steps_per_revolution=None if kinematic else plan.steps(scene),
        revolutions=1.0 if kinematic else plan.revolutions,
    )  # fmt: skip


def _tolerance(
    scene: Scene, engine: Engine[Any], preset: str, settings: Any, revolutions: float, start_angle: float
) -> Tolerance:
    """Tolerance of a run: what the engine's own law allows a judged preset.

    Errors are compared at the crank angle reached, which says nothing of a wrong clock. So the angle itself is judged,
    and the position at the nominal time: it may be off by the position's error and by what the phase moves the point.
    """
    if not engine.presets[preset].judged:
        return Tolerance()
    law = expected_error(engine, scene, settings)
    if law.position is None:
        return Tolerance(reason=law.law)
    phase = phase_bound(settings.steps_per_revolution * revolutions, revolutions, start_angle, law.ripple)
    clock = {"phase": phase, "total": law.position + phase * largest_derivatives(scene.kinematics, 1)[1]}
    reason = "; ".join((law.law, RIPPLE_LAW if law.ripple else CLOCK_LAW))
    if scene.kinematics.mechanism.cam_contacts:
        return Tolerance(law.position, velocity_rms=law.velocity_rms, reason=reason, **clock)
    return Tolerance(law.position, law.velocity, law.acceleration, reason=reason, **clock)


def _point(steps: int, run: Trajectory, errors: Mapping[str, PointErrors] | None) -> RefinementPoint:
    """Largest errors over all observed points; None for a run that did not complete."""
    worst = {q: max(float(getattr(e, q).size.max) for e in errors.values()) if errors else None for q in QUANTITIES}
    return RefinementPoint(steps, run.outcome.slug, **worst)


def _lift_error(scene: Scene, trajectory: Trajectory) -> float | None:
    if not isinstance(scene, CamFollower):
        lift = follower_lift(scene.kinematics) if scene.kinematics.mechanism.cam_contacts else None
        return lift.error(trajectory.points[lift.point].position.values) if lift else None
    reached = trajectory.points["roller"].position.values[:, 1].max() - scene.base_radius - scene.roller_radius
    return abs(float(reached) / scene.full_lift - 1.0)


def _curves(trajectory: Trajectory, comparison: Comparison) -> dict[str, dict[str, Curve]]:
    """The last full turn of each measured quantity, thinned, and its error over the whole run."""
    return {
        name: {q: _curve(getattr(tracks, q), getattr(comparison.points[name], q)) for q in QUANTITIES}
        for name, tracks in trajectory.points.items()
    }


def _curve(track: Track, errors: ErrorSeries) -> Curve:
    angle = track.instants.angle
    keep = last_turn(angle)
    return Curve(angle[keep], track.values[keep], *largest_in_spans(errors.angle, errors.error))
