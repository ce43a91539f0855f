"""Dynamic mode: a scene in an engine, stepped through time, against the exact motion."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from conrod.engines import Engine
from conrod.engines.capabilities import expected_error
from conrod.engines.engine import Preset, default_steps, run_extent
from conrod.engines.numerics import largest_derivatives, phase_bound
from conrod.engines.run import run_with_recorders
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.runs.comparison import Stretch
from conrod.runs.convergence import claimed_order
from conrod.runs.outcome import RunVerdict
from conrod.runs.run_errors import DrawnCurve, PointSizes, RunErrors
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.frame.case import QUANTITIES
from conrod.studies.frame.prediction import Prediction, merged_misfit, reference_misfit
from conrod.studies.frame.result import refinement_path, run_refinement_path
from conrod.studies.frame.run import MIN_PASS_STEPS
from conrod.studies.validation.results import Curve, PoseErrors, RefinementPoint, Tolerance, ValidationResult

POSES = 60  # of a turn, whose errors a moving drawing shows: 6 deg apart
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

    def determines(self, scene: Scene, preset: Preset[Any], refined: bool = True) -> dict[str, Any]:
        """All that it determines of the runs of a preset, along a refinement path or of one, as plain values."""
        steps = self.steps(scene)
        path = refinement_path(scene, steps) if refined else ()
        settings = [preset(scene, n).as_dict() for n in (steps, *path)]
        return {"settings": settings[0], "refined": settings[1:], "revolutions": self.revolutions, "start_angle": 0.0}

    def stretch(self, scene: Scene) -> tuple[float, float]:
        """Start angle [rad] and revolutions of the judged run.

        Raises:
            InvalidInput: a pass with room for fewer than `MIN_PASS_STEPS`.
        """
        steps = self.steps(scene)
        start, revolutions = run_extent(scene, steps, self.revolutions)
        taken = round(steps * revolutions)
        if scene.kinematics.mechanism.driver.span is not None and taken < MIN_PASS_STEPS:
            raise InvalidInput(
                f"{steps} steps per revolution are {taken} of the pass: at least {MIN_PASS_STEPS} are run"
            )
        return start, revolutions


def validate_dynamic(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: Plan) -> ValidationResult:
    """Measure the engine: one run, its refinement path, and the verdict."""
    result, settings, start = begun(name, scene, engine, preset, plan)
    if not result.completed:
        return result
    steps, revolutions = plan.steps(scene), result.revolutions
    errors, prediction, drawn = RunErrors(), Prediction(scene), Drawn()
    poses = DrawnPoses(scene, steps)
    ended = run_with_recorders(engine, scene, settings, revolutions, start, errors, prediction, drawn, poses)
    result = replace(result, outcome=ended.outcome.slug, reason=ended.reason)

    def point(n: int, turns: float, start: float) -> RefinementPoint:
        found = PointSizes()
        return _point(
            n, run_with_recorders(engine, scene, engine.presets[preset](scene, n), turns, start, found), found
        )

    finest = _point(steps, ended, errors)
    points = run_refinement_path(scene, steps, plan.revolutions, finest, point)
    order = {q: claimed_order((p.steps_per_revolution, getattr(p, q)) for p in points) for q in QUANTITIES}
    result = replace(result, refinement=points, order=order)
    if result.completed:
        misfit = merged_misfit(prediction.misfit, reference_misfit(scene))
        found = {"prediction": prediction.sizes, "misfit": misfit, **errors.as_dict()}
        result = replace(result, curves=drawn.curves, poses=poses.errors, **found)
    return result.with_verdict()


def begun(
    name: str, scene: Scene, engine: Engine[Any], preset: str, plan: Plan, start_angle: float = 0.0
) -> tuple[ValidationResult, Any, float]:
    """Facts known of a run before it is made: settings and tolerance, the settings, the start angle [rad].

    The result is `unsupported` where the engine refuses the machine.

    Args:
        start_angle: of a crank that turns [rad]; one pass has its own.
    """
    settings = engine.presets[preset](scene, plan.steps(scene))
    start, revolutions = plan.stretch(scene)
    start = start if scene.kinematics.mechanism.driver.span else start_angle
    empty = started(name, scene, engine, preset, plan)
    refusal = engine.refusal(scene, settings)
    if refusal:
        return replace(empty, outcome=Outcome.UNSUPPORTED.slug, reason=refusal), settings, start
    tolerance = _tolerance(scene, engine, preset, settings, revolutions, start)
    result = replace(empty, settings=settings.as_dict(), revolutions=revolutions, tolerance=tolerance)
    return result, settings, start


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
    # An input that makes one pass begins at its end, which its law knows.
    turning = start_angle and scene.kinematics.mechanism.driver.span is None
    law = expected_error(engine, scene, settings, **({"start_angle": start_angle} if turning else {}))
    if law.position is None:
        return Tolerance(reason=law.law)
    phase = phase_bound(settings.steps_per_revolution * revolutions, revolutions, start_angle, law.ripple)
    clock = {"phase": phase, "total": law.position + phase * largest_derivatives(scene.kinematics, 1)[1]}
    reason = "; ".join((law.law, RIPPLE_LAW if law.ripple else CLOCK_LAW))
    if scene.kinematics.mechanism.cam_contacts:
        return Tolerance(law.position, velocity_rms=law.velocity_rms, reason=reason, **clock)
    return Tolerance(law.position, law.velocity, law.acceleration, reason=reason, **clock)


def _point(steps: int, ended: RunVerdict, found: PointSizes) -> RefinementPoint:
    """Largest errors over all observed points; None for a run that did not complete."""
    completed = ended.outcome is Outcome.COMPLETED
    return RefinementPoint(steps, ended.outcome.slug, **{q: found.worst(q) if completed else None for q in QUANTITIES})


class Drawn:
    """Recorder of what a report draws."""

    def __init__(self) -> None:
        self._curves: defaultdict[str, defaultdict[str, DrawnCurve]] = defaultdict(lambda: defaultdict(DrawnCurve))

    def add(self, stretch: Stretch) -> None:
        for name, tracks in stretch.trajectory.points.items():
            for quantity in QUANTITIES:
                error = getattr(stretch.points[name], quantity).error
                self._curves[name][quantity].add(
                    getattr(tracks, quantity).instants.angle, error, stretch.samples_remaining
                )

    @property
    def curves(self) -> dict[str, dict[str, Curve]]:
        """The error of each measured quantity over the whole run."""
        return {name: {q: Curve(*drawn.arrays) for q, drawn in found.items()} for name, found in self._curves.items()}


class DrawnPoses:
    """Signed errors of the bodies' poses at the crank angle actually reached, at some samples of the last turn.

    Args:
        turn: steps of a turn.
    """

    def __init__(self, scene: Scene, turn: int) -> None:
        self._scene, self._turn, self._seen = scene, turn, 0
        self._angles: list[Array] = []
        self._errors: list[Array] = []

    def add(self, stretch: Stretch) -> None:
        states = stretch.bodies.position
        count = self._seen + len(states.poses) + stretch.samples_remaining
        first = max(0, count - 1 - self._turn)
        kept = first + np.unique(np.linspace(0, count - 1 - first, POSES + 1).astype(int)) - self._seen
        rows = kept[(kept >= 0) & (kept < len(states.poses))]
        self._seen += len(states.poses)
        angle = states.instants.angle[rows]
        error = states.poses[rows] - self._scene.kinematics.poses(angle) if len(rows) else states.poses[rows]
        # A body that has turned often is where one is that has not.
        error[:, 2::3] = np.remainder(error[:, 2::3] + math.pi, 2.0 * math.pi) - math.pi
        self._angles.append(angle)
        self._errors.append(error)

    @property
    def errors(self) -> PoseErrors:
        """All that was recorded."""
        return PoseErrors(np.concatenate(self._angles), np.concatenate(self._errors))
