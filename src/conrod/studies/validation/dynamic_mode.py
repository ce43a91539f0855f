"""Dynamic mode: a scene stepped through time by an engine, compared with the exact motion."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import replace
from typing import Any

import numpy as np

from conrod.comparison.compare import ComparedPiece
from conrod.comparison.convergence import claimed_order
from conrod.comparison.outcome import RunVerdict
from conrod.comparison.run_errors import DrawnCurve, LinkSizes, PointSizes, RunErrors
from conrod.comparison.trajectory import Outcome
from conrod.engines import Engine
from conrod.engines.capabilities import expected_error
from conrod.engines.numerics import largest_derivatives, phase_bound
from conrod.engines.run import run_with_recorders
from conrod.exact.link_rotations import ROTATIONS
from conrod.exact.motion import QUANTITIES, Array
from conrod.execution.prediction import Prediction, merged_misfit, reference_misfit
from conrod.execution.result import Plan, run_refinement_path
from conrod.scenes import Scene
from conrod.studies.validation.results import (
    Curve,
    PointSamples,
    PoseErrors,
    RefinementPoint,
    Tolerance,
    ValidationResult,
    empty_result,
)

DRAWN_POSES = 60  # of a revolution, in an animated drawing: 6 deg apart
MARKED_SAMPLES = 48  # of a revolution, in the figure of motion: 7.5 deg apart
CLOCK_ERROR_LAW = "phase: rounding, steps x eps x angle; total: position's and |dx/dθ| / L times the phase's"
RIPPLE_ERROR_LAW = CLOCK_ERROR_LAW.replace(
    ";", ", and the drive's ripple, energy exchanged / (flywheel ω²), of every turn;"
)


def validate_dynamic(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: Plan) -> ValidationResult:
    """Measure an engine in dynamic mode by a run and its refinement path, and judge the errors."""
    result, settings, start = prepare_run(name, scene, engine, preset, plan)
    if not result.completed:  # the engine refuses the machine
        return result
    steps, revolutions = plan.steps(scene), result.revolutions
    errors, prediction = RunErrors(), Prediction(scene)
    curves, poses, samples = CurveRecorder(), PoseErrorRecorder(scene, steps), SampleRecorder(scene.output, steps)
    links = LinkSizes()
    recorders = (errors, prediction, curves, poses, samples, links)
    ended = run_with_recorders(engine, scene, settings, revolutions, start, *recorders)
    result = replace(result, outcome=ended.outcome.slug, reason=ended.reason)

    def run_with_steps(n: int, turns: float, start: float) -> RefinementPoint:
        sizes = PointSizes()
        verdict = run_with_recorders(engine, scene, engine.presets[preset](scene, n), turns, start, sizes)
        return _refinement_point(n, verdict, sizes)

    finest = _refinement_point(steps, ended, errors)
    points = run_refinement_path(scene, steps, plan.revolutions, finest, run_with_steps)
    order = {q: claimed_order((p.steps_per_revolution, getattr(p, q)) for p in points) for q in QUANTITIES}
    result = replace(result, refinement=points, order=order)
    if result.completed:
        misfit = merged_misfit(prediction.misfit, reference_misfit(scene))
        found = {"prediction": prediction.sizes, "misfit": misfit, "links": links.errors, **errors.as_dict()}
        result = replace(result, curves=curves.curves, poses=poses.errors, samples=samples.samples, **found)
    return result.with_verdict()


def prepare_run(
    name: str, scene: Scene, engine: Engine[Any], preset: str, plan: Plan, start_angle: float = 0.0
) -> tuple[ValidationResult, Any, float]:
    """Derive a run's tolerance; return a result without errors, the settings, and the start angle [rad].

    Its outcome is `unsupported` if the engine refuses the machine, and `completed` until the run says otherwise.

    Args:
        start_angle: start angle of a crank that turns fully [rad]; a pass starts at the end of its span.
    """
    settings = engine.presets[preset](scene, plan.steps(scene))
    start, revolutions = plan.extent(scene)
    start = start if scene.kinematics.mechanism.driver.span else start_angle
    empty = empty_result(name, scene, engine, preset, plan)
    refusal = engine.refusal(scene, settings)
    if refusal:
        return replace(empty, outcome=Outcome.UNSUPPORTED.slug, reason=refusal), settings, start
    tolerance = _derive_tolerance(scene, engine, preset, settings, revolutions, start)
    result = replace(empty, settings=settings.as_dict(), revolutions=revolutions, tolerance=tolerance)
    return result, settings, start


def _derive_tolerance(
    scene: Scene, engine: Engine[Any], preset: str, settings: Any, revolutions: float, start_angle: float
) -> Tolerance:
    """Derive the tolerance of a run from the engine's error law; empty for an unjudged preset.

    Errors are taken at the crank angle reached, which hides a wrong clock. So two errors at the nominal time are judged
    as well: the phase, which is the error of the crank angle, and the total position error, with the limit
    total = position + phase max |dx/dtheta| / L.
    """
    if not engine.presets[preset].judged:
        return Tolerance()
    # A pass begins at the end of its span, which the error law knows.
    turning = start_angle and scene.kinematics.mechanism.driver.span is None
    law = expected_error(engine, scene, settings, **({"start_angle": start_angle} if turning else {}))
    if law.position is None:
        return Tolerance(reason=law.law)
    phase = phase_bound(settings.steps_per_revolution * revolutions, revolutions, start_angle, law.ripple)
    links = {quantity: getattr(law, quantity) for quantity in ROTATIONS}
    clock = {"phase": phase, **links, "total": law.position + phase * largest_derivatives(scene.kinematics, 1)[1]}
    reason = "; ".join((law.law, RIPPLE_ERROR_LAW if law.ripple else CLOCK_ERROR_LAW))
    if scene.kinematics.mechanism.cam_contacts:
        return Tolerance(law.position, velocity_rms=law.velocity_rms, reason=reason, **clock)
    return Tolerance(law.position, law.velocity, law.acceleration, reason=reason, **clock)


def _refinement_point(steps: int, ended: RunVerdict, found: PointSizes) -> RefinementPoint:
    """Return a run's point of the refinement path, without errors unless the run completed."""
    completed = ended.outcome is Outcome.COMPLETED
    return RefinementPoint(steps, ended.outcome.slug, **{q: found.worst(q) if completed else None for q in QUANTITIES})


