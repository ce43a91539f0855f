"""Recorders of a run that comes in pieces: fingerprint, drive torque, flights."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np

from conrod.exact.dynamics import load_forces
from conrod.exact.equations import inertia_forces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.runs.trajectory import Trajectory
from conrod.studies.limits.records import Flight


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

    def texts(self) -> dict[str, str]:
        """Return those of all quantities, by name, in 16 hexadecimal digits."""
        return {name: found.hexdigest()[:16] for name, found in self._hashes.items()}


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
    """

    def __init__(self, kinematics: Kinematics, speed: float, *, gravity: bool) -> None:
        self._kinematics, self._speed = kinematics, speed
        given = kinematics.mechanism
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
        poses, first, second = self._kinematics.derivatives(angle, 2)
        rates = first * self._speed
        forces = inertia_forces(self._given, poses, rates, second * self._speed**2)
        forces -= load_forces(self._given, poses, rates, angle / self._speed)
        return np.asarray(np.sum(forces * first, axis=1), dtype=float)


HELD = 0.1  # of a revolution from the start on, in which the follower is looked at for how deep it sinks
TIMES = 10.0  # so many times that depth is off the cam
LEAST_DEPTH = 1e-7  # of the travel: a contact that sinks less is taken not to sink at all


class Flights:
    """Flights of a follower off its cam, detected from the gap at consecutive samples, however many at a time.

    A follower that is held sinks into the cam a little, as soft as the contact is. It flies where the gap is more than
    ten times that depth. What a contact chatters by shrinks with the step and is over within a few; a flight's length
    depends on no step.

    Args:
        held: samples from which the depth is taken, before anything can be called a flight.
        travel: of the follower [m].
    """

    def __init__(self, held: int, travel: float) -> None:
        self._held, self._least = max(held, 2), LEAST_DEPTH * travel
        self._angle, self._gap = np.empty(0), np.empty(0)  # samples that are not looked at yet, after the one before
        self._depth: float | None = None
        self._start: float | None = None  # of a flight that is not over, so far
        self._longest: Flight | None = None

    @property
    def penetration(self) -> float:
        """Deepest that the follower sank at first [m]."""
        return self._depth or 0.0

    @property
    def threshold(self) -> float:
        """Gap [m] beyond which the follower is off the cam."""
        return TIMES * max(self.penetration, self._least)

    def add(self, angle: Array, gap: Array) -> None:
        """Take in crank angles (T,) [rad] and gaps (T,) [m], negative where the follower sinks in."""
        self._angle, self._gap = np.append(self._angle, angle), np.append(self._gap, gap)
        if self._depth is not None or len(self._gap) > self._held:
            self._follow()

    def longest(self) -> Flight | None:
        """The longest one, of equally long ones the first; one that is not over is taken to land at the last sample."""
        self._follow()
        if self._start is not None:
            self._land(float(self._angle[-1]))
        return self._longest

    def _follow(self) -> None:
        """Split into what is on the cam and what is off it."""
        angle, gap = self._angle, self._gap
        if len(gap) == 0:
            return
        if self._depth is None:
            self._depth = max(0.0, -float(gap[: self._held].min()))
            if gap[0] > self.threshold:
                self._start = float(angle[0])
        off = gap > self.threshold
        borders = np.flatnonzero(off[1:] != off[:-1])
        before, after = gap[borders], gap[borders + 1]
        # The gap passes the threshold between the samples before and after.
        share = (self.threshold - before) / (after - before)
        for crossing in (angle[borders] + share * (angle[borders + 1] - angle[borders])).tolist():
            if self._start is None:
                self._start = crossing
            else:
                self._land(crossing)
        self._angle, self._gap = angle[-1:], gap[-1:]

    def _land(self, angle: float) -> None:
        assert self._start is not None
        flight, self._start = Flight(self._start, angle), None
        if self._longest is None or flight.length > self._longest.length:
            self._longest = flight
