"""Integration of an ordinary differential equation in time, restarted wherever a force has a kink.

A method of high order loses its order at a kink, of a load's law or where a roller changes arcs of its cam.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.dynamics.reduced_dynamics import ReducedDynamics
from conrod.exact.motion import Array
from conrod.mechanism.loads import Load, StrokePulse

if TYPE_CHECKING:  # slow to load, and of many processes that know this module few integrate
    from scipy.integrate import DOP853

RELATIVE_TOLERANCE = 3e-14
KINK_TOLERANCE = 1e-12  # of the time of a kink, over the whole duration
# After `MAX_SHORT_STEPS` consecutive steps below `SHORT_STEP` of the duration, the motion sticks in a force that
# changes with the direction of motion.
MAX_SHORT_STEPS, SHORT_STEP = 300, 1e-7

Event = Callable[[float, Array], float]


class EventIntegrator:
    """Integrator with restarts at kinks, which samples states and finds times of events.

    Args:
        rates: derivative of the state at a time.
        absolute: smallest size of each entry of the state (K,) that tolerances refer to.
        kink_events: functions of time and state whose change of sign is a kink of the rates.
        breaks: times [s] of kinks known before.
        begin_piece: called with the middle [s] of each piece between two of these, before it is integrated: at its end
            a force that jumps has two values.
        farthest: approximate largest change of the first entry in one step. Where nothing changes for a while, as in a
            cam's dwell, steps grow, and the stages of a long step may miss a force that sets in gently.
    """

    def __init__(
        self, rates: Callable[[float, Array], Array], absolute: Array, kink_events: Sequence[Event], breaks:
            Iterable[float],
        farthest: float, begin_piece: Callable[[float], None] = lambda _: None,
    ) -> None:  # fmt: skip
        self._rates, self._absolute, self._kinks, self._farthest = (
            rates,
            RELATIVE_TOLERANCE * absolute,
            kink_events,
            farthest,
        )
        self._breaks, self._begin_piece = sorted(breaks), begin_piece
        self.crossing_times: list[float] = []
        self._end, self._short = 1.0, 0

    def integrate(self, times: Array, start: Array, passing: Callable[[float, float], Sequence[float]]) -> Array:
        """Return states (T, K) at ascending times, from the start state at time 0.

        Args:
            passing: gives the values of the first entry between two limits whose times are wanted; those are then in
                `crossing_times`.

        Raises:
            InvalidInput: the motion cannot be integrated.
        """
        end = self._end = float(times[-1])
        self._times, self._sampled, self._passing = times, np.empty((len(times), len(start))), passing
        self._sampled[times <= 0.0] = start
        now, state = 0.0, start
        for stop in [*(t for t in self._breaks if 0.0 < t < end), end]:
            self._begin_piece(0.5 * (now + stop))
            while now < stop:
                now, state = self._until_kink(now, state, stop)
        return self._sampled

    def _until_kink(self, now: float, state: Array, stop: float) -> tuple[float, Array]:
        """Integrate up to the next kink or a stop time; return the time and the state there."""
        solver = self._solver(now, state, stop)
        # A kink that was just met is not met again.
        sides = [kink(now, state) for kink in self._kinks]
        while solver.status == "running":
            before = solver.y.copy()
            self._step(solver)
            dense = _DenseOutput(solver)
            met = self._first_kink(solver.t_old, solver.t, dense, sides)
            if met is not None:
                last = self._solver(solver.t_old, before, met)
                while last.status == "running":
                    self._step(last)
                self._sample(solver.t_old, met, dense, before, last.y)
                return met, last.y
            self._sample(solver.t_old, solver.t, dense, before, solver.y)
            sides = [kink(solver.t, solver.y) for kink in self._kinks]
        return float(solver.t), np.asarray(solver.y)

    def _solver(self, now: float, state: Array, stop: float) -> DOP853:
        """A Dormand-Prince solver from a state to a stop time."""
        from scipy.integrate import DOP853

        return DOP853(self._rates, now, state, stop, rtol=RELATIVE_TOLERANCE, atol=self._absolute)

    def _step(self, solver: DOP853) -> None:
        """Take one step of limited length; InvalidInput if it fails or steps stay too short."""
        solver.max_step = self._farthest / max(abs(float(solver.f[0])), 1e-300)
        message = solver.step()
        self._short = self._short + 1 if solver.t - solver.t_old < SHORT_STEP * self._end else 0
        if self._short > MAX_SHORT_STEPS:
            message = "forces or inertia change too fast there"
            if self._kinks:
                message = "it comes to rest in a force that acts in one sense alone, and sticks there; give friction"
        if solver.status == "failed" or self._short > MAX_SHORT_STEPS:
            raise InvalidInput(f"the motion cannot be integrated beyond t = {solver.t:g} s: {message}")

    def _first_kink(
        self, start: float, stop: float, dense: Callable[[float], Array], sides: list[float]
    ) -> float | None:
        """Time of the first kink in a step, just after it; None in a step without kinks."""
        from scipy.optimize import brentq

        found = []
        for kink, side in zip(self._kinks, sides, strict=True):
            if side * kink(stop, dense(stop)) < 0.0 and kink(start, dense(start)) * side > 0.0:
                at = brentq(lambda t, kink=kink: kink(t, dense(t)), start, stop, xtol=1e-300, rtol=1e-15)
                if start + KINK_TOLERANCE * self._end < at < stop - KINK_TOLERANCE * self._end:
                    found.append(at + 0.5 * KINK_TOLERANCE * self._end)
        return min(found, default=None)

    def _sample(self, start: float, stop: float, dense: Callable[[float], Array], before: Array, after: Array) -> None:
        """Store the states at sample times within a step, and the times of passed values."""
        from scipy.optimize import brentq

        times = self._times
        for k in np.flatnonzero((times > start) & (times <= stop)):
            self._sampled[k] = after if times[k] == stop else dense(times[k])
        for value in self._passing(*sorted((float(before[0]), float(after[0])))):
            self.crossing_times.append(brentq(lambda t, value=value: dense(t)[0] - value, start, stop))


class _DenseOutput:
    """States within the last step of a solver; its polynomial takes three stages more, made when it is first needed."""

    def __init__(self, solver: DOP853) -> None:
        self._solver = solver
        self._polynomial: Callable[[float], Array] | None = None

    def __call__(self, time: float) -> Array:
        if self._polynomial is None:
            self._polynomial = self._solver.dense_output()
        return np.asarray(self._polynomial(time))


def kink_events(reduced: ReducedDynamics, loads: Sequence[Load]) -> list[Event]:
    """Functions of time and state (arc length, rate, ...) that change sign at kinks of laws and cams."""
    events: list[Event] = [_CamArcEnds(reduced)] if reduced.mechanism.cam_contacts else []
    for place, load in enumerate(load for load in loads if not load.conservative):
        if isinstance(load.law, StrokePulse):
            events += [
                _coordinate_crossing(reduced, place, load.law.start),
                _coordinate_crossing(reduced, place, load.law.stop),
                _rate_reversal(reduced, place),
            ]
    return events


def _coordinate_crossing(reduced: ReducedDynamics, place: int, value: float) -> Event:
    """Event of a load's coordinate passing a value."""
    return lambda _, state: float(reduced.evaluate(float(state[0])).load_coordinates[place]) - value


