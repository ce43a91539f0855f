"""Recorders of a run that comes in pieces: fingerprint, error sizes, solver, marks of a long run, drive torque."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from conrod.engines.massless_rod import model_form
from conrod.exact.dynamics.coordinates import load_forces
from conrod.exact.dynamics.inverse import inertia_forces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.runs.trajectory import SolverState, Trajectory
from conrod.studies.limits.records import Mark, SolverRecord


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


def looked(record: SolverRecord, state: SolverState, scale: tuple[float, float]) -> SolverRecord:
    """Return the record of an engine's solver with one more step.

    Args:
        scale: of the machine: speed x length [m/s] and speed^2 x length [m/s^2], see `SolverRecord.residual`.
    """
    residual = state.residual / scale[0 if state.of_rates else 1]
    # A state that is not finite is an outcome of its own.
    residuals = [one for one in (record.residual, residual) if one is not None and math.isfinite(one)]
    taken = [one for one in (record.least, record.most, state.iterations) if one is not None]
    ends = min(taken, default=None), max(taken, default=None), max(residuals, default=None)
    return SolverRecord(record.looked_at + 1, record.allowed, *ends)


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


PEAK_SAMPLES = 3600  # of a turn
# Of what all bodies take that move through the travel in a radian: a drive that takes no more than that takes nothing.
NOTHING = 1e-12


class ExactTorque:
    """Torque of a drive at constant speed in the exact motion, of a linkage as an engine is given it.

    By virtual work: what the bodies' inertia and weight take, M q'' - Q, along the motion q' by the crank angle. It is
    the multiplier of the driver's equation, without the joints' reactions, which do no work.

    Args:
        speed: of the crank [rad/s].
        gravity: whether the engine is given any.
        rod: form of links that carry nothing but two pins, see `ROD_FORMS`.
    """

    def __init__(self, kinematics: Kinematics, speed: float, *, gravity: bool, rod: str) -> None:
        self._kinematics, self._speed = kinematics, speed
        self._form = model_form(kinematics.mechanism, rod)
        given = self._form.mechanism
        self._given = given if gravity else replace(given, gravity=(0.0, 0.0))

    @cached_property
    def peak(self) -> float:
        """Largest magnitude over a turn, or over the driver's span [N m]."""
        start, stop = self._kinematics.span
        middle, width = 0.5 * (start + stop), 0.5 * (stop - start)
        for _ in range(2):  # once around, and once more about the highest sample, since a peak can be sharp
            angles = middle + width * np.linspace(-1.0, 1.0, PEAK_SAMPLES)
            if self._kinematics.mechanism.driver.span is not None:
                angles = np.clip(angles, start, stop)
            sizes = np.abs(self.at(angles))
            middle, width = float(angles[np.argmax(sizes)]), 2.0 * width / PEAK_SAMPLES
        return float(sizes.max())

    @cached_property
    def is_nothing(self) -> bool:
        """True where the drive takes nothing but rounding: wheels about their own centres, and no gravity."""
        mass = sum(body.mass for body in self._given.bodies)
        return self.peak <= NOTHING * mass * (self._kinematics.travel * self._speed) ** 2

    def at(self, angle: Array) -> Array:
        """Torque (T,) [N m] about the crank, in the sense of the crank angle, at crank angles (T,) [rad]."""
        poses, first, second = (self._form.kept(d) for d in self._kinematics.derivatives(angle, 2))
        rates = first * self._speed
        forces = inertia_forces(self._given, poses, rates, second * self._speed**2)
        forces -= load_forces(self._given, poses, rates, angle / self._speed)
        return np.asarray(np.sum(forces * first, axis=1), dtype=float)
