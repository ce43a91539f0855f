"""A run of a scene with some settings, compared with the exact motion."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from conrod.comparison.compare import ExactMotions, Stretch
from conrod.comparison.run_errors import RunErrors
from conrod.comparison.trajectory import ArrayMapper, Outcome, Settings, Track, Trajectory
from conrod.engines import engine_named
from conrod.engines.engine import CUSTOM, Machine, run_extent
from conrod.engines.run import check_run, run_with_recorders
from conrod.exact.motion import QUANTITIES
from conrod.execution.case import RESULT_VERSION, Case, Measurement, contradictions
from conrod.execution.prediction import Prediction

REVOLUTIONS = 2.0
# Every number of steps in the grids is a multiple of this, so that signed errors are kept at angles that all share.
SIGNED_ANGLES = 20
MIN_PASS_STEPS = 3  # fewer steps have no acceleration that is a difference of velocities
# The errors are those of every sample. The prediction from the joints costs several times as much, and proves as much
# at this many samples a revolution.
PREDICTED_SAMPLES_PER_TURN = 2000


@dataclass(frozen=True)
class RunCase(Case):
    """A run of a scene at constant crank speed.

    Attributes:
        revolutions: revolutions of the crank.
        start_angle: crank angle at the start [rad].
        signed_angles: equally spaced crank angles of the last turn at which signed errors are kept.
    """

    settings: Settings
    revolutions: float = REVOLUTIONS
    start_angle: float = 0.0
    signed_angles: int = SIGNED_ANGLES

    def perform(self) -> Measurement:
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

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        # Fields that settings gained later are not in it where they are as they always were: keys stay what they were.
        settings = self.settings.as_dict()
        del settings["preset"]
        return {
            "result_version": RESULT_VERSION,
            "scene": self.scene.kind,
            "parameters": parameters,
            "engine": self.settings.engine,
            "engine_version": self.engine_version,
            "settings": settings,
            "revolutions": self.revolutions,
            "start_angle": self.start_angle,
            "signed_angles": self.signed_angles,
        }


AnyRun = TypeVar("AnyRun", bound=RunCase)


def clamp_to_span(case: AnyRun) -> AnyRun:
    """Return the case with the angles that are run: one pass if the input cannot turn fully."""
    if case.scene.kinematics.mechanism.driver.span is None:
        return case
    start, revolutions = run_extent(case.scene, case.settings.steps_per_revolution, case.revolutions)
    return replace(case, start_angle=start, revolutions=revolutions)


def unsupported_measurement(case: RunCase, machine: Machine) -> Measurement | None:
    """Return an "unsupported" measurement if the engine refuses the case or the pass is too short, else None.

    Args:
        case: with the stretch that is run, see `clamp_to_span`.

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
    if refusal is not None:
        return Measurement(Outcome.UNSUPPORTED.slug, refusal)
    check_run(machine, case.settings, case.revolutions, case.start_angle)
    return None


def measure(case: RunCase, on_piece: Callable[[Trajectory], None] = lambda _: None) -> Measurement:
    """Run a case and compare it with the exact motion.

    Args:
        on_piece: called with each piece of the run, see `run_with_recorders`.

    Raises:
        InvalidInput: as `conrod.run`.
    """
    engine, case = engine_named(case.settings.engine), clamp_to_span(case)
    if (unsupported := unsupported_measurement(case, case.scene)) is not None:
        return unsupported
    errors, signed = RunErrors(), SignedErrors(case)
    prediction = Prediction(case.scene, max(1, case.settings.steps_per_revolution // PREDICTED_SAMPLES_PER_TURN))
    span, recorders = (case.revolutions, case.start_angle), (errors, prediction, signed)
    ended = run_with_recorders(engine, case.scene, case.settings, *span, *recorders, on_piece=on_piece)
    if ended.outcome is not Outcome.COMPLETED:
        return Measurement(ended.outcome.slug, ended.reason)
    return Measurement(
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

    def add(self, stretch: Stretch) -> None:
        for name, tracks in stretch.trajectory.points.items():
            for quantity in QUANTITIES:
                track: Track = getattr(tracks, quantity)
                # Samples on both sides of each time; those of a time between two stretches are ends of both.
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
