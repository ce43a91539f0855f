"""Onset of a follower's flights off its cam, measured, beside the theory's float speed.

A flight is a gap above ten times the static penetration for a time that does not shrink with h: every speed is run with
two steps, h and h/2, and the polygon that stands for the cam gets facets in proportion to the steps, so that all that
is not the machine's own, rebound of the contact and corners of the polygon alike, shrinks with h. Speeds are over
the float speed; the force is the same at all of them.

Where the flank ends and the nose begins, y'' (by the crank angle p) jumps from above zero to -A, and rises from there
by k A p. At s times the float speed, where A is what the force just gives, a follower that leaves with a small speed u
of its own is d = u p + A (e p^2 / 2 - k p^3 / 6) above the cam, e = 1 - 1/s^2. So it flies for 2 u / (A |e|) well below
the float speed, for sqrt(6 u / (A k)) at it and for 3 e / k above. Where u shrinks as h does, so do flights below; the
order in h of their length passes through one half at the onset, or, where u shrinks faster, a little above.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from conrod.engines.engine import with_fields
from conrod.studies.frame.case import Measurement, Study
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.changed_machines import at_float_speed
from conrod.studies.limits.records import Extremes

STEPS, STEPS_PER_FACET = (20000, 40000), 5  # a revolution
REVOLUTIONS = 1.25
SPEEDS = (0.9, 1.05, 1.2, 1.5)
SLOWER = (0.7, 0.5)  # of which the next one is run while the slowest makes a flight
CLOSELY = 1.002  # ratio of the speeds between which the onset is found
# A flight whose length falls with the step by this order or more shrinks with it.
SHRINKING_ORDER = 0.5
WITHIN = 0.02  # how near to the theory's an onset is to be


@dataclass(frozen=True)
class OnsetProbe:
    """Two runs at a speed, with steps h and h/2.

    Attributes:
        speed: over the float speed.
        lengths: of the longest flights, the coarser step's first [rad]; 0 where there is none. Without one with the
            coarser step there is none to shrink: nothing was run with the finer one, which is None.
    """

    speed: float
    lengths: tuple[float, float | None]

    @property
    def flies(self) -> bool:
        """True where there is a flight that does not shrink with h."""
        coarse, fine = self.lengths
        return fine is not None and fine > coarse * 0.5**SHRINKING_ORDER


@dataclass(frozen=True)
class FollowerFloat:
    """Follower float in one engine with one preset; speeds are over the float speed unless said otherwise.

    Attributes:
        theory: the float speed [rad/s].
        held, flown: the fastest speed without a flight that does not shrink with h, and the slowest with one; None
            where there is no such speed.
    """

    scene: str
    engine: str
    preset: str
    theory: float
    held: float | None
    flown: float | None
    probes: tuple[OnsetProbe, ...]

    @property
    def onset(self) -> float | None:
        """Measured onset over the theory's; None where it was not found."""
        return None if self.held is None or self.flown is None else (self.held * self.flown) ** 0.5


def float_search(setup: Setup) -> Study[FollowerFloat]:
    """Find the onset of a setup that has the axis `float`."""
    found = yield from _tried(setup, SPEEDS)
    slower = list(SLOWER)
    while True:
        probes = tuple(found[speed] for speed in sorted(found))
        held, flown = _bracket(probes)
        if held is None and slower:
            speed = slower.pop(0)
        elif held is not None and flown is not None and flown > CLOSELY * held:
            speed = math.sqrt(held * flown)
        else:
            break
        found |= yield from _tried(setup, (speed,))
    theory = abs(at_float_speed(setup, 1.0).speed)
    return FollowerFloat(*setup.who, theory, held, flown, probes)


def _bracket(probes: Sequence[OnsetProbe]) -> tuple[float | None, float | None]:
    """The fastest speed below all flights, and the slowest one that makes a flight."""
    flown = min((probe.speed for probe in probes if probe.flies), default=None)
    below = [probe.speed for probe in probes if not probe.flies and (flown is None or probe.speed < flown)]
    return max(below, default=None), flown


def _tried(setup: Setup, speeds: Sequence[float]) -> Study[dict[float, OnsetProbe]]:
    """Runs with the coarser step, and with the finer one where they show a flight."""
    cases = {speed: case_at(setup, speed, 0) for speed in speeds}
    results = yield tuple(cases.values())
    coarse = {speed: _length(results[case.key]) for speed, case in cases.items()}
    cases = {speed: case_at(setup, speed, 1) for speed, length in coarse.items() if length > 0.0}
    results = (yield tuple(cases.values())) if cases else {}
    fine = {speed: _length(results[case.key]) for speed, case in cases.items()}
    return {speed: OnsetProbe(speed, (length, fine.get(speed))) for speed, length in coarse.items()}


def case_at(setup: Setup, speed: float, finer: int) -> LimitCase:
    """The run at a speed, with the coarser step (0) or the finer one (1)."""
    case = AXES["float"].case(replace(setup, steps_per_revolution=STEPS[finer]), speed)
    settings = with_fields(case.settings, cam_vertices=STEPS[finer] // STEPS_PER_FACET)
    return replace(case, settings=settings, revolutions=REVOLUTIONS)


def _length(measurement: Measurement) -> float:
    """Length of a run's longest flight [rad], 0 where it has none."""
    return max((flight.length for flight in Extremes.of(measurement).flights), default=0.0)
