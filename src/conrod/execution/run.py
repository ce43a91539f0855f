"""A run of a scene with some settings, compared with the exact motion."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, TypeVar

import numpy as np

from conrod.comparison.compare import ComparedPiece, ExactMotions
from conrod.comparison.run_errors import RunErrors
from conrod.comparison.trajectory import COMPARED_QUANTITIES, ArrayMapper, Outcome, Settings, Track, Trajectory
from conrod.engines import engine_named
from conrod.engines.engine import CUSTOM, Machine, run_extent
from conrod.engines.run import check_run, run_with_recorders
from conrod.exact.motion import QUANTITIES, Array
from conrod.execution.case import MIN_PASS_STEPS, Case, CaseResult, Sizes, contradictions
from conrod.execution.prediction import Prediction

REVOLUTIONS = 2.0
# Every number of steps in the grids is a multiple of this, so that signed errors are kept at angles that all share.
SIGNED_ANGLES = 20
# The errors are those of every sample. The prediction from the joints costs several times as much, and proves as much
# at this many samples a revolution.
PREDICTED_SAMPLES_PER_TURN = 2000


@dataclass(frozen=True)
class RunResult(CaseResult):
    """Outcome and, of a completed run alone, its errors; all normalised as docs/design.md says.

    Attributes:
        errors: point -> position, velocity, acceleration, total -> max, rms, final.
        closure: largest gap of a joint, its rate and its acceleration.
        phase: max and final [rad].
        drive: speed and acceleration.
        prediction: quantity -> largest error predicted from the joints alone, and its largest difference from the
            measured one.
        misfit: quantity -> difference of predicted and measured error, what is allowed, and the crank angle [rad], of
            quantities out of what is allowed alone; None where there is none, see `ReferenceGuard`.
        signed: point -> position, velocity, acceleration -> signed errors (K, 2) at K equally spaced crank angles of
            the last turn, the first at its start.
    """

    quantities: ClassVar[tuple[str, ...]] = COMPARED_QUANTITIES

    errors: Mapping[str, Mapping[str, Sizes]] | None = None
    closure: Sizes | None = None
    phase: Sizes | None = None
    drive: Sizes | None = None
    prediction: Mapping[str, Sizes] | None = None
    misfit: Mapping[str, Sizes] | None = None
    signed: Mapping[str, Mapping[str, list[list[float]]]] | None = None

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a quantity over the observed points; None unless the run completed."""
        # `max` would pass over what is no number.
        found = [point[quantity][measure] for point in (self.errors or {}).values()]
        return float(np.max(found)) if found else None

    def signed_errors(self, point: str, quantity: str) -> Array:
        """Signed errors (K, 2) of a point; ValueError unless the run completed."""
        if self.signed is None:
            raise ValueError(f"a run that ended as {self.outcome!r} has no errors")
        return np.asarray(self.signed[point][quantity], dtype=float)


@dataclass(frozen=True)
class RunCase(Case):
    """A run of a scene at constant crank speed.

    Attributes:
        revolutions: revolutions of the crank.
        start_angle: crank angle at the start [rad].
        signed_angles: equally spaced crank angles of the last turn at which signed errors are kept.
    """

    study: ClassVar[str] = "sweep"  # whose runs several studies share
    result_type: ClassVar[type[Any]] = RunResult

    settings: Settings
    revolutions: float = REVOLUTIONS
    start_angle: float = 0.0
    signed_angles: int = SIGNED_ANGLES

    def perform(self) -> RunResult:
        return measure(self)

    @property
    def labels(self) -> dict[str, str]:
        return {} if self.settings.preset == CUSTOM else {"label": self.settings.preset}

    @property
    def engine_name(self) -> str:
        return self.settings.engine

    @property
    def engine_version(self) -> str:
        """Version of the engine that runs the case."""
        return engine_named(self.settings.engine).version

    def key_fields(self) -> dict[str, Any]:
        settings = self.settings.as_dict()
        del settings["preset"]  # a name for people
        return {
            "engine": self.settings.engine,
            "engine_version": self.engine_version,
            "settings": settings,
            "revolutions": self.revolutions,
            "start_angle": self.start_angle,
            "signed_angles": self.signed_angles,
        }


AnyRun = TypeVar("AnyRun", bound=RunCase)


