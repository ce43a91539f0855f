"""Onset of a follower's flights off its cam, measured, and its flights beside the exact ones.

A flight is a gap above ten times the static penetration for a time that does not shrink with h: every speed is run with
two steps, h and h/2, and the polygon that stands for the cam gets facets in proportion to the steps, so that all that
is not the machine's own, rebound of the contact and corners of the polygon alike, shrinks with h. Speeds are over
the float speed; the force is the same at all of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from conrod.engines.running import run
from conrod.exact.motion import Array
from conrod.runs.outcome import joint_gaps
from conrod.runs.plain import plain
from conrod.scenes import CamFollower
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.study import Study
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.exact_flight import ExactFlight, Fall, bisect, exact_flight, float_speed
from conrod.studies.limits.extremes import Extremes, Flight
from conrod.studies.limits.flights import LEAST_DEPTH, TIMES
from conrod.studies.limits.float_results import ComparedFlight, FollowerFloat, GapCurve, Gaps, OnsetProbe
from conrod.studies.limits.stream_run import stream_run

LEAST_STEPS = 20000  # a revolution
STEPS_PER_FACET = 5
# The flight of the fastest lands more than a turn after the start.
COMPARED_SPEEDS, REVOLUTIONS = (1.05, 1.2, 1.5, 2.0, 3.0), 1.25
HELD_SPEEDS = (0.9, 0.7, 0.5)  # at the first of which that makes no flight, the onset is bracketed
CLOSELY = 1.002  # ratio of the speeds between which the onset is found
LENGTH_SPEED = 1.05  # whose flight's length gives the onset once more
DRAWN_SPEED, DRAWN_POINTS = 1.5, 200
# Excess over the float speed at which lengths of exact flights are drawn.
EXCESSES = np.geomspace(0.001, 0.25, 24)
# Speeds among which one with a given exact flight is looked for, and how closely.
SLOWEST_FLIGHT, FASTEST_FLIGHT, SPEED_WIDTH = 1.0001, 4.0, 1e-5


def float_search(setup: Setup) -> Study[FollowerFloat]:
    """Find onset and flights of a setup, at no fewer than `LEAST_STEPS` a revolution."""
    bench = _Bench(setup)
    found = FollowerFloat(setup.name, setup.engine, setup.preset, bench.refusal, None, bench.steps, bench.vertices)
    if found.refusal:
        return found
    curve = yield from _drawn(bench)
    trials = yield from _bracketed(bench)
    while (middle := _middle(trials)) is not None:
        trials += yield from _tried(bench, (middle,))
    trials.sort(key=lambda trial: trial.probe.speed)
    held, flown = _bracket(trials)
    depth = None if held is None else held.penetration
    return replace(
        found,
        theory=float_speed(bench.scene),
        penetration=depth,
        held=None if held is None else held.probe.speed,
        flown=None if flown is None else flown.probe.speed,
        visible=None if held is None else bench.speed_of(lambda exact: exact.gap - held.threshold),
        from_length=_from_length(bench, trials),
        probes=tuple(trial.probe for trial in trials),
        flights=tuple(flight for trial in trials if trial.probe.speed in COMPARED_SPEEDS for flight in trial.flights),
        curve=curve,
        exact_lengths=tuple((speed, bench.exact_length(speed)) for speed in (1.0 + EXCESSES).tolist()),
    )


def most_float_runs() -> int:
    """Return the largest number of runs that one search can ask for."""
    # Every speed takes two, and the one that is drawn a run more. Between neighbours of the first speeds the ratio is
    # halved, on its logarithm, until it is close enough.
    listed = sorted((*COMPARED_SPEEDS, *HELD_SPEEDS))
    widest = max(math.log(faster / slower) for slower, faster in pairwise(listed))
    halvings = math.ceil(math.log2(widest / math.log(CLOSELY)))
    return 1 + 2 * (len(listed) + halvings)


class _Bench:
    """The cases of a setup and the exact flights beside them."""

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        steps = max(setup.steps, LEAST_STEPS)
        self.steps = (steps, 2 * steps)
        self.vertices = (self.steps[0] // STEPS_PER_FACET, self.steps[1] // STEPS_PER_FACET)
        self.refusal = AXES["float"].refusal(setup) or ""
        if not self.refusal and not isinstance(setup.scene, CamFollower):
            self.refusal = f"the exact flight of a {setup.scene.kind} is not known"

    @property
    def scene(self) -> CamFollower:
        """The scene whose follower flies."""
        assert isinstance(self.setup.scene, CamFollower)
        return self.setup.scene

    def case(self, speed: float, finer: int) -> LimitCase:
        """The run at a speed, with the coarser step (0) or the finer one (1)."""
        setup = replace(self.setup, steps_per_revolution=self.steps[finer])
        case = AXES["float"].case(setup, speed)
        settings = setup.variations.faceted(case.settings, self.vertices[finer])
        return replace(case, settings=settings, revolutions=REVOLUTIONS)

    def at(self, speed: float) -> CamFollower:
        """The scene at a speed."""
        return self.scene.with_parameters(speed=speed * float_speed(self.scene), preload=1.0 / speed**2)

    def exact(self, speed: float) -> ExactFlight | None:
        """The exact flight at a speed."""
        return exact_flight(self.at(speed))

    def exact_length(self, speed: float) -> float:
        """Its length [rad], 0 where the exact follower is held."""
        exact = self.exact(speed)
        return 0.0 if exact is None else exact.landing - exact.start

    def threshold(self, penetration: float) -> float:
        """Gap [m] above which a follower that sinks in so deep [m] flies; as `Flights` has it."""
        return TIMES * max(penetration, LEAST_DEPTH * self.scene.kinematics.travel)

    def speed_of(self, excess: Callable[[ExactFlight], float]) -> float:
        """The speed at which something that grows with the exact flight is zero; an end of the range where it is not.

        The range is from `SLOWEST_FLIGHT` to `FASTEST_FLIGHT`.
        """

        def at(speed: float) -> float:
            flight = self.exact(speed)
            return -1.0 if flight is None else excess(flight)

        for end, sign in ((SLOWEST_FLIGHT, 1.0), (FASTEST_FLIGHT, -1.0)):
            if sign * at(end) >= 0.0:
                return end
        return bisect(at, SLOWEST_FLIGHT, FASTEST_FLIGHT, SPEED_WIDTH)


@dataclass(frozen=True)
class _Trial:
    """Findings of the runs at a speed; the depths are of the coarser one [m]."""

    probe: OnsetProbe
    flights: tuple[ComparedFlight, ...]
    penetration: float
    threshold: float


def _tried(bench: _Bench, speeds: Sequence[float]) -> Study[list[_Trial]]:
    """Runs with the coarser step, and with the finer one where they show a flight."""
    coarse = {speed: bench.case(speed, 0) for speed in speeds}
    results = yield tuple(coarse.values())
    shown = {speed: [results[case.key]] for speed, case in coarse.items()}
    fine = {speed: bench.case(speed, 1) for speed, (first,) in shown.items() if _longest(first) is not None}
    if fine:
        results = yield tuple(fine.values())
    for speed, case in fine.items():
        shown[speed].append(results[case.key])
    return [_trial(bench, speed, measurements) for speed, measurements in shown.items()]


def _longest(measurement: Measurement) -> Flight | None:
    recorded = Extremes.of(measurement)
    return None if recorded is None else next(iter(recorded.flights), None)


def _trial(bench: _Bench, speed: float, measurements: Sequence[Measurement]) -> _Trial:
    exact = bench.exact(speed)
    flights = [_longest(measurement) for measurement in measurements]
    lengths = [0.0 if flight is None else abs(flight.landing - flight.start) for flight in flights]
    recorded = Extremes.of(measurements[0])
    depth = (None if recorded is None else recorded.penetration) or 0.0
    return _Trial(
        OnsetProbe(speed, (lengths[0], lengths[1] if len(lengths) > 1 else None), bench.exact_length(speed)),
        tuple(
            ComparedFlight(speed, steps, measurement.outcome, exact, flight)
            for steps, measurement, flight in zip(bench.steps, measurements, flights, strict=False)
        ),
        depth,
        bench.threshold(depth),
    )


def _bracketed(bench: _Bench) -> Study[list[_Trial]]:
    """The speeds that are compared, and slower ones down to one that makes no flight."""
    trials = yield from _tried(bench, (*COMPARED_SPEEDS, HELD_SPEEDS[0]))
    for speed in HELD_SPEEDS[1:]:
        if _bracket(trials)[0] is not None:
            break
        trials += yield from _tried(bench, (speed,))
    return trials


def _bracket(trials: Sequence[_Trial]) -> tuple[_Trial | None, _Trial | None]:
    """The slowest speed that makes a flight, and the fastest one below that makes none."""
    flown = min((t for t in trials if t.probe.flies), key=lambda t: t.probe.speed, default=None)
    limit = math.inf if flown is None else flown.probe.speed
    below = [t for t in trials if not t.probe.flies and t.probe.speed < limit]
    return max(below, key=lambda t: t.probe.speed, default=None), flown


def _middle(trials: Sequence[_Trial]) -> float | None:
    """The speed to try next; None where there is no onset, or it is known closely."""
    held, flown = _bracket(trials)
    if held is None or flown is None or flown.probe.speed <= CLOSELY * held.probe.speed:
        return None
    return math.sqrt(held.probe.speed * flown.probe.speed)


def _from_length(bench: _Bench, trials: Sequence[_Trial]) -> float | None:
    """Return the onset predicted from the length of a flight with the finer step: exact ones as long begin at it."""
    length = next(trial.probe.lengths[1] for trial in trials if trial.probe.speed == LENGTH_SPEED)
    if not length:
        return None
    return LENGTH_SPEED / bench.speed_of(lambda exact: exact.landing - exact.start - length)


def _drawn(bench: _Bench) -> Study[GapCurve | None]:
    case = bench.case(DRAWN_SPEED, 0)
    drawn = GapCase(case.name, case.scene, case.settings, case.revolutions)
    results = yield (drawn,)
    recorded, exact = Extremes.of(results[drawn.key]), bench.exact(DRAWN_SPEED)
    if recorded is None or recorded.penetration is None or not recorded.gaps or exact is None:
        return None
    angles = np.linspace(exact.start, exact.landing, DRAWN_POINTS)
    gaps = Fall(bench.at(DRAWN_SPEED), exact.start).gap(angles)
    return GapCurve(
        speed=DRAWN_SPEED,
        steps_per_revolution=bench.steps[0],
        gaps=recorded.gaps,
        exact=tuple(zip(angles.tolist(), gaps.tolist(), strict=True)),
        penetration=recorded.penetration,
        threshold=bench.threshold(recorded.penetration),
    )


# -- the gap over a run, for a figure --------------------------------------------------------------------------------

SPANS = 360  # of a run, of each of which the least and the largest gap are kept


@dataclass(frozen=True)
class GapCase(LimitCase):
    """A run of a cam whose measurement carries the gap over the run as well; it is made twice for that."""

    def perform(self) -> Measurement:
        measurement = stream_run(self)
        recorded = Extremes.of(measurement)
        if recorded is None or not recorded.finite:
            return measurement
        mechanism = self.machine.kinematics.mechanism
        trajectory = run(self.machine, self.settings, self.revolutions, self.start_angle)
        assert trajectory.bodies is not None
        states = trajectory.bodies.position
        gap = joint_gaps(mechanism, [states.poses])[mechanism.cam_contacts[0].name]
        return replace(measurement, extremes=plain(replace(recorded, gaps=thinned(states.instants.angle, gap))))

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        return super()._identity(parameters) | {"gap_spans": SPANS}


def thinned(angle: Array, gap: Array) -> Gaps:
    """Return the gap in the middle, the least and the largest one of each of `SPANS` equal parts of a run."""
    angles, gaps = (np.array_split(values, min(SPANS, len(values))) for values in (angle, gap))
    return tuple(
        (float(a[len(a) // 2]), float(g[len(g) // 2]), float(g.min()), float(g.max()))
        for a, g in zip(angles, gaps, strict=True)
    )
