"""Cam profiles of a file: a symmetric one of arcs, or one from a motion law."""

from __future__ import annotations

import math

from conrod.errors import InvalidInput
from conrod.mechanism.cam import DWELL, LAWS, CamProfile, Segment, symmetric_cam
from conrod.mechanism.cam_law import TURN, LawProfile, Profile, check_cut
from conrod.mechanism.files.fields import ANGLE, COORDINATE, LENGTH, SENSES, Fields
from conrod.mechanism.units import Parameter

MOST_SEGMENTS = 100
# What written digits may leave of a turn, and of the largest lift.
CLOSED = 1e-6
# A motion is sampled every half degree where its joints are looked for.
SHORTEST = math.radians(1.0)
OVER = Parameter("rad", SHORTEST, TURN)


def read_profile(fields: Fields, roller_radius: float) -> Profile:
    """The profile of a cam, in the frame of its body, for a roller [m].

    Raises:
        InvalidInput: it is not closed, not convex, the roller would cut into it, or something cannot be used.
    """
    profile: Profile
    if fields.choice("kind", ("symmetric", "law")) == "symmetric":
        profile = _symmetric(fields)
    else:
        profile = _law(fields, roller_radius)
    fields.end()
    return profile


def _symmetric(fields: Fields) -> CamProfile:
    base, flank, nose, distance = (
        fields.number(name, LENGTH, f"{name.replace('_', ' ')} of the cam")
        for name in ("base_radius", "flank_radius", "nose_radius", "centre_distance")
    )
    if not abs(base - nose) < distance:
        raise InvalidInput(
            f"{fields.at('centre_distance')} = {distance:g} m must be more than the difference of base_radius and "
            f"nose_radius, {abs(base - nose):g} m: one circle would lie inside the other"
        )
    least = 0.5 * (base + nose + distance)
    if flank < least:
        raise InvalidInput(
            f"{fields.at('flank_radius')} = {flank:g} m must be at least (base_radius + nose_radius + "
            f"centre_distance) / 2 = {least:g} m"
        )
    return symmetric_cam(base, flank, nose, distance)


def _law(fields: Fields, roller_radius: float) -> LawProfile:
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
    place, tables = fields.at("segments"), fields.tables("segments", "segments", MOST_SEGMENTS)
    laws = [some.choice("law", LAWS) for some in tables]
    given = [some.optional("over", OVER, "cam angle of a segment of the cam") for some in tables]
    overs = _closed(place, given, "over", TURN)
    given = [
        0.0 if law == DWELL else some.optional("lift", COORDINATE, "lift in a segment of the cam")
        for some, law in zip(tables, laws, strict=True)
    ]
    for some in tables:
        some.end()
    lifts = _closed(place, given, "lift", 0.0)
    for k, over in enumerate(overs):
        if over < SHORTEST * (1.0 - CLOSED):
            raise InvalidInput(f"{place}[{k}].over is left with {math.degrees(over):.6g} deg: at least 1 deg is needed")
    return tuple(Segment(law, over, lift) for law, over, lift in zip(laws, overs, lifts, strict=True))


def _closed(place: str, given: list[float | None], name: str, whole: float) -> list[float]:
    """The numbers of all segments; the one that is left out, or the last that is not 0, takes what closes the cam."""
    missing = [k for k, some in enumerate(given) if some is None]
    if len(missing) > 1:
        raise InvalidInput(
            f"{place}: {name} is left out of {len(missing)} segments ({', '.join(map(str, missing))}, counted from 0); "
            "of one at most it follows from the others"
        )
    numbers = [some for some in given if some is not None]
    total = math.fsum(numbers)
    left = whole - total
    if missing:
        return [left if some is None else some for some in given]
    if abs(left) > CLOSED * (whole or max(map(abs, numbers), default=0.0)):
        found = f"{total:.9g} m, and a closed cam comes back to 0"
        if name == "over":
            found = f"{math.degrees(total):.9g} deg, and a cam's turn has 360 deg"
        raise InvalidInput(f"{place}: {name} adds up to {found}; leave {name} out of one segment to close it")
    last = max((k for k, some in enumerate(numbers) if some != 0.0), default=0)
    return [some + left if k == last else some for k, some in enumerate(numbers)]
