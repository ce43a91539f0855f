"""What the pieces of a run have shown so far."""

from __future__ import annotations

import numpy as np

from conrod.comparison import point_errors
from conrod.joined import joined
from conrod.motion import Array
from conrod.outcome import Verdict, joint_gaps
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.exact_torque import ExactTorque
from conrod.studies.limits.extremes import Extremes
from conrod.studies.limits.fingerprint import Fingerprint, recorded
from conrod.studies.limits.flights import HELD, Flights, longest
from conrod.studies.limits.history import History
from conrod.studies.limits.sizes import ORDERS, RunningErrors
from conrod.studies.limits.solver_look import SolverLook
from conrod.studies.measurement import Measurement
from conrod.trajectory import BodyTracks, Outcome, Piece

COMPARED = 2048  # samples that are compared together, where pieces are shorter


class Seen:
    """Of the run of a cell."""

    def __init__(self, cell: LimitCell) -> None:
        machine, settings, plain = cell.machine, cell.settings, cell.settings.as_dict()
        kinematics, steps = machine.kinematics, settings.steps_per_revolution
        contacts = kinematics.mechanism.cam_contacts
        self._machine, self._timestep = machine, settings.timestep
        self._length = max(machine.lengths.values())
        self._samples, self._finite = 0, True
        self._warnings: dict[str, int] = {}
        self._errors, self._fingerprint = RunningErrors(), Fingerprint()
        self._history = History(cell.revolutions, steps)
        self._solver = SolverLook(plain["iterations"], machine.speed, self._length)
        self._flights = {joint.name: Flights(round(HELD * steps), kinematics.travel) for joint in contacts}
        # A contact's force is not told by virtual work: it chatters, and its cam is a polygon.
        self._exact_torque = (
            None if contacts else ExactTorque(kinematics, machine.speed, gravity=plain["gravity"], rod=plain["rod"])
        )
        self._torque: float | None = None
        self._start_of_clock = 0.0
        self._waiting: list[Piece] = []  # to be compared together

    def add(self, piece: Piece) -> None:
        """Count a piece, whatever became of it."""
        bodies = piece.trajectory.bodies
        assert bodies is not None
        if piece.first_step == 0:
            self._start_of_clock = float(piece.clock[0])
        self._samples += len(bodies.position.poses)
        self._warnings = dict(piece.warnings)
        self._finite = self._finite and all(bool(np.all(np.isfinite(v))) for _, v in recorded(piece.trajectory))
        self._fingerprint.add(piece.trajectory)
        self._solver.add(piece.solver)
        if self._flights and self._finite:
            gaps = joint_gaps(self._machine.kinematics.mechanism, [bodies.position.poses])
            for name, flights in self._flights.items():
                flights.add(bodies.position.instants.angle, gaps[name])

    def compare(self, piece: Piece) -> None:
        """Take in the errors of a piece that completed, at once or with some that follow it."""
        self._waiting.append(piece)
        if sum(len(waiting.clock) for waiting in self._waiting) >= COMPARED:
            self._compare()

    def _compare(self) -> None:
        if not self._waiting:
            return
        piece, self._waiting = joined(self._waiting), []
        bodies = piece.trajectory.bodies
        assert bodies is not None
        points, closure = point_errors(piece.trajectory, self._machine), self._closure(bodies)
        self._errors.add(points, closure, bodies, self._machine.speed)
        if self._history.goes_on:
            position = np.max([errors.position.error for errors in points.values()], axis=0)
            self._history.add(piece.first_step, position, closure["position"], *self._phases(piece, bodies))
        if piece.drive_torque is not None and self._exact_torque is not None and not self._exact_torque.is_nothing:
            # At the very first sample an iterative solver has nothing to start from.
            rows = slice(int(piece.first_step == 0), None)
            exact = self._exact_torque.at(bodies.acceleration.instants.angle[rows])
            off = float(np.abs(piece.drive_torque[rows] - exact).max()) / self._exact_torque.peak
            self._torque = max(off, self._torque or 0.0)

    def _closure(self, bodies: BodyTracks) -> dict[str, Array]:
        """Largest gap of a joint, its rate and its acceleration at their samples, normalised."""
        position, velocity, acceleration = bodies.position, bodies.velocity, bodies.acceleration
        derivatives = (
            [position.poses],
            [velocity.poses, velocity.rates],
            [acceleration.poses, acceleration.rates, acceleration.accelerations],
        )
        mechanism, speed = self._machine.kinematics.mechanism, abs(self._machine.speed)
        return {
            order: np.abs(list(joint_gaps(mechanism, some).values())).max(axis=0) / (self._length * speed**k)
            for k, (order, some) in enumerate(zip(ORDERS, derivatives, strict=True))
        }

    def _phases(self, piece: Piece, bodies: BodyTracks) -> tuple[Array, Array]:
        """How far the crank, and a clock that sums its steps, are ahead of counted steps; in crank angle [rad]."""
        speed, at = self._machine.speed, bodies.position.instants
        counted = self._timestep * np.arange(piece.first_step, piece.first_step + len(at.times))
        return at.angle - speed * at.times, speed * (piece.clock - self._start_of_clock - counted)

    def measurement(self, verdict: Verdict) -> Measurement:
        """Of a run that ended so."""
        self._compare()
        extremes = self._extremes().as_dict()
        if verdict.outcome is not Outcome.COMPLETED:
            return Measurement(verdict.outcome.slug, verdict.reason, extremes=extremes)
        errors = self._errors
        return Measurement(
            outcome=verdict.outcome.slug,
            errors={p: {q: size.as_dict() for q, size in sizes.items()} for p, sizes in errors.points.items()},
            closure={order: size.largest for order, size in errors.closure.items()},
            phase={"max": errors.phase.largest, "final": errors.phase.final},
            drive={"speed": errors.speed.largest, "acceleration": errors.acceleration.largest},
            extremes=extremes,
        )

    def _extremes(self) -> Extremes:
        return Extremes(
            samples=self._samples,
            finite=self._finite,
            warnings=self._warnings,
            solver=self._solver.found(),
            torque=self._torque,
            penetration=max((flights.penetration for flights in self._flights.values()), default=None),
            flights=longest([flight for flights in self._flights.values() for flight in flights.found()]),
            history=tuple(self._history.marks),
            fingerprint=self._fingerprint.text(),
        )
