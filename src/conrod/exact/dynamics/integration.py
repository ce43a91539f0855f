"""Integration of an ordinary differential equation in time, begun anew wherever a force has a kink.

Where laws of loads have kinks, and cams their joints: an integrator of high order begins anew there.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from conrod.errors import InvalidInput
from conrod.exact.dynamics.line import Line
from conrod.exact.motion import Array
from conrod.mechanism.loads import Load, StrokePulse

RELATIVE = 3e-14
JUST = 1e-12  # of the time in all: how well an instant of a kink is known
# So many steps in a row of less than this of the time in all: the motion sticks where a force changes with its sense.
MOST_SHORT, SHORT = 300, 1e-7

Event = Callable[[float, Array], float]


class Course:
    """States at wanted times, and stretches between them that can be asked for instants.

    Args:
        rates: derivative of the state at a time.
        absolute: what each entry of the state is at least measured by (K,).
        kinks: functions of time and state whose change of sign is a kink of the rates; breaks: times [s] of such.
        farthest: of the first entry in one step, about. Where nothing changes for a while, as in a cam's dwell, steps
            grow, and the stages of a long one may miss what begins gently behind it.
    """

    def __init__(
        self, rates: Callable[[float, Array], Array], absolute: Array, kinks: Sequence[Event], breaks: Iterable[float],
        farthest: float,
    ) -> None:  # fmt: skip
        self._rates, self._absolute, self._kinks, self._farthest = rates, RELATIVE * absolute, kinks, farthest
        self._breaks = sorted(breaks)
        self.passed: list[float] = []
        self._end, self._short = 1.0, 0

    def run(self, times: Array, start: Array, passing: Callable[[float, float], Sequence[float]]) -> Array:
        """States (T, K) at growing times, the start at 0.

        Args:
            passing: of two values of the first entry, growing, those between whose instants are wanted: then in
                `passed`.

        Raises:
            InvalidInput: the motion cannot be integrated.
        """
        end = self._end = float(times[-1])
        self._times, self._sampled, self._passing = times, np.empty((len(times), len(start))), passing
        self._sampled[times <= 0.0] = start
        now, state = 0.0, start
        for stop in [*(t for t in self._breaks if 0.0 < t < end), end]:
            while now < stop:
                now, state = self._until_kink(now, state, stop)
        return self._sampled

    def _until_kink(self, now: float, state: Array, stop: float) -> tuple[float, Array]:
        solver = self._solver(now, state, stop)
        # A kink that was just met is not met again.
        sides = [kink(now, state) for kink in self._kinks]
        while solver.status == "running":
            before = solver.y.copy()
            self._step(solver)
            dense = solver.dense_output()
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
        return DOP853(self._rates, now, state, stop, rtol=RELATIVE, atol=self._absolute)

    def _step(self, solver: DOP853) -> None:
        solver.max_step = self._farthest / max(abs(float(solver.f[0])), 1e-300)
        message = solver.step()
        self._short = self._short + 1 if solver.t - solver.t_old < SHORT * self._end else 0
        if self._short > MOST_SHORT:
            message = "forces or inertia change too fast there"
            if self._kinks:
                message = "it comes to rest in a force that acts in one sense alone, and sticks there; give friction"
        if solver.status == "failed" or self._short > MOST_SHORT:
            raise InvalidInput(f"the motion cannot be integrated beyond t = {solver.t:g} s: {message}")

    def _first_kink(
        self, start: float, stop: float, dense: Callable[[float], Array], sides: list[float]
    ) -> float | None:
        found = []
        for kink, side in zip(self._kinks, sides, strict=True):
            if side * kink(stop, dense(stop)) < 0.0 and kink(start, dense(start)) * side > 0.0:
                at = brentq(lambda t, kink=kink: kink(t, dense(t)), start, stop, xtol=1e-300, rtol=1e-15)
                if start + JUST * self._end < at < stop - JUST * self._end:
                    found.append(at + 0.5 * JUST * self._end)
        return min(found, default=None)

    def _sample(self, start: float, stop: float, dense: Callable[[float], Array], before: Array, after: Array) -> None:
        times = self._times
        for k in np.flatnonzero((times > start) & (times <= stop)):
            self._sampled[k] = after if times[k] == stop else dense(times[k])
        for value in self._passing(*sorted((float(before[0]), float(after[0])))):
            self.passed.append(brentq(lambda t, value=value: dense(t)[0] - value, start, stop))


def kinks(line: Line, loads: Sequence[Load]) -> list[Event]:
    """Functions of time and state (arc length, rate, ...) that change sign at kinks of laws and joints of cams."""
    events: list[Event] = [_CamJoints(line)] if line.mechanism.cam_contacts else []
    for place, load in enumerate(load for load in loads if not load.conservative):
        if isinstance(load.law, StrokePulse):
            events += [_reaches(line, place, load.law.start), _reaches(line, place, load.law.stop), _turns(line, place)]
    return events


def _reaches(line: Line, place: int, value: float) -> Event:
    return lambda _, state: float(line.at(float(state[0])).values[place]) - value


def _turns(line: Line, place: int) -> Event:
    return lambda _, state: float(line.at(float(state[0])).rates[place]) * float(state[1])


class _CamJoints:
    """Arc lengths at which rollers pass from one arc of a cam, or segment of its law, to the next: a derivative jumps.

    As a function of the state it is the distance from the nearest such place, with another sign behind each.
    """

    def __init__(self, line: Line) -> None:
        self._line = line
        self._known: tuple[int, int, bool] | None = None
        self._joints: list[float] = []

    def __call__(self, _: float, state: Array) -> float:
        along, turns = float(state[0]), 0.0
        joints, loop = self._places(), self._line.configurations.loop
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

    def _places(self) -> list[float]:
        """Arc lengths of the joints on the part of the curve that is known, growing."""
        known = self._line.configurations
        key = (len(known.ahead), len(known.behind), known.loop is None)
        if key != self._known:
            pieces = [*known.behind[::-1], *known.ahead]
            self._joints = [after.start for before, after in pairwise(pieces) if before.arcs != after.arcs]
            if known.loop is not None and pieces[0].arcs != pieces[-1].arcs:
                self._joints.insert(0, pieces[0].start)
            self._known = key
        return self._joints