def clamp_to_span(case: AnyRun) -> AnyRun:
    """Limit a case to one pass if its input cannot turn fully; else return it unchanged."""
    if case.scene.kinematics.mechanism.driver.span is None:
        return case
    start, revolutions = run_extent(case.scene, case.settings.steps_per_revolution, case.revolutions)
    return replace(case, start_angle=start, revolutions=revolutions)


def run_refusal(case: RunCase, machine: Machine) -> str | None:
    """Return why the engine refuses the case, or that the pass is too short; None if it can be run.

    Args:
        case: with the angles that are run, see `clamp_to_span`.

    Raises:
        InvalidInput: as `conrod.run`.
    """
    steps, span = case.settings.steps_per_revolution, machine.kinematics.mechanism.driver.span
    refusal, taken = engine_named(case.settings.engine).refusal(machine, case.settings), round(steps * case.revolutions)
    if refusal is None and span is not None and taken < MIN_PASS_STEPS:
        refusal = (
            f"the pass is {taken} steps long at {steps} steps a revolution; "
            f"{MIN_PASS_STEPS} are needed to have accelerations"
        )
    if refusal is None:
        check_run(machine, case.settings, case.revolutions, case.start_angle)
    return refusal


def measure(case: RunCase, on_piece: Callable[[Trajectory], None] = lambda _: None) -> RunResult:
    """Run a case and compare it with the exact motion.

    Args:
        on_piece: called with each piece of the run, see `run_with_recorders`.

    Raises:
        InvalidInput: as `conrod.run`.
    """
    engine, case = engine_named(case.settings.engine), clamp_to_span(case)
    if (refusal := run_refusal(case, case.scene)) is not None:
        return RunResult(Outcome.UNSUPPORTED.slug, refusal)
    errors, signed = RunErrors(), SignedErrors(case)
    prediction = Prediction(case.scene, max(1, case.settings.steps_per_revolution // PREDICTED_SAMPLES_PER_TURN))
    span, recorders = (case.revolutions, case.start_angle), (errors, prediction, signed)
    ended = run_with_recorders(engine, case.scene, case.settings, *span, *recorders, on_piece=on_piece)
    if ended.outcome is not Outcome.COMPLETED:
        return RunResult(ended.outcome.slug, ended.reason)
    return RunResult(
        outcome=ended.outcome.slug,
        **errors.as_dict(),
        prediction=prediction.sizes,
        misfit=contradictions(prediction.misfit) or None,
        signed=signed.errors(),
    )


class SignedErrors:
    """Normalised signed errors at fixed crank angles of the last turn, or of the one pass.

    Where an engine has no sample at an angle (pymunk's velocities lie between), the error is interpolated: that
    costs a share of the error itself that falls with the square of the step.
    """

    def __init__(self, case: RunCase) -> None:
        self._scene, first = case.scene, case.start_angle / case.scene.speed
        share = np.arange(case.signed_angles) / case.signed_angles
        if case.scene.kinematics.mechanism.driver.span is None:
            self._times = first + case.scene.period * (case.revolutions - 1.0 + share)
        else:
            start, stop = case.scene.kinematics.span
            middles = (np.arange(case.signed_angles) + 0.5) / case.signed_angles
            self._times = np.sort((start + (stop - start) * middles) / case.scene.speed)
        self._near: defaultdict[tuple[str, str], list[Track]] = defaultdict(list)

    def add(self, piece: ComparedPiece) -> None:
        for name, tracks in piece.trajectory.points.items():
            for quantity in QUANTITIES:
                track: Track = getattr(tracks, quantity)
                # Samples on both sides of each time; those of a time between two pieces are ends of both.
                after, last = np.searchsorted(track.instants.times, self._times), len(track.values) - 1
                near = np.unique(np.clip([*(after - 1), *after, 0, last], 0, last))
                self._near[name, quantity].append(Track(track.instants[near], track.values[near]))

    def errors(self) -> dict[str, dict[str, list[list[float]]]]:
        """Signed errors (K, 2) by point and quantity, normalised."""
        found: defaultdict[str, dict[str, list[list[float]]]] = defaultdict(dict)
        for (name, quantity), near in self._near.items():
            track: Track = ArrayMapper(np.concatenate)(*near)
            norm = self._scene.lengths[name] * abs(self._scene.speed) ** QUANTITIES.index(quantity)
            errors = ExactMotions(self._scene).error(track, name, quantity) / norm
            at = [np.interp(self._times, track.instants.times, errors[:, axis]) for axis in (0, 1)]
            found[name][quantity] = np.column_stack(at).tolist()
        return dict(found)
