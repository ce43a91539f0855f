"""Joints of a file with the profiles of cams, and its driver with speed, sense and span."""

from __future__ import annotations

import math
from collections.abc import Callable

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.cam import DWELL, LAWS, CamProfile, Segment, symmetric_cam
from conrod.mechanism.cam_law import LawProfile, check_undercut
from conrod.mechanism.files.bodies import ORIGIN, BodyPoint, Places, check_two_bodies
from conrod.mechanism.files.fields import (
    ANGLE,
    COORDINATE,
    LENGTH,
    MAX_SHOWN_CHARACTERS,
    SENSES,
    SPEED,
    SPEED_NAME,
    Fields,
)
from conrod.mechanism.mechanism import GROUND, CamContact, Driver, Joint, Prismatic, Rack, Revolute, Rolling
from conrod.mechanism.units import REVOLUTION, Parameter

MAX_JOINTS, MAX_SEGMENTS = 200, 100
CAM_CLOSING_TOLERANCE = 1e-6  # of a full turn, and of the largest lift, for numbers with few digits
MIN_SEGMENT_ANGLE = math.radians(1.0)  # the ends of segments are searched for in steps of half a degree
SEGMENT_ANGLE = Parameter("rad", MIN_SEGMENT_ANGLE, REVOLUTION)


def read_joints(fields: Fields, places: Places) -> tuple[Joint, ...]:
    """Read all joints in alphabetical order; InvalidInput names what cannot be used."""
    tables = fields.named_tables("joints")
    if len(tables) > MAX_JOINTS:
        raise InvalidInput(f"there are {len(tables)} joints: at most {MAX_JOINTS} are read")
    joints = []
    for name, table in tables.items():
        joints.append(_JOINT_READERS[table.choice("kind", _JOINT_READERS)](table, name, places))
        table.refuse_unknown()
    return tuple(joints)


def _revolute(fields: Fields, name: str, places: Places) -> Revolute:
    """Read a pin between two bodies."""
    first, second = places.pair(fields, "connects")
    return Revolute(name, first.body, second.body, first.point, second.point)


def _prismatic(fields: Fields, name: str, places: Places) -> Prismatic:
    """Read a slide of one body along a line on another."""
    guide, direction = _line(fields, "guide", places)
    slider = places.field(fields, "slider")
    check_two_bodies(fields.place, guide, slider)
    angle = fields.number("angle", ANGLE, f"turn of {slider.body} against {guide.body}", 0.0)
    return Prismatic(name, guide.body, slider.body, guide.point, slider.point, direction, angle)


def _line(fields: Fields, name: str, places: Places) -> tuple[BodyPoint, float]:
    """Read a line on a body: one of its points, and a direction [rad]."""
    place = places.field(fields, name)
    return place, fields.number("direction", ANGLE, f"direction of the line on {place.body}")


def _gear(fields: Fields, name: str, places: Places) -> Rolling:
    """Read a pair of gears; either may be a ring gear."""
    first, second = places.pair(fields, "wheels")
    radii = fields.entries("radii", "the pitch radii of the two wheels are wanted")
    signed = [
        fields.numbers.take(f"{fields.place_of('radii')}.{k}", some, LENGTH, f"pitch radius of {wheel.body}")
        for k, (some, wheel) in enumerate(zip(radii, (first, second), strict=True))
    ]
    if "ring" in fields:
        ring = fields.choice("ring", (first.body, second.body))
        signed[(first.body, second.body).index(ring)] *= -1.0
    return Rolling(name, first.body, second.body, first.point, second.point, *signed)


def _rack(fields: Fields, name: str, places: Places) -> Rack:
    """Read a wheel that rolls on a rack."""
    wheel = places.field(fields, "wheel")
    line, direction = _line(fields, "rack", places)
    check_two_bodies(fields.place, wheel, line)
    radius = fields.number("radius", LENGTH, f"radius of {wheel.body}")
    return Rack(name, wheel.body, line.body, wheel.point, line.point, radius, direction)


def _cam(fields: Fields, name: str, places: Places) -> CamContact:
    """Read a cam and the roller that rests on it."""
    cam, roller = places.field(fields, "cam"), places.field(fields, "roller")
    check_two_bodies(fields.place, cam, roller)
    if cam.name != ORIGIN:
        raise InvalidInput(f"{fields.place_of('cam')}: name the body alone; the profile is given in its frame")
    radius = fields.number("roller_radius", LENGTH, f"radius of the roller on {roller.body}")
    inside = fields.table("profile")
    symmetric = inside.choice("kind", ("symmetric", "law")) == "symmetric"
    profile = _symmetric(inside) if symmetric else _law(inside, radius)
    inside.refuse_unknown()
    return CamContact(name, cam.body, roller.body, profile, roller.point, radius)


_JOINT_READERS: dict[str, Callable[[Fields, str, Places], Joint]] = {
    "revolute": _revolute,
    "prismatic": _prismatic,
    "gear": _gear,
    "rack": _rack,
    "cam": _cam,
}


