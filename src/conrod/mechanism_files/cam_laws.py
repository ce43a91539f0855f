"""The profile of a file's cam that is made from a motion law."""

from __future__ import annotations

import math

from conrod.cam_law import TURN, LawProfile, Segment
from conrod.cam_shape import check_cut
from conrod.errors import InvalidInput
from conrod.mechanism_files.fields import Fields
from conrod.mechanism_files.numbers import ANGLE, COORDINATE, LENGTH, Measure, shown
from conrod.motion_laws import DWELL, LAWS

MOST_SEGMENTS = 100
SENSES = {"counter-clockwise": 1, "clockwise": -1}
# A motion is sampled every half degree where its joints are looked for.
SHORTEST = math.radians(1.0)
OVER = Measure("rad", SHORTEST, TURN)
# What written digits may leave: of a turn, and of the largest lift.
CLOSED = 1e-6


def read_law(fields: Fields, roller_radius: float) -> LawProfile:
    """The profile of a law, for a roller [m].

    Raises:
        InvalidInput: the segments do not close, or the roller would cut into the cam.
    """
    base = fields.number("base_radius", LENGTH, "base radius of the cam")
    offset = fields.number("offset", COORDINATE, "offset of the follower's line from the shaft, to the left of it", 0.0)
    begin = fields.number("begin", ANGLE, "direction in the cam's frame where its first segment begins", 0.0)
    sense = SENSES[fields.choice("sense", SENSES, "counter-clockwise")]
    segments = _segments(fields)
    try:
        profile = LawProfile(base, roller_radius, segments, begin, sense, offset)
        check_cut(profile)
    except InvalidInput as error:
        raise InvalidInput(f"{fields.place}: {error}") from None
    return profile


def _segments(fields: Fields) -> tuple[Segment, ...]:
    given, place = fields.raw("segments"), fields.at("segments")
    if not isinstance(given, list) or not 1 <= len(given) <= MOST_SEGMENTS:
        raise InvalidInput(f"{place} = {shown(given)}: a list of 1 to {MOST_SEGMENTS} segments is wanted")
    tables = [Fields(some, f"{place}[{k}]", fields.numbers) for k, some in enumerate(given)]
    laws = [some.choice("law", LAWS) for some in tables]
    overs = _closed(
        place, [_read(some, "over", OVER, "cam angle of a segment of the cam") for some in tables], "over", TURN
    )
    lifts = [
        0.0 if law == DWELL else _read(some, "lift", COORDINATE, "lift in a segment of the cam")
        for some, law in zip(tables, laws, strict=True)
    ]
    for some in tables:
        some.end()
    closed = _closed(place, lifts, "lift", 0.0)
    for k, over in enumerate(overs):
        if over < SHORTEST * (1.0 - CLOSED):
            raise InvalidInput(f"{place}[{k}].over is left with {math.degrees(over):.6g} deg: at least 1 deg is needed")
    return tuple(Segment(law, over, lift) for law, over, lift in zip(laws, overs, closed, strict=True))


def _read(fields: Fields, name: str, measure: Measure, meaning: str) -> float | None:
    """A number that may be left out."""
    fields.may_hold(name)
    return fields.number(name, measure, meaning) if name in fields else None


def _closed(place: str, given: list[float | None], name: str, whole: float) -> list[float]:
    """The numbers of all segments; the one that is left out, or the last that is none, takes what closes the cam."""
    missing = [k for k, some in enumerate(given) if some is None]
    if len(missing) > 1:
        raise InvalidInput(
            f"{place}: {name} is left out of {len(missing)} segments ({', '.join(map(str, missing))}, counted from 0); "
            "of one at most it follows from the others"
        )
    numbers = [some for some in given if some is not None]
    left = whole - math.fsum(numbers)
    if missing:
        return [left if some is None else some for some in given]
    if abs(left) > CLOSED * (whole or max(map(abs, numbers), default=0.0)):
        raise InvalidInput(f"{place}: {_sum_of(name, math.fsum(numbers))}; leave {name} out of one segment to close it")
    last = max((k for k, some in enumerate(numbers) if some != 0.0), default=0)
    return [some + left if k == last else some for k, some in enumerate(numbers)]


def _sum_of(name: str, total: float) -> str:
    if name == "over":
        return f"over adds up to {math.degrees(total):.9g} deg, and a cam's turn has 360 deg"
    return f"lift adds up to {total:.9g} m, and a closed cam comes back to 0"
