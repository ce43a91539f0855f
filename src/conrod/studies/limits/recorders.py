"""Recorders of a run in pieces: exact drive torque, flights of a follower."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from conrod.exact.dynamics import load_forces
from conrod.exact.equations import inertia_forces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.studies.limits.records import Flight

PEAK_SAMPLES = 3600  # of a turn
# Largest torque that counts as none, as a share of M (travel * speed)^2 with the mass M of all bodies.
NEGLIGIBLE_TORQUE = 1e-12


class ExactTorque:
    """Exact torque of a drive at constant speed on a linkage, by virtual work.

    T = (M q_tt - Q) . dq/dtheta, with masses M, accelerations q_tt, loads Q (weight included) and the motion q of the
    crank angle theta. Reactions of the joints do no work.

    Args:
        kinematics: the linkage.
        speed: crank speed [rad/s].
        gravity: True if the engine has gravity.
    """

    def __init__(self, kinematics: Kinematics, speed: float, *, gravity: bool) -> None:
        self._kinematics, self._speed = kinematics, speed
        given = kinematics.mechanism
        self._given = given if gravity else replace(given, gravity=(0.0, 0.0))

    @cached_property
    def peak(self) -> float:
        """Largest magnitude of the torque over a turn, or the driver's span [N m]."""
        start, stop = self._kinematics.span
        middle, width = 0.5 * (start + stop), 0.5 * (stop - start)
        for _ in range(2):  # once around, and once more about the highest sample, since a peak can be sharp
            angles = middle + width * np.linspace(-1.0, 1.0, PEAK_SAMPLES)
            if self._kinematics.mechanism.driver.span is not None:
                angles = np.clip(angles, start, stop)
            sizes = np.abs(self.evaluate(angles))
            middle, width = float(angles[np.argmax(sizes)]), 2.0 * width / PEAK_SAMPLES
        return float(sizes.max())

    @cached_property
    def is_negligible(self) -> bool:
        """True if the torque is only rounding, as of balanced wheels without gravity."""
        mass = sum(body.mass for body in self._given.bodies)
        return self.peak <= NEGLIGIBLE_TORQUE * mass * (self._kinematics.travel * self._speed) ** 2

    def evaluate(self, angle: Array) -> Array:
        """Return torques (T,) [N m] on the crank at crank angles (T,) [rad].

        A torque is positive in the sense of the crank angle.
        """
        poses, first, second = self._kinematics.derivatives(angle, 2)
        rates = first * self._speed
        forces = inertia_forces(self._given, poses, rates, second * self._speed**2)
        forces -= load_forces(self._given, poses, rates, angle / self._speed)
        return np.asarray(np.sum(forces * first, axis=1), dtype=float)


DEPTH_REVOLUTIONS = 0.1  # revolutions from the start in which the penetration is measured
FLIGHT_DEPTH_RATIO = 10.0  # a gap above this many penetrations is a flight
MIN_DEPTH = 1e-7  # least penetration that is used, as a share of the travel


class FlightRecorder:
    """Recorder of a follower's flights off its cam, from the gap at consecutive samples.

    A follower in contact penetrates the cam a little, as the contact is soft. It flies while the gap is more than ten
    times that penetration. Chatter of a contact shrinks with the step and ends within a few steps; the length of a
    flight does not depend on the step.

    Args:
        held: number of first samples, from which the penetration is measured.
        travel: travel of the follower [m].
    """

    def __init__(self, held: int, travel: float) -> None:
        self._held, self._least = max(held, 2), MIN_DEPTH * travel
        self._angle, self._gap = np.empty(0), np.empty(0)  # samples that wait, after the last that was processed
        self._depth: float | None = None
        self._start: float | None = None  # crank angle [rad] of a flight that has not ended
        self._longest: Flight | None = None

    @property
    def penetration(self) -> float:
        """Largest penetration of the follower in the first samples [m]."""
        return self._depth or 0.0

    @property
    def threshold(self) -> float:
        """Gap [m] above which the follower flies."""
        return FLIGHT_DEPTH_RATIO * max(self.penetration, self._least)

    def add(self, angle: Array, gap: Array) -> None:
        """Add crank angles (T,) [rad] and gaps (T,) [m], negative for penetration."""
        self._angle, self._gap = np.append(self._angle, angle), np.append(self._gap, gap)
        if self._depth is not None or len(self._gap) > self._held:
            self._split_flights()

    def longest_flight(self) -> Flight | None:
        """Return the longest flight, the first of equal ones; None without a flight.

        A flight that has not ended is taken to end at the last sample.
        """
        self._split_flights()
        if self._start is not None:
            self._end_flight(float(self._angle[-1]))
        return self._longest

    def _split_flights(self) -> None:
        """Find starts and ends of flights in waiting samples, by interpolation of the gap."""
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
                self._end_flight(crossing)
        self._angle, self._gap = angle[-1:], gap[-1:]

    def _end_flight(self, angle: float) -> None:
        """End the current flight at a crank angle [rad], and keep it if it is the longest."""
        assert self._start is not None
        flight, self._start = Flight(self._start, angle), None
        if self._longest is None or flight.length > self._longest.length:
            self._longest = flight
