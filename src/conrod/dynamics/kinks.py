"""Where the laws of loads have kinks: an integrator of high order begins anew there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from conrod.dynamics.integration import Event
from conrod.dynamics.line import Line
from conrod.loads import Load, StrokePulse, TimePulse
from conrod.motion import Array


def breaks(loads: Iterable[Load]) -> list[float]:
    """Times [s] at which laws have kinks."""
    pulses = [load.law for load in loads if isinstance(load.law, TimePulse)]
    return sorted({time for pulse in pulses for time in (pulse.start, pulse.stop)})


def kinks(line: Line, loads: Sequence[Load]) -> list[Event]:
    """Functions of time and state (arc length, rate, ...) that change sign at kinks of laws."""
    events: list[Event] = []
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
