"""Onset of a follower's flights off its cam, measured, beside the theory's float speed.

A flight is a gap above ten times the static penetration for a time that does not shrink with h: every speed is run with
two steps, h and h/2, and the polygon that stands for the cam gets facets in proportion to the steps, so that all that
is not the machine's own, rebound of the contact and corners of the polygon alike, shrinks with h. Speeds are over
the float speed; the force is the same at all of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from conrod.engines.engine import with_fields
from conrod.scenes import CamFollower
from conrod.studies.frame.case import Study
from conrod.studies.frame.measurement import Measurement
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.exact_flight import exact_flight, float_speed
from conrod.studies.limits.recorders import LEAST_DEPTH, TIMES
from conrod.studies.limits.records import Extremes

STEPS, STEPS_PER_FACET = (20000, 40000), 5  # a revolution
REVOLUTIONS = 1.25
SPEEDS = (0.9, 1.05, 1.2, 1.5)
SLOWER = (0.7, 0.5)  # of which the next one is run while the slowest makes a flight
CLOSELY = 1.002  # ratio of the speeds between which the onset is found
# Excess over the float speed at which lengths of exact flights are drawn.
EXCESSES = np.geomspace(0.001, 0.25, 24)
# A flight whose length falls with the step by this order or more shrinks with it. The order is 1 or more of a held
# follower's rebounds, 0 of a flight which the speed makes, and one half just at the onset, with rebounds that shrink as
# h does; see `conrod.studies.limits.exact_flight`.
SHRINKING_ORDER = 0.5
WITHIN = 0.02  # how near to the theory's an onset is to be
# Of each speed the runs with the coarser step and, where that shows a flight, with the finer one.
Runs = dict[float, tuple[Measurement, ...]]


@dataclass(frozen=True)
class OnsetProbe:
    """Two runs at a speed, with steps h and h/2.

    Attributes:
        speed: over the float speed.
        lengths: of the longest flights, the coarser step's first [rad]; 0 where there is none. Without one with the
            coarser step there is none to shrink: nothing was run with the finer one, which is None.
        exact: length of the exact flight [rad]; 0 where the exact follower is held.
    """

    speed: float
    lengths: tuple[float, float | None]
    exact: float

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
        penetration: static, with the coarser steps, at the speed nearest below the onset [m].
        held, flown: the fastest speed without a flight that does not shrink with h, and the slowest with one; None
            where there is no such speed.
        fit: whether the contact is hard enough to show the onset as near as `WITHIN`: so far above it the exact
            flight's gap is more than ten times that penetration.
        exact_lengths: speed and length of the exact flight [rad], around the onset.
    """

    scene: str
    engine: str
    preset: str
    theory: float
    penetration: float | None
    held: float | None
    flown: float | None
    fit: bool
    probes: tuple[OnsetProbe, ...]
    exact_lengths: tuple[tuple[float, float], ...]

    @property
    def onset(self) -> float | None:
        """Measured onset over the theory's; None where it was not found."""
        return None if self.held is None or self.flown is None else (self.held * self.flown) ** 0.5


def float_search(setup: Setup) -> Study[FollowerFloat]:
    """Find the onset of a setup that has the axis `float`."""
    runs = yield from _tried(setup, SPEEDS)
    slower = list(SLOWER)
    while True:
        probes = tuple(probe_of(setup, speed, runs[speed]) for speed in sorted(runs))
        held, flown = _bracket(probes)
        if held is None and slower:
            speed = slower.pop(0)
        elif held is not None and flown is not None and flown > CLOSELY * held:
            speed = math.sqrt(held * flown)
        else:
            break
        runs |= yield from _tried(setup, (speed,))
    depth = None if held is None else Extremes.of(runs[held][0]).penetration or 0.0
    return FollowerFloat(
        *(setup.name, setup.engine, setup.preset, float_speed(_scene(setup)), depth, held, flown),
        fit=depth is not None and _shows(setup, 1.0 + WITHIN, depth),
        probes=probes,
        exact_lengths=tuple((speed, exact_length(setup, speed)) for speed in (1.0 + EXCESSES).tolist()),
    )


def _bracket(probes: Sequence[OnsetProbe]) -> tuple[float | None, float | None]:
    """The fastest speed below all flights, and the slowest one that makes a flight."""
    flown = min((probe.speed for probe in probes if probe.flies), default=None)
    below = [probe.speed for probe in probes if not probe.flies and (flown is None or probe.speed < flown)]
    return max(below, default=None), flown


def _tried(setup: Setup, speeds: Sequence[float]) -> Study[Runs]:
    """Runs with the coarser step, and with the finer one where they show a flight."""
    coarse = {speed: case_at(setup, speed, 0) for speed in speeds}
    results = yield tuple(coarse.values())
    runs: Runs = {speed: (results[case.key],) for speed, case in coarse.items()}
    fine = {speed: case_at(setup, speed, 1) for speed, (one,) in runs.items() if _length(one) > 0.0}
    if fine:
        results = yield tuple(fine.values())
    return runs | {speed: (*runs[speed], results[case.key]) for speed, case in fine.items()}


def case_at(setup: Setup, speed: float, finer: int) -> LimitCase:
    """The run at a speed, with the coarser step (0) or the finer one (1)."""
    case = AXES["float"].case(replace(setup, steps_per_revolution=STEPS[finer]), speed)
    settings = with_fields(case.settings, cam_vertices=STEPS[finer] // STEPS_PER_FACET)
    return replace(case, settings=settings, revolutions=REVOLUTIONS)


def probe_of(setup: Setup, speed: float, runs: Sequence[Measurement]) -> OnsetProbe:
    """What the runs at a speed show."""
    coarse, *fine = map(_length, runs)
    return OnsetProbe(speed, (coarse, fine[0] if fine else None), exact_length(setup, speed))


def _length(measurement: Measurement) -> float:
    """Length of a run's longest flight [rad], 0 where it has none."""
    return max((flight.length for flight in Extremes.of(measurement).flights), default=0.0)


# -- the exact flights beside them -------------------------------------------------------------------------------------


def _scene(setup: Setup) -> CamFollower:
    assert isinstance(setup.scene, CamFollower)
    return setup.scene


def at(scene: CamFollower, speed: float) -> CamFollower:
    """The scene at a speed over the float speed."""
    return scene.with_parameters(speed=speed * float_speed(scene), preload=1.0 / speed**2)


def exact_length(setup: Setup, speed: float) -> float:
    """Length of the exact flight at a speed [rad], 0 where the exact follower is held."""
    exact = exact_flight(at(_scene(setup), speed))
    return 0.0 if exact is None else exact.landing - exact.start


def _shows(setup: Setup, speed: float, penetration: float) -> bool:
    """Whether `Flights` would see the exact flight at a speed, of a follower that sinks in so deep [m]."""
    exact = exact_flight(at(_scene(setup), speed))
    return exact is not None and exact.gap > TIMES * max(penetration, LEAST_DEPTH * setup.scene.kinematics.travel)
