"""Follower float in numbers: where it begins, and its flights beside the exact ones."""

from __future__ import annotations

import math
from collections.abc import Sequence

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.tables import paragraphs, table
from conrod.studies.limits.float_results import WITHIN, ComparedFlight, FollowerFloat

ONSETS = ["engine", "preset", "steps per revolution", "penetration (mm)", "onset / theory", "off"]
ONSETS += ["seen by the exact flight from", "told by a flight's length", ""]
FLIGHTS = ["engine", "preset", "speed / float speed", "steps per revolution", "ended", "exact gap (mm)"]
FLIGHTS += ["measured, off by", "exact landing (deg)", "measured minus exact"]
RPM = 30.0 / math.pi


def float_table(floats: Sequence[FollowerFloat]) -> str:
    """Onsets, and below them the flights; nothing where there is none."""
    theory = next((found.theory for found in floats if found.theory is not None), None)
    if theory is None:
        return ""
    flights = [[*_who(found), *_flight(flight)] for found in floats for flight in found.flights]
    return paragraphs(
        f"Theory: {numbers.quantity(theory * RPM)} rpm.",
        table(ONSETS, [[*_who(found), *_onset(found)] for found in floats if not found.refusal]),
        table(FLIGHTS, flights),
    )


def _who(found: FollowerFloat) -> list[str]:
    return [engine_title(found.engine), found.preset]


def _onset(found: FollowerFloat) -> list[str]:
    return [
        ", ".join(str(steps) for steps in found.steps_per_revolution),
        numbers.MISSING if found.penetration is None else numbers.measured(1e3 * found.penetration),
        _ratio(found.onset),
        _share(None if found.onset is None else found.onset - 1.0),
        _ratio(found.visible),
        _ratio(found.from_length),
        _verdict(found),
    ]


def _verdict(found: FollowerFloat) -> str:
    if found.onset is not None and abs(found.onset - 1.0) <= WITHIN:
        return f"within {100 * WITHIN:g} %"
    if not found.fit:
        return f"too soft: {100 * WITHIN:g} % above the onset the exact flight is lower than ten penetrations"
    return f"**not within {100 * WITHIN:g} %**"


def _flight(flight: ComparedFlight) -> list[str]:
    exact = flight.exact
    return [
        numbers.quantity(flight.speed),
        str(flight.steps_per_revolution),
        flight.outcome,
        numbers.MISSING if exact is None else numbers.quantity(1e3 * exact.gap),
        _share(flight.gap_error),
        numbers.MISSING if exact is None else f"{math.degrees(exact.landing):.2f}",
        numbers.MISSING if flight.landing_error is None else f"{math.degrees(flight.landing_error):+.3f} deg",
    ]


def _ratio(value: float | None) -> str:
    return numbers.MISSING if value is None else f"{value:.4f}"


def _share(value: float | None) -> str:
    return numbers.MISSING if value is None else f"{100.0 * value:+.2f} %"
