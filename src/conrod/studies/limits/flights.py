"""Flights of a follower off its cam, detected from the gap between the two as a run goes on.

A follower that is held sinks into the cam a little, as soft as the contact is. It flies where the gap is more than ten
times that depth. What a contact chatters by shrinks with the step and is over within a few; a flight's length depends
on no step.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from conrod.exact.motion import Array
from conrod.studies.limits.records import Flight

HELD = 0.1  # of a revolution from the start on, in which the follower is looked at for how deep it sinks
TIMES = 10.0  # so many times that depth is off the cam
LEAST_DEPTH = 1e-7  # of the travel: a contact that sinks less is taken not to sink at all
KEPT = 10


class Flights:
    """Takes in the gap of a cam contact at consecutive samples, however many at a time.

    Args:
        held: samples from which the depth is taken, before anything can be called a flight.
        travel: of the follower [m].
    """

    def __init__(self, held: int, travel: float) -> None:
        self._held, self._least = max(held, 2), LEAST_DEPTH * travel
        self._angle, self._gap = np.empty(0), np.empty(0)  # samples that are not looked at yet, after the one before
        self._depth: float | None = None
        self._open: Flight | None = None  # one that is not over, so far
        self._over: list[Flight] = []

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

    def found(self) -> tuple[Flight, ...]:
        """The longest ones, the longest first; one that is not over is taken to land at the last sample."""
        self._follow()
        return longest(self._over if self._open is None else [*self._over, self._open])

    def _follow(self) -> None:
        """Split into what is on the cam and what is off it."""
        angle, gap = self._angle, self._gap
        if len(gap) == 0:
            return
        if self._depth is None:
            self._depth = max(0.0, -float(gap[: self._held].min()))
            if gap[0] > self.threshold:
                self._open = Flight(float(angle[0]), float(angle[0]), 0.0)
        off = gap > self.threshold
        borders = np.flatnonzero(off[1:] != off[:-1])
        before, after = gap[borders], gap[borders + 1]
        # The gap passes the threshold between the samples before and after.
        share = (self.threshold - before) / (after - before)
        crossings = angle[borders] + share * (angle[borders + 1] - angle[borders])
        begin = 0
        for border, crossing in zip(borders.tolist(), crossings.tolist(), strict=True):
            if self._open is None:
                self._open = Flight(crossing, crossing, 0.0)
            else:
                self._over.append(_on(self._open, crossing, gap[begin : border + 1]))
                self._open = None
            begin = border + 1
        if self._open is not None:
            self._open = _on(self._open, float(angle[-1]), gap[begin:])
        if len(self._over) > 10 * KEPT:
            self._over = list(longest(self._over))
        self._angle, self._gap = angle[-1:], gap[-1:]


def _on(flight: Flight, angle: float, gaps: Array) -> Flight:
    """A flight up to an angle, with the gaps (T,) since."""
    return Flight(flight.start, angle, max(flight.gap, float(gaps.max())))


def longest(flights: Sequence[Flight]) -> tuple[Flight, ...]:
    """The longest of flights, the longest first; of equally long ones those that came first."""
    return tuple(sorted(flights, key=lambda flight: -abs(flight.landing - flight.start))[:KEPT])
