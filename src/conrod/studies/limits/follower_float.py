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
from typing import Any

import numpy as np
from scipy.optimize import bisect

from conrod.engines.engine import with_fields
from conrod.engines.running import run
from conrod.exact.motion import Array
from conrod.runs.outcome import joint_gaps
from conrod.runs.plain import plain
from conrod.scenes import CamFollower
from conrod.studies.frame.case import Study
from conrod.studies.frame.measurement import Measurement
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.exact_flight import ExactFlight, Fall, exact_flight, float_speed
from conrod.studies.limits.float_results import ComparedFlight, FollowerFloat, GapCurve, OnsetProbe
from conrod.studies.limits.recorders import LEAST_DEPTH, TIMES
from conrod.studies.limits.records import Extremes, Flight, Gaps
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
# Of each speed the runs with the coarser step and, where that shows a flight, with the finer one.
Runs = dict[float, tuple[Measurement, ...]]
SPANS = 360  # of the run that is drawn, of each of which the least and the largest gap are kept


def float_search(setup: Setup) -> Study[FollowerFloat]:
    """Find onset and flights of a setup, at no fewer than `LEAST_STEPS` a revolution."""
    bench = _Bench(setup)
    found = FollowerFloat(setup.name, setup.engine, setup.preset, bench.refusal, None, bench.steps, bench.vertices)
    if found.refusal:
        return found
    curve = yield from _drawn(bench)
    runs = yield from _runs_about_the_onset(bench)
    probes = tuple(bench.probe(speed, runs[speed]) for speed in sorted(runs))
    held, flown = _bracket(probes)
    # Exact flights as long as one of the finer step begin at the onset.
    length = next(probe.lengths[1] for probe in probes if probe.speed == LENGTH_SPEED)
    depth = visible = None
    if held is not None:
        depth = Extremes.of(runs[held][0]).penetration or 0.0
        threshold = bench.threshold(depth)
        visible = bench.speed_of(lambda exact: exact.gap - threshold)
    return replace(
        found,
        theory=float_speed(bench.scene),
        penetration=depth,
        held=held,
        flown=flown,
        visible=visible,
        from_length=LENGTH_SPEED / bench.speed_of(lambda e: e.landing - e.start - length) if length else None,
        probes=probes,
        flights=tuple(flight for speed in COMPARED_SPEEDS for flight in bench.compared(speed, runs[speed])),
        curve=curve,
        exact_lengths=tuple((speed, bench.exact_length(speed)) for speed in (1.0 + EXCESSES).tolist()),
    )


def _runs_about_the_onset(bench: _Bench) -> Study[Runs]:
    """Runs at the speeds that are compared, at slower ones down to one that makes no flight, and at those between."""
    runs = yield from _tried(bench, (*COMPARED_SPEEDS, HELD_SPEEDS[0]))
    slower = list(HELD_SPEEDS[1:])
    while True:
        held, flown = _bracket([bench.probe(speed, of) for speed, of in runs.items()])
        if held is None and slower:
            speed = slower.pop(0)
        elif held is not None and flown is not None and flown > CLOSELY * held:
            speed = math.sqrt(held * flown)
        else:
            return runs
        runs |= yield from _tried(bench, (speed,))


def _bracket(probes: Sequence[OnsetProbe]) -> tuple[float | None, float | None]:
    """The fastest speed below all flights, and the slowest one that makes a flight."""
    flown = min((probe.speed for probe in probes if probe.flies), default=None)
    below = [probe.speed for probe in probes if not probe.flies and (flown is None or probe.speed < flown)]
    return max(below, default=None), flown


def _tried(bench: _Bench, speeds: Sequence[float]) -> Study[Runs]:
    """Runs with the coarser step, and with the finer one where they show a flight."""
    coarse = {speed: bench.case(speed, 0) for speed in speeds}
    results = yield tuple(coarse.values())
    runs: Runs = {speed: (results[case.key],) for speed, case in coarse.items()}
    fine = {speed: bench.case(speed, 1) for speed, (one,) in runs.items() if _longest(one) is not None}
    if fine:
        results = yield tuple(fine.values())
    return runs | {speed: (*runs[speed], results[case.key]) for speed, case in fine.items()}


def _longest(measurement: Measurement) -> Flight | None:
    return next(iter(Extremes.of(measurement).flights), None)


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
        settings = with_fields(case.settings, cam_vertices=self.vertices[finer])
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

    def probe(self, speed: float, runs: Sequence[Measurement]) -> OnsetProbe:
        """What the runs at a speed show."""
        coarse, *fine = (0.0 if f is None else abs(f.landing - f.start) for f in map(_longest, runs))
        return OnsetProbe(speed, (coarse, fine[0] if fine else None), self.exact_length(speed))

    def compared(self, speed: float, runs: Sequence[Measurement]) -> list[ComparedFlight]:
        """The longest flight of each of the runs at a speed beside the exact one."""
        exact, each = self.exact(speed), zip(self.steps, runs, strict=False)
        return [ComparedFlight(speed, steps, one.outcome, exact, _longest(one)) for steps, one in each]

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
        return float(bisect(at, SLOWEST_FLIGHT, FASTEST_FLIGHT, xtol=0.5 * SPEED_WIDTH))


def _drawn(bench: _Bench) -> Study[GapCurve | None]:
    case = bench.case(DRAWN_SPEED, 0)
    drawn = GapCase(case.name, case.scene, case.settings, case.revolutions)
    results = yield (drawn,)
    recorded, exact = Extremes.of(results[drawn.key]), bench.exact(DRAWN_SPEED)
    if recorded.penetration is None or not recorded.gaps or exact is None:
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


@dataclass(frozen=True)
class GapCase(LimitCase):
    """A run of a cam whose measurement carries the gap over the run as well; it is made twice for that."""

    def perform(self) -> Measurement:
        measurement = stream_run(self)
        recorded = Extremes.of(measurement)
        if not recorded.samples or not recorded.finite:
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
