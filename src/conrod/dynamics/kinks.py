"""Where laws of loads have kinks, and cams their joints: an integrator of high order begins anew there."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Sequence

from conrod.dynamics.integration import Event
from conrod.dynamics.line import Line
from conrod.dynamics.pieces import Samples
from conrod.loads import Load, StrokePulse, TimePulse
from conrod.motion import Array


def breaks(loads: Iterable[Load]) -> list[float]:
    """Times [s] at which laws have kinks."""
    pulses = [load.law for load in loads if isinstance(load.law, TimePulse)]
    return sorted({time for pulse in pulses for time in (pulse.start, pulse.stop)})


def kinks(line: Line, loads: Sequence[Load]) -> list[Event]:
    """Functions of time and state (arc length, rate, ...) that change sign at kinks of laws and joints of cams."""
    events: list[Event] = [_CamJoints(line)] if line.mechanism.cam_contacts else []
    for place, load in enumerate(load for load in loads if not load.conservative):
        if isinstance(load.law, StrokePulse):
            events += [_reaches(line, place, load.law.start), _reaches(line, place, load.law.stop), _turns(line, place)]
    return events


def _reaches(line: Line, place: int, value: float) -> Event:
    def event(_: float, state: Array) -> float:
        return float(line.at(float(state[0])).values[place]) - value

    return event


def _turns(line: Line, place: int) -> Event:
    def event(_: float, state: Array) -> float:
        return float(line.at(float(state[0])).rates[place]) * float(state[1])

    return event


class _CamJoints:
    """Where rollers pass from one arc of a cam, or segment of its law, to the next: there a derivative jumps.

    As a function of the state it is the distance from the nearest such place, with another sign behind each.
    """

    def __init__(self, line: Line) -> None:
        self._line = line
        self._known: tuple[int, int, bool] | None = None
        self._arcs: dict[int, tuple[Samples, dict[str, int]]] = {}
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
            arcs = [self._arcs_of(piece) for piece in pieces]
            self._joints = [
                piece.start
                for piece, before, after in zip(pieces[1:], arcs[:-1], arcs[1:], strict=True)
                if before != after
            ]
            if known.loop is not None and arcs and arcs[0] != arcs[-1]:
                self._joints.insert(0, pieces[0].start)
            self._known = key
        return self._joints

    def _arcs_of(self, piece: Samples) -> dict[str, int]:
        if id(piece) not in self._arcs:
            middle = piece.points[len(piece.points) // 2][None]
            self._arcs[id(piece)] = piece, self._line.configurations.curve.arcs(middle)
        return self._arcs[id(piece)][1]
