"""The main job: a scene in an engine, kinematic and dynamic mode, against the exact motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from conrod.comparison import QUANTITIES as COMPARED
from conrod.comparison import Comparison, ErrorSeries, compare, size_of
from conrod.convergence import observed_order
from conrod.engines import Engine
from conrod.engines.engine import KinematicResult, default_steps, run_of
from conrod.motion import Array
from conrod.outcome import joint_gaps
from conrod.scenes import CamFollower, Scene
from conrod.studies import printed_table
from conrod.studies.measurement import prediction_sizes
from conrod.studies.results import QUANTITIES, Curve, Mode, RefinementPoint, Result, Tolerance
from conrod.trajectory import Outcome, Track, Trajectory

JUDGED_PRESETS = ("tuned", "hardened")
# The model is right when its joints, solved by the engine itself, give the exact pose to rounding (guard 4).
KINEMATIC_POSITION, KINEMATIC_VELOCITY, KINEMATIC_DIGITS = 1e-12, 1e-9, 0.1
KINEMATIC_ANGLES = 360
# The preset whose model kinematic mode solves; what it cannot have, no other can.
KINEMATIC_PRESET = "tuned"

# Refinement path: everything a preset states in steps or periods follows the step; nothing else changes.
LINKAGE_PATH, CONTACT_PATH = (8, 4, 2, 1), (16, 8, 4, 2)

CURVE_SAMPLES, ERROR_SPANS = 361, 180


@dataclass(frozen=True)
class Plan:
    """What to run.

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


Job = Callable[[], Result]


def jobs(
    name: str, scene: Scene, engine: Engine[Any], presets: tuple[str, ...], plan: Plan
) -> Iterator[tuple[str, Job]]:
    """The jobs for one scene and engine with a label each: kinematic mode first, then each preset."""
    yield f"{name} {engine.name} kinematic", lambda: validate_kinematic(name, scene, engine)
    for preset in presets:
        yield f"{name} {engine.name} {preset}", _dynamic_job(name, scene, engine, preset, plan)


def _dynamic_job(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: Plan) -> Job:
    return lambda: validate_dynamic(name, scene, engine, preset, plan)


# -- kinematic mode --------------------------------------------------------------------------------------------------


def validate_kinematic(name: str, scene: Scene, engine: Engine[Any]) -> Result:
    """Prove the model: the engine's own joints against the exact poses, over one turn, or the driver's span."""
    refusal = engine.refusal(scene, engine.presets[KINEMATIC_PRESET](scene, default_steps(scene)))
    if refusal:
        outcome = Outcome.UNSUPPORTED
        return _result(name, scene, engine, "kinematic", outcome=outcome, reason=refusal, revolutions=1.0)
    angle = scene.kinematics.angles(KINEMATIC_ANGLES)
    solved = engine.solve_kinematics(scene, angle)
    exact = scene.motion(angle, scene.speed)
    errors: dict[str, dict[str, Mapping[str, float] | None]] = {}
    for point, (position, velocity) in solved.points.items():
        length, truth = scene.lengths[point], exact.point(point)
        errors[point] = dict.fromkeys(COMPARED)
        errors[point]["position"] = _size(np.linalg.norm(position - truth.position, axis=1) / length)
        if velocity is not None:
            off = np.linalg.norm(velocity - truth.velocity, axis=1)
            errors[point]["velocity"] = _size(off / (length * abs(scene.speed)))
    tolerance = _kinematic_tolerance(scene, solved)
    result = _result(name, scene, engine, "kinematic", errors=errors, tolerance=tolerance, revolutions=1.0)
    gaps = joint_gaps(scene.kinematics.mechanism, [solved.poses]).values()
    gap = max(float(np.abs(g).max()) for g in gaps) / max(scene.lengths.values())
    closure = {"position": gap, "velocity": None, "acceleration": None}
    return replace(result, closure=closure, passed=not result.exceeded())


def _kinematic_tolerance(scene: Scene, solved: KinematicResult) -> Tolerance:
    if solved.shape_error is None:
        reason = "rounding: the engine's own joint equations are solved to the last digit"
        # A machine many times larger than its travel loses digits of the travel, by the ratio of the two.
        kinematics = scene.kinematics
        cancelled = max(1.0, KINEMATIC_DIGITS * kinematics.size / kinematics.travel)
        return Tolerance(KINEMATIC_POSITION * cancelled, KINEMATIC_VELOCITY * cancelled, reason=reason)
    length = max(scene.lengths.values())
    return Tolerance(
        solved.shape_error / length, reason="the collision shape's own error: half a sagitta of its polygon"
    )


# -- dynamic mode ----------------------------------------------------------------------------------------------------