def read_drive(fields: Fields, joints: tuple[Joint, ...]) -> tuple[Driver, float]:
    """Read the driver and the crank speed [rad/s]; raises InvalidInput as `read_joints`."""
    table = fields.table("driver")
    name = table.text("joint")
    joint = next((joint for joint in joints if joint.name == name), None)
    cranks = [joint.name for joint in joints if isinstance(joint, Revolute) and GROUND in (joint.a, joint.b)]
    if joint is None:
        raise unknown_choice(table.place_of("joint"), name[:MAX_SHOWN_CHARACTERS], cranks)
    if joint.name not in cranks:
        found = f"; here {', '.join(sorted(cranks))}" if cranks else ""
        raise InvalidInput(
            f"{table.place_of('joint')} = {name!r}: the crank's revolute joint with the ground is wanted{found}"
        )
    sense = SENSES[table.choice("sense", SENSES, "counter-clockwise")]
    meaning = "crank speed; negative is the other sense of rotation"
    speed = table.numbers.take(table.place_of("speed"), table.raw("speed"), SPEED, meaning, SPEED_NAME)
    start = table.number("start", ANGLE, "turn of the crank at crank angle 0", 0.0)
    span = None
    if "from" in table or "to" in table:
        span = (
            table.number("from", ANGLE, "crank angle at which the pass begins"),
            table.number("to", ANGLE, "crank angle at which the pass ends"),
        )
    table.refuse_unknown()
    return Driver(name, sense, start, span), speed


# -- cams --------------------------------------------------------------------------------------------------------------


def _symmetric(fields: Fields) -> CamProfile:
    """Read the profile of a symmetric cam of arcs."""
    base, flank, nose, distance = (
        fields.number(name, LENGTH, f"{name.replace('_', ' ')} of the cam")
        for name in ("base_radius", "flank_radius", "nose_radius", "centre_distance")
    )
    if not abs(base - nose) < distance:
        raise InvalidInput(
            f"{fields.place_of('centre_distance')} = {distance:g} m must be more than the difference of base_radius "
            f"and nose_radius, {abs(base - nose):g} m: one circle would lie inside the other"
        )
    least = 0.5 * (base + nose + distance)
    if flank < least:
        raise InvalidInput(
            f"{fields.place_of('flank_radius')} = {flank:g} m must be at least (base_radius + nose_radius + "
            f"centre_distance) / 2 = {least:g} m"
        )
    return symmetric_cam(base, flank, nose, distance)


def _law(fields: Fields, roller_radius: float) -> LawProfile:
    """Read the profile of a cam with a motion law."""
    base = fields.number("base_radius", LENGTH, "base radius of the cam")
    offset = fields.number("offset", COORDINATE, "offset of the follower's line from the shaft, to the left of it", 0.0)
    begin = fields.number("begin", ANGLE, "direction in the cam's frame where its first segment begins", 0.0)
    sense = SENSES[fields.choice("sense", SENSES, "counter-clockwise")]
    segments = _segments(fields)
    try:
        profile = LawProfile(base, roller_radius, segments, begin, sense, offset)
        check_undercut(profile)
    except InvalidInput as error:
        raise InvalidInput(f"{fields.place}: {error}") from None
    return profile


def _segments(fields: Fields) -> tuple[Segment, ...]:
    """Read the segments of a motion law, which close in angle and in lift."""
    place, tables = fields.place_of("segments"), fields.tables("segments", "segments", MAX_SEGMENTS)
    laws = [some.choice("law", LAWS) for some in tables]
    given = [some.optional_number("over", SEGMENT_ANGLE, "cam angle of a segment of the cam") for some in tables]
    overs = _close_segments(place, given, "over", REVOLUTION)
    given = [
        0.0 if law == DWELL else some.optional_number("lift", COORDINATE, "lift in a segment of the cam")
        for some, law in zip(tables, laws, strict=True)
    ]
    for some in tables:
        some.refuse_unknown()
    lifts = _close_segments(place, given, "lift", 0.0)
    for k, over in enumerate(overs):
        if over < MIN_SEGMENT_ANGLE * (1.0 - CAM_CLOSING_TOLERANCE):
            raise InvalidInput(f"{place}[{k}].over is left with {math.degrees(over):.6g} deg: at least 1 deg is needed")
    return tuple(Segment(law, over, lift) for law, over, lift in zip(laws, overs, lifts, strict=True))


def _close_segments(place: str, given: list[float | None], name: str, whole: float) -> list[float]:
    """Values of all segments, with the missing one, or the last that is not 0, chosen so that they close."""
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
    if abs(left) > CAM_CLOSING_TOLERANCE * (whole or max(map(abs, numbers), default=0.0)):
        found = f"{total:.9g} m, and a closed cam comes back to 0"
        if name == "over":
            found = f"{math.degrees(total):.9g} deg, and a cam's turn has 360 deg"
        raise InvalidInput(f"{place}: {name} adds up to {found}; leave {name} out of one segment to close it")
    last = max((k for k, some in enumerate(numbers) if some != 0.0), default=0)
    return [some + left if k == last else some for k, some in enumerate(numbers)]
