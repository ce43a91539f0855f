"""Run at an engine's limits: made and compared in pieces, with records of how it fails."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from conrod.comparison.compare import ComparedPiece
from conrod.comparison.fingerprint import Fingerprint, recorded_series
from conrod.comparison.outcome import RunVerdict, joint_gaps
from conrod.comparison.run_errors import RunErrors
from conrod.comparison.trajectory import Outcome, Piece, concatenate_pieces
from conrod.engines import engine_named
from conrod.engines.engine import PIECE_STEPS
from conrod.errors import InvalidInput
from conrod.execution.case import MIN_PASS_STEPS, contradictions
from conrod.execution.prediction import Prediction
from conrod.execution.run import PREDICTED_SAMPLES_PER_TURN, clamp_to_span, run_refusal
from conrod.studies.limits.recorders import DEPTH_REVOLUTIONS, ExactTorque, FlightRecorder
from conrod.studies.limits.records import LimitResult

if TYPE_CHECKING:
    from conrod.studies.limits.case import LimitCase

# Most pieces of a run, so that an early failure ends it early, and fewest steps of a piece.
MAX_PIECES, MIN_PIECE_STEPS = 40, 25
# Revolutions that a run continues after a failure, because the machine may still diverge.
REVOLUTIONS_AFTER_FAILURE = 2.0
FINAL_OUTCOMES = {Outcome.RESET, Outcome.DIVERGED, Outcome.EXPLODED}


def stream_run(case: LimitCase) -> LimitResult:
    """Run a case in pieces, up to its end or until it diverges or resets.

    Errors are measured until the run fails. A run that failed otherwise, as by an open joint, goes on for two
    revolutions, since it may still diverge; its outcome is that of all its pieces. A follower that left its cam may
    land again, so such a run goes on to its end.

    Raises:
        InvalidInput: as `conrod.run`; or the run is too short to have accelerations.
    """
    engine, case = engine_named(case.settings.engine), clamp_to_span(case)
    if (refusal := run_refusal(case, case.machine)) is not None:
        return LimitResult(Outcome.UNSUPPORTED.slug, refusal)
    length, statistics, last = piece_length(case), RunStatistics(case), math.inf
    for piece in engine.run(case.machine, case.settings, case.revolutions, case.start_angle, length):
        statistics.add(piece)
        verdict = RunVerdict(piece.trajectory.outcome, piece.trajectory.reason)
        if verdict.outcome is Outcome.COMPLETED:
            statistics.compare(piece)
        elif verdict.outcome is not Outcome.LOST_CONTACT:
            last = min(last, piece.first_step + REVOLUTIONS_AFTER_FAILURE * case.settings.steps_per_revolution)
        if verdict.outcome in FINAL_OUTCOMES or piece.first_step >= last:
            break
    return statistics.result(verdict)


def piece_length(case: LimitCase) -> int:
    """Return the number of steps in each piece of a case's run.

    Raises:
        InvalidInput: the run is too short to have accelerations.
    """
    turn = case.settings.steps_per_revolution
    steps = round(turn * case.revolutions)
    if steps < MIN_PASS_STEPS:
        raise InvalidInput(
            f"revolutions = {case.revolutions:g} at {turn} steps each are {steps} steps; "
            f"a run needs {MIN_PASS_STEPS} to have accelerations"
        )
    return min(max(steps // MAX_PIECES, MIN_PIECE_STEPS), PIECE_STEPS)


MIN_COMPARED_SAMPLES = 2048  # short pieces wait until they have this many samples together


class RunStatistics:
    """Recorder of errors, torque, flights and fingerprint of a run that arrives in pieces."""

    def __init__(self, case: LimitCase) -> None:
        machine, settings, given = case.machine, case.settings, case.settings.as_dict()
        kinematics, steps = machine.kinematics, settings.steps_per_revolution
        contacts = kinematics.mechanism.cam_contacts
        self._machine = machine
        self._samples, self._finite = 0, True
        self._warnings: dict[str, int] = {}
        self._fingerprint = Fingerprint()
        self._errors, self._steps = RunErrors(), round(steps * case.revolutions)
        self._prediction = Prediction(machine, max(1, steps // PREDICTED_SAMPLES_PER_TURN))
        self._flights = {
            joint.name: FlightRecorder(round(DEPTH_REVOLUTIONS * steps), kinematics.travel) for joint in contacts
        }
        # Virtual work does not give the force of a contact, which chatters on a polygon.
        # Settings without the field are of an engine with the weight of every link.
        gravity = given.get("gravity", True)
        self._exact_torque = None if contacts else ExactTorque(kinematics, machine.speed, gravity=gravity)
        self._torque: float | None = None
        self._waiting: list[Piece] = []  # to be compared together

    def add(self, piece: Piece) -> None:
        """Record a piece, with any outcome."""
        bodies = piece.trajectory.bodies
        assert bodies is not None
        self._samples += len(bodies.position.poses)
        self._warnings = dict(piece.warnings)
        self._finite = self._finite and all(bool(np.all(np.isfinite(v))) for _, v in recorded_series(piece.trajectory))
        self._fingerprint.add(piece.trajectory)
        if self._flights and self._finite:
            gaps = joint_gaps(self._machine.kinematics.mechanism, [bodies.position.poses])
            for name, flights in self._flights.items():
                flights.add(bodies.position.instants.angle, gaps[name])

    def compare(self, piece: Piece) -> None:
        """Add the errors of a completed piece, at once or with the next pieces."""
        self._waiting.append(piece)
        if sum(len(waiting.clock) for waiting in self._waiting) >= MIN_COMPARED_SAMPLES:
            self._compare_waiting()

    def _compare_waiting(self) -> None:
        """Compare all waiting pieces with the exact motion."""
        if not self._waiting:
            return
        piece, self._waiting = concatenate_pieces(self._waiting), []
        left = self._steps + 1 - piece.first_step - len(piece.clock)
        run = ComparedPiece(piece.trajectory, self._machine, left)
        self._errors.add(run)
        self._prediction.add(run)
        if piece.drive_torque is not None and self._exact_torque is not None and not self._exact_torque.is_negligible:
            # At the first sample an iterative solver has no start values.
            rows = slice(int(piece.first_step == 0), None)
            exact = self._exact_torque.evaluate(run.bodies.acceleration.instants.angle[rows])
            off = float(np.abs(piece.drive_torque[rows] - exact).max()) / self._exact_torque.peak
            self._torque = max(off, self._torque or 0.0)

    def result(self, verdict: RunVerdict) -> LimitResult:
        """Return the result of a run that ended with a verdict."""
        self._compare_waiting()
        completed = verdict.outcome is Outcome.COMPLETED
        return LimitResult(
            verdict.outcome.slug,
            verdict.reason,
            **(self._errors.as_dict() if completed else {}),
            misfit=(contradictions(self._prediction.misfit) or None) if completed else None,
            samples=self._samples,
            finite=self._finite,
            warnings=self._warnings,
            torque=self._torque,
            penetration=max((flights.penetration for flights in self._flights.values()), default=None),
            flights=tuple(flight for one in self._flights.values() if (flight := one.longest_flight()) is not None),
            fingerprint=self._fingerprint.digest(),
        )