def validate_dynamic(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: Plan) -> Result:
    """Measure the engine: one run, its refinement path, and the verdict."""
    steps = plan.steps(scene)
    settings = engine.presets[preset](scene, steps)
    refusal = engine.refusal(scene, settings)
    if refusal:
        return _result(
            name,
            scene,
            engine,
            "dynamic",
            preset=preset,
            outcome=Outcome.UNSUPPORTED,
            reason=refusal,
            steps=steps,
            revolutions=plan.revolutions,
        )
    start, revolutions = run_of(scene, steps, plan.revolutions)
    trajectory = engine.run(scene, settings, revolutions, start)
    tolerance = _tolerance(scene, engine, preset, settings, plan)
    result = _result(
        name,
        scene,
        engine,
        "dynamic",
        preset=preset,
        settings=settings.as_dict(),
        steps=steps,
        revolutions=revolutions,
        outcome=trajectory.outcome,
        reason=trajectory.reason,
        tolerance=tolerance,
    )
    judged = bool(tolerance.judged())
    refinement = _refine(scene, engine, preset, plan, steps)
    result = replace(result, refinement=refinement, order=_orders(refinement))
    if trajectory.outcome is not Outcome.COMPLETED:
        return replace(result, passed=False if judged else None)
    result = _compared(result, scene, trajectory)
    passed = not result.exceeded() if judged else None
    if preset in JUDGED_PRESETS and printed_table.applies(scene):
        printed = printed_table.compare_with_print(scene, engine, preset)
        met = printed is not None and printed.engine_agrees == printed.exact_agrees
        result = replace(result, printed=printed)
        # Whoever gives tolerances is judged by these alone.
        passed = passed and (met or plan.tolerance is not None)
    return replace(result, passed=passed)


def _compared(result: Result, scene: Scene, trajectory: Trajectory) -> Result:
    comparison = compare(trajectory, scene)
    return replace(
        result,
        errors={p: {q: _size(getattr(e, q).error) for q in COMPARED} for p, e in comparison.points.items()},
        peak={p: {"velocity": k.velocity, "acceleration": k.acceleration} for p, k in comparison.peaks.items()},
        closure=vars(comparison.closure),
        phase={"max": comparison.phase_max, "final": comparison.phase_final},
        drive={"speed": comparison.drive_speed, "acceleration": comparison.drive_acceleration},
        prediction=prediction_sizes(scene, trajectory),
        lift_error=_lift_error(scene, trajectory),
        curves=_curves(trajectory, comparison),
    )


def _tolerance(scene: Scene, engine: Engine[Any], preset: str, settings: Any, plan: Plan) -> Tolerance:
    """What a run is judged by: what was asked for, else what the engine's own law allows a judged preset."""
    if plan.tolerance:
        return Tolerance(**plan.tolerance, reason="as asked for")
    if preset not in JUDGED_PRESETS:
        return Tolerance()
    law = engine.expected_error(scene, settings)
    if _has_contact(scene):
        return Tolerance(position=law.position, velocity_rms=law.velocity_rms, reason=law.law)
    return Tolerance(law.position, law.velocity, law.acceleration, reason=law.law)


def _refine(scene: Scene, engine: Engine[Any], preset: str, plan: Plan, steps: int) -> tuple[RefinementPoint, ...]:
    points = []
    path = refinement_path(scene, steps)
    # Of one pass all take the part that the longest steps have room for.
    start, revolutions = run_of(scene, min(path), plan.revolutions)
    for n in path:
        trajectory = engine.run(scene, engine.presets[preset](scene, n), revolutions, start)
        found = compare(trajectory, scene) if trajectory.outcome is Outcome.COMPLETED else None
        sizes = {q: found.worst(q) if found else None for q in QUANTITIES}
        points.append(RefinementPoint(n, trajectory.outcome.slug, **sizes))
    return tuple(points)


def _orders(refinement: tuple[RefinementPoint, ...]) -> dict[str, float | None]:
    orders: dict[str, float | None] = {}
    for quantity in QUANTITIES:
        pairs = [(p.steps_per_revolution, getattr(p, quantity)) for p in refinement]
        stable = [(n, e) for n, e in pairs if e is not None]
        orders[quantity] = observed_order([n for n, _ in stable], [e for _, e in stable]).claimed if stable else None
    return orders


def _lift_error(scene: Scene, trajectory: Trajectory) -> float | None:
    if not isinstance(scene, CamFollower):
        return None
    reached = trajectory.points["roller"].position.values[:, 1].max() - scene.base_radius - scene.roller_radius
    return abs(float(reached) / scene.full_lift - 1.0)


# -- results ---------------------------------------------------------------------------------------------------------


def _size(errors: Array) -> dict[str, float]:
    return vars(size_of(errors))


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


def _result(
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
    return Result(
        scene=name, parameters=scene.parameters, engine=engine.name, engine_version=engine.version, preset=preset,
        settings=settings, mode=mode, steps_per_revolution=steps, revolutions=revolutions, outcome=outcome.slug,
        reason=reason, errors=errors, peak=None, closure=None, phase=None, drive=None, order=None,
        tolerance=tolerance or Tolerance(), passed=None,
    )  # fmt: skip
