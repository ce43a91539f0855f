"""Measured onset of a follower's flights off its cam, over the theoretical float speed.

A flight is a gap above ten times the static penetration for a time that does not shrink with the step h. Every speed is
run with steps h and h/2, and the polygon of the cam has facets in proportion to the steps, so that rebounds of the
contact and corners of the polygon shrink with h. Speeds are over the float speed; the force is the same at all.

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
from conrod.execution.case import Study
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.changed_machines import with_float_speed_share
from conrod.studies.limits.records import LimitResult

ONSET_STEPS, STEPS_PER_FACET = (20000, 40000), 5  # steps per revolution, coarse and fine
ONSET_REVOLUTIONS = 1.25
FIRST_SPEEDS = (0.9, 1.05, 1.2, 1.5)
SLOWER_SPEEDS = (0.7, 0.5)  # run one after another while the slowest speed makes a flight
MAX_ONSET_RATIO = 1.002  # of the two speeds between which the onset lies in the end
# A flight whose length falls with the step by this order or more shrinks with it.
SHRINKING_ORDER = 0.5
ONSET_TOLERANCE = 0.02  # relative difference of measured and theoretical onset that counts as agreement


@dataclass(frozen=True)
class OnsetProbe:
    """Two runs at a speed, with steps h and h/2.

    Attributes:
        speed: crank speed as a ratio to the float speed.
        lengths: lengths [rad] of the longest flight with the coarse and the fine step; 0 without a flight. The fine
            step is not run, and its length None, if there is no flight with the coarse step.
    """

    speed: float
    lengths: tuple[float, float | None]

    @property
    def flies(self) -> bool:
        """True if the longest flight does not shrink with the step h."""
        coarse, fine = self.lengths
        return fine is not None and fine > coarse * 0.5**SHRINKING_ORDER


@dataclass(frozen=True)
class FollowerFloat:
    """Onset of follower float in an engine with a preset; speeds are ratios to the float speed.

    Attributes:
        theory: theoretical float speed [rad/s].
        held: fastest speed below all flights that do not shrink with h; None without such a speed.
        flown: slowest speed with a flight that does not shrink with h; None without such a speed.
        probes: all speeds that were run, in increasing order.
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
        """Measured onset over the float speed: sqrt(held * flown); None if not found."""
        return None if self.held is None or self.flown is None else (self.held * self.flown) ** 0.5


def onset_search(setup: Setup) -> Study[FollowerFloat]:
    """Find the onset of float by bisection, on a setup that has the axis `float`."""
    found = yield from _run_speeds(setup, FIRST_SPEEDS)
    slower = list(SLOWER_SPEEDS)
    while True:
        probes = tuple(found[speed] for speed in sorted(found))
        held, flown = _onset_bracket(probes)
        if held is None and slower:
            speed = slower.pop(0)
        elif held is not None and flown is not None and flown > MAX_ONSET_RATIO * held:
            speed = math.sqrt(held * flown)
        else:
            break
        found |= yield from _run_speeds(setup, (speed,))
    theory = abs(with_float_speed_share(setup, 1.0).speed)
    return FollowerFloat(*setup.names, theory, held, flown, probes)


def _onset_bracket(probes: Sequence[OnsetProbe]) -> tuple[float | None, float | None]:
    """Fastest speed below all flights, and slowest speed with a flight; None if missing."""
    flown = min((probe.speed for probe in probes if probe.flies), default=None)
    below = [probe.speed for probe in probes if not probe.flies and (flown is None or probe.speed < flown)]
    return max(below, default=None), flown


def _run_speeds(setup: Setup, speeds: Sequence[float]) -> Study[dict[float, OnsetProbe]]:
    """Run speeds with the coarse step, and with the fine step if they show a flight."""
    cases = {speed: onset_case(setup, speed, 0) for speed in speeds}
    results = yield tuple(cases.values())
    coarse = {speed: _longest_flight(results[case.key]) for speed, case in cases.items()}
    cases = {speed: onset_case(setup, speed, 1) for speed, length in coarse.items() if length > 0.0}
    results = (yield tuple(cases.values())) if cases else {}
    fine = {speed: _longest_flight(results[case.key]) for speed, case in cases.items()}
    return {speed: OnsetProbe(speed, (length, fine.get(speed))) for speed, length in coarse.items()}


def onset_case(setup: Setup, speed: float, finer: int) -> LimitCase:
    """Return the run at a speed with the coarse step (0) or the fine step (1)."""
    case = AXES["float"].case(replace(setup, steps_per_revolution=ONSET_STEPS[finer]), speed)
    settings = with_fields(case.settings, cam_vertices=ONSET_STEPS[finer] // STEPS_PER_FACET)
    return replace(case, settings=settings, revolutions=ONSET_REVOLUTIONS)


def _longest_flight(result: LimitResult) -> float:
    """Length of a run's longest flight [rad], 0 without a flight."""
    return max((flight.length for flight in result.flights), default=0.0)
