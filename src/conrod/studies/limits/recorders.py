"""Recorders of a run that comes in pieces: fingerprint, error sizes, solver, marks of a long run."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from conrod.exact.motion import Array
from conrod.runs.comparison import QUANTITIES, PointErrors
from conrod.runs.trajectory import BodyTracks, SolverState, Trajectory
from conrod.studies.limits.extremes import Mark, SolverRecord


class Fingerprint:
    """Hash of the samples taken in so far, however the run is cut.

    Positions, velocities and accelerations need not have the same instants, so each quantity is hashed for itself.
    """

    def __init__(self) -> None:
        self._hashes: dict[str, hashlib._Hash] = {}

    def add(self, trajectory: Trajectory) -> None:
        """Take in the next piece of a run."""
        for name, values in recorded(trajectory):
            self._hashes.setdefault(name, hashlib.sha256()).update(np.ascontiguousarray(values).data)

    def text(self) -> str:
        """Return it in 64 hexadecimal digits."""
        whole = hashlib.sha256()
        for name in sorted(self._hashes):
            whole.update(name.encode() + self._hashes[name].digest())
        return whole.hexdigest()


def recorded(trajectory: Trajectory) -> Iterator[tuple[str, Array]]:
    """Yield the states of the bodies and the motion of the points, by name."""
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
    """Largest, rms and final value of one series that comes in pieces."""

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

    def sizes(self) -> dict[str, float]:
        """Return max, rms and final value."""
        return {"max": self.largest, "rms": float(np.sqrt(self.squares / max(self.count, 1))), "final": self.final}


@dataclass
class RunningErrors:
    """Errors of all observed points, of the joints and of the drive."""

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


class SolverRecorder:
    """End of an engine's solver, one step after the other.

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
        # A state that is not finite is an outcome of its own.
        if math.isfinite(residual):
            self._residual = max(residual, self._residual or 0.0)
        if state.iterations is not None:
            self._least = min(state.iterations, state.iterations if self._least is None else self._least)
            self._most = max(state.iterations, state.iterations if self._most is None else self._most)

    def found(self) -> SolverRecord | None:
        """Return the record; None where no step was looked at."""
        if not self._looked:
            return None
        return SolverRecord(self._looked, self._allowed, self._least, self._most, self._residual)


SHORT = 2.0  # revolutions of a run that needs no history
DECADE = (1, 2, 5)


def marked(revolutions: float) -> tuple[int, ...]:
    """Return the revolutions that are marked: 1, 2, 5, 10, 20, .. and the last completed one; none of a short run."""
    if revolutions <= SHORT:
        return ()
    last = int(revolutions)
    series = (digit * 10**power for power in range(len(str(last))) for digit in DECADE)
    return (*(mark for mark in series if mark < last), last)


class History:
    """Marks of a run whose samples come in order, however many at a time."""

    def __init__(self, revolutions: float, steps_per_revolution: int) -> None:
        self.marks: list[Mark] = []
        self._steps = steps_per_revolution
        self._due = list(marked(revolutions))
        self._position = self._closure = 0.0

    @property
    def goes_on(self) -> bool:
        """True while a mark is still to come."""
        return bool(self._due)

    def add(self, first: int, position: Array, closure: Array, phase: Array, clock: Array) -> None:
        """Take in the samples from the one of an index on; each argument (T,), as `Mark` has them."""
        begin, end = 0, len(position)
        while self._due and begin < end:
            at = self._due[0] * self._steps - first  # place of the mark's sample
            rows = slice(begin, min(at + 1, end))
            self._position = max(self._position, float(position[rows].max()))
            self._closure = max(self._closure, float(closure[rows].max()))
            if at < end:
                mark = Mark(self._due.pop(0), self._position, self._closure, float(phase[at]), float(clock[at]))
                self.marks.append(mark)
                self._position = self._closure = 0.0
            begin = rows.stop