def _rate_reversal(reduced: ReducedDynamics, place: int) -> Event:
    """Event of a load's coordinate changing direction."""
    return lambda _, state: float(reduced.evaluate(float(state[0])).load_derivatives[place]) * float(state[1])


class _CamArcEnds:
    """Event of a roller passing to another arc of its cam or segment of its law, where a derivative jumps.

    Its value is the distance in arc length from the nearest such place, with alternating sign.
    """

    def __init__(self, reduced: ReducedDynamics) -> None:
        self._reduced = reduced
        self._known: tuple[int, int, bool] | None = None
        self._joints: list[float] = []

    def __call__(self, _: float, state: Array) -> float:
        along, turns = float(state[0]), 0.0
        joints, loop = self._arc_ends(), self._reduced.configurations.loop
        if not joints:
            return 1.0
        if loop is not None:
            turns = math.floor(along / loop.length)
            along -= turns * loop.length
            near = [*joints, joints[0] + loop.length, joints[-1] - loop.length]
        else:
            near = joints
        before = bisect_right(joints, along) - bisect_right(joints, 0.0) + int(turns) * len(joints)
        return (-1.0) ** (before % 2) * min(abs(along - joint) for joint in near)

    def _arc_ends(self) -> list[float]:
        """Arc lengths of arc ends on the part of the curve that is known, ascending."""
        known = self._reduced.configurations
        key = (len(known.ahead), len(known.behind), known.loop is None)
        if key != self._known:
            pieces = [*known.behind[::-1], *known.ahead]
            self._joints = [after.start for before, after in pairwise(pieces) if before.arcs != after.arcs]
            if known.loop is not None and pieces[0].arcs != pieces[-1].arcs:
                self._joints.insert(0, pieces[0].start)
            self._known = key
        return self._joints
