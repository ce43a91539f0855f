"""The states of a run and the motion of its points in one hash, which does not depend on how the run is cut.

Max, rms and final value of series that come in pieces, as `conrod.studies.measurement` has them of whole ones.

How an engine's solver ended, over the steps of a run that were looked at.

What the pieces of a run have shown so far.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from conrod.exact.motion import Array
from conrod.runs.comparison import QUANTITIES, PointErrors, point_errors
from conrod.runs.outcome import Verdict, joint_gaps
from conrod.runs.trajectory import BodyTracks, Outcome, Piece, SolverState, Trajectory, joined
from conrod.studies.frame.measurement import Measurement
from conrod.studies.limits.extremes import ExactTorque, Extremes, SolverWatch
from conrod.studies.limits.flights import HELD, Flights, longest
from conrod.studies.limits.run_length import History

if TYPE_CHECKING:
    from conrod.studies.limits.cell import LimitCell


class Fingerprint:
    """Of the samples taken in so far.

    Positions, velocities and accelerations need not have the same instants, so each quantity is hashed for itself.
    """

    def __init__(self) -> None:
        self._hashes: dict[str, hashlib._Hash] = {}

    def add(self, trajectory: Trajectory) -> None:
        """Take in the next piece of a run."""
        for name, values in recorded(trajectory):
            self._hashes.setdefault(name, hashlib.sha256()).update(np.ascontiguousarray(values).data)

    def text(self) -> str:
        """In 64 hexadecimal digits."""
        whole = hashlib.sha256()
        for name in sorted(self._hashes):
            whole.update(name.encode() + self._hashes[name].digest())
        return whole.hexdigest()


def recorded(trajectory: Trajectory) -> Iterator[tuple[str, Array]]:
    """The states of the bodies and the motion of the points, by name."""
    assert trajectory.bodies is not None
    states = trajectory.bodies.position
    yield "bodies position", states.poses
    yield "bodies rate", states.rates
    for name, tracks in trajectory.points.items():
        yield f"{name} position", tracks.position.values
        yield f"{name} velocity", tracks.velocity.values
        yield f"{name} acceleration", tracks.acceleration.values


ORDERS = ("position", "velocity", "acceleration")


@dataclass
class RunningSize:
    """Of one series."""

    largest: float = 0.0
    squares: float = 0.0
    count: int = 0
    final: float = 0.0

    def add(self, values: Array) -> None:
        """Take in what follows."""
        if len(values) == 0:
            return
        self.largest = max(self.largest, float(values.max()))
        self.squares += float(values @ values)
        self.count += len(values)
        self.final = float(values[-1])

    def as_dict(self) -> dict[str, float]:
        """Max, rms and final value."""
        return {"max": self.largest, "rms": float(np.sqrt(self.squares / max(self.count, 1))), "final": self.final}


@dataclass
class RunningErrors:
    """Of all observed points, of the joints and of the drive."""

    points: dict[str, dict[str, RunningSize]] = field(default_factory=dict)
    closure: dict[str, RunningSize] = field(default_factory=lambda: {order: RunningSize() for order in ORDERS})
    phase: RunningSize = field(default_factory=RunningSize)
    speed: RunningSize = field(default_factory=RunningSize)
    acceleration: RunningSize = field(default_factory=RunningSize)

    def add(
        self, points: Mapping[str, PointErrors], closure: Mapping[str, Array], bodies: BodyTracks, speed: float
    ) -> None:
        """Take in a piece of a run at a crank speed [rad/s].

        Args:
            closure: largest gap of a joint, its rate and its acceleration at each sample, normalised.
        """
        for name, errors in points.items():
            sizes = self.points.setdefault(name, {quantity: RunningSize() for quantity in QUANTITIES})
            for quantity in QUANTITIES:
                sizes[quantity].add(getattr(errors, quantity).error)
        for order, gaps in closure.items():
            self.closure[order].add(gaps)
        position = bodies.position.instants
        self.phase.add(np.abs(position.angle - speed * position.times))
        self.speed.add(np.abs(bodies.velocity.instants.rate / speed - 1.0))
        self.acceleration.add(np.abs(bodies.acceleration.instants.acceleration) / speed**2)


class SolverLook:
    """Takes in one step after the other.

    Args:
        allowed: iterations that the solver may take.
        speed: of the crank [rad/s].
        length: that errors of the machine are normalised by [m].
    """

    def __init__(self, allowed: int, speed: float, length: float) -> None:
        self._allowed, self._speed, self._length = allowed, abs(speed), length
        self._least: int | None = None
        self._most: int | None = None
        self._residual: float | None = None
        self._looked = 0

    def add(self, state: SolverState | None) -> None:
        """Take in a step; None where there was nothing to look at."""
        if state is None:
            return
        self._looked += 1
        residual = state.residual / (self._length * self._speed ** (1 if state.of_rates else 2))
        # What is not a number any more is told as such elsewhere.
        if math.isfinite(residual):
            self._residual = max(residual, self._residual or 0.0)
        if state.iterations is not None:
            self._least = min(state.iterations, state.iterations if self._least is None else self._least)
            self._most = max(state.iterations, state.iterations if self._most is None else self._most)

    def found(self) -> SolverWatch | None:
        """None where no step was looked at."""
        if not self._looked:
            return None
        return SolverWatch(self._looked, self._allowed, self._least, self._most, self._residual)


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