class CurveRecorder:
    """Recorder of the error curves that a report draws, by observed point and quantity."""

    def __init__(self) -> None:
        self._curves: defaultdict[str, defaultdict[str, DrawnCurve]] = defaultdict(lambda: defaultdict(DrawnCurve))

    def add(self, piece: ComparedPiece) -> None:
        """Add a piece of the run."""
        for name, tracks in piece.trajectory.points.items():
            for quantity in QUANTITIES:
                error = getattr(piece.points[name], quantity).error
                self._curves[name][quantity].add(
                    getattr(tracks, quantity).instants.angle, error, piece.samples_remaining
                )

    @property
    def curves(self) -> dict[str, dict[str, Curve]]:
        """Error curves over the whole run, by observed point and quantity."""
        return {
            name: {q: Curve(*curve.angles_and_errors) for q, curve in by_q.items()}
            for name, by_q in self._curves.items()
        }


class PoseErrorRecorder:
    """Recorder of pose errors at the crank angle reached, at samples of the last revolution."""

    def __init__(self, scene: Scene, steps_per_revolution: int) -> None:
        self._scene, self._steps, self._seen = scene, steps_per_revolution, 0
        self._angles: list[Array] = []
        self._errors: list[Array] = []

    def add(self, piece: ComparedPiece) -> None:
        """Add a piece of the run."""
        states = piece.bodies.position
        count = self._seen + len(states.poses) + piece.samples_remaining
        kept = np.unique(_span_ends_of_last_turn(count, self._steps, DRAWN_POSES)) - self._seen
        rows = kept[(kept >= 0) & (kept < len(states.poses))]
        self._seen += len(states.poses)
        angle = states.instants.angle[rows]
        error = states.poses[rows] - self._scene.kinematics.poses(angle) if len(rows) else states.poses[rows]
        # Rotations count modulo 2 pi.
        error[:, 2::3] = np.remainder(error[:, 2::3] + math.pi, 2.0 * math.pi) - math.pi
        self._angles.append(angle)
        self._errors.append(error)

    @property
    def errors(self) -> PoseErrors:
        """Pose errors of all recorded samples."""
        return PoseErrors(np.concatenate(self._angles), np.concatenate(self._errors))


class SampleRecorder:
    """Recorder of a point's motion as the engine reports it, at samples of the last revolution."""

    def __init__(self, point: str, steps_per_revolution: int) -> None:
        self._point, self._steps = point, steps_per_revolution
        self._seen: defaultdict[str, int] = defaultdict(int)
        self._found: defaultdict[str, list[tuple[Array, ...]]] = defaultdict(list)

    def add(self, piece: ComparedPiece) -> None:
        """Add a piece of the run."""
        for quantity in QUANTITIES:
            track = getattr(piece.trajectory.points[self._point], quantity)
            # The quantities of a piece may have different numbers of samples.
            seen, length = self._seen[quantity], len(track.values)
            count = seen + length + piece.samples_remaining
            # The middles of equal spans: none lies on the edge of the figure.
            kept = np.unique(_span_ends_of_last_turn(count, self._steps, 2 * MARKED_SAMPLES)[1::2]) - seen
            rows = kept[(kept >= 0) & (kept < length)]
            self._seen[quantity] += length
            self._found[quantity].append((track.instants.angle[rows], *track.values[rows].T))

    @property
    def samples(self) -> dict[str, PointSamples]:
        """Motion of the point at all recorded samples, by quantity."""
        return {
            name: PointSamples(*map(np.concatenate, zip(*found, strict=True))) for name, found in self._found.items()
        }


def _span_ends_of_last_turn(count: int, steps_per_revolution: int, spans: int) -> Array:
    """Return the numbers of the samples at the ends of equal spans of a run's last revolution (`spans` + 1,).

    Args:
        count: samples of the whole run.
        spans: number of spans; ends coincide where a revolution has fewer steps."""
    first = max(0, count - 1 - steps_per_revolution)
    return np.asarray(first + np.linspace(0, count - 1 - first, spans + 1).astype(int))
