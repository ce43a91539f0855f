"""Flights of a follower off its cam, detected from the gap between the two as a run goes on.

A follower that is held sinks into the cam a little, as soft as the contact is. It flies where the gap is more than ten
times that depth. What a contact chatters by shrinks with the step and is over within a few; a flight's length depends
on no step.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

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
        self._waiting: list[tuple[Array, Array]] | None = []
        self._depth = 0.0
        self._last: tuple[float, float] | None = None  # angle and gap of the sample before
        self._begun: float | None = None  # angle at which the flight that is not over began
        self._height = 0.0
        self._over: list[Flight] = []

    @property
    def penetration(self) -> float:
        """Deepest that the follower sank at first [m]."""
        return self._depth

    @property
    def threshold(self) -> float:
        """Gap [m] beyond which the follower is off the cam."""
        return TIMES * max(self._depth, self._least)

    def add(self, angle: Array, gap: Array) -> None:
        """Take in crank angles (T,) [rad] and gaps (T,) [m], negative where the follower sinks in."""
        if self._waiting is None:
            self._follow(angle, gap)
            return
        self._waiting.append((angle, gap))
        if sum(len(angles) for angles, _ in self._waiting) > self._held:
            self._settle()

    def found(self) -> tuple[Flight, ...]:
        """The longest ones, the longest first; one that is not over is taken to land at the last sample."""
        self._settle()
        if self._begun is None or self._last is None:
            return longest(self._over)
        return longest([*self._over, Flight(self._begun, self._last[0], self._height)])

    def _settle(self) -> None:
        """The depth is known now: what waited for it is looked at."""
        if not self._waiting:
            return
        angle, gap = (np.concatenate(parts) for parts in zip(*self._waiting, strict=True))
        self._waiting = None
        self._depth = max(0.0, -float(gap[: self._held].min()))
        self._follow(angle, gap)

    def _follow(self, angle: Array, gap: Array) -> None:
        """Split into what is on the cam and what is off it."""
        if self._last is not None:
            angle, gap = np.append(self._last[0], angle), np.append(self._last[1], gap)
        elif gap[0] > self.threshold:
            self._begun, self._height = float(angle[0]), 0.0
        off = gap > self.threshold
        borders = np.flatnonzero(off[1:] != off[:-1])
        crossings = self._crossings(angle, gap, borders)
        begin = 0
        for border, crossing in zip(borders.tolist(), crossings.tolist(), strict=True):
            if self._begun is None:
                self._begun, self._height = crossing, 0.0
            else:
                self._land(crossing, gap[begin : border + 1])
            begin = border + 1
        if self._begun is not None:
            self._height = max(self._height, float(gap[begin:].max()))
        self._last = float(angle[-1]), float(gap[-1])

    def _crossings(self, angle: Array, gap: Array, borders: NDArray[np.intp]) -> Array:
        """Angles at which the gap passes the threshold, between the samples before and after."""
        before, after = gap[borders], gap[borders + 1]
        share = (self.threshold - before) / (after - before)
        return angle[borders] + share * (angle[borders + 1] - angle[borders])

    def _land(self, at: float, gaps: Array) -> None:
        assert self._begun is not None
        self._over.append(Flight(self._begun, at, max(self._height, float(gaps.max()))))
        self._begun = None
        if len(self._over) > 10 * KEPT:
            self._over = list(longest(self._over))


def longest(flights: Sequence[Flight]) -> tuple[Flight, ...]:
    """The longest of flights, the longest first; of equally long ones those that came first."""
    return tuple(sorted(flights, key=lambda flight: -abs(flight.landing - flight.start))[:KEPT])
