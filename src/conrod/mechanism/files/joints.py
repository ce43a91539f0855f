"""Joints of a file, and its driver: which joint, which way, how fast, and whether it turns or makes one pass."""

from __future__ import annotations

from collections.abc import Callable

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.files.bodies import ORIGIN, BodyPoint, Places, check_apart
from conrod.mechanism.files.cams import read_profile
from conrod.mechanism.files.fields import ANGLE, LENGTH, SENSES, SHOWN, SPEED, SPEED_NAME, Fields
from conrod.mechanism.mechanism import GROUND, CamContact, Driver, Joint, Prismatic, Rack, Revolute, Rolling

MOST_JOINTS = 200


def read_joints(fields: Fields, places: Places) -> tuple[Joint, ...]:
    """All joints in alphabetical order.

    Raises:
        InvalidInput: names what cannot be used.
    """
    tables = fields.named("joints")
    if len(tables) > MOST_JOINTS:
        raise InvalidInput(f"there are {len(tables)} joints: at most {MOST_JOINTS} are read")
    joints = []
    for name, table in tables.items():
        joints.append(_READERS[table.choice("kind", _READERS)](table, name, places))
        table.end()
    return tuple(joints)


def _revolute(fields: Fields, name: str, places: Places) -> Revolute:
    first, second = places.pair(fields, "connects")
    return Revolute(name, first.body, second.body, first.point, second.point)


def _prismatic(fields: Fields, name: str, places: Places) -> Prismatic:
    guide, direction = _line(fields, "guide", places)
    slider = places.field(fields, "slider")
    check_apart(fields.place, guide, slider)
    angle = fields.number("angle", ANGLE, f"turn of {slider.body} against {guide.body}", 0.0)
    return Prismatic(name, guide.body, slider.body, guide.point, slider.point, direction, angle)


def _line(fields: Fields, name: str, places: Places) -> tuple[BodyPoint, float]:
    """A line on a body: a point of it and a direction."""
    place = places.field(fields, name)
    return place, fields.number("direction", ANGLE, f"direction of the line on {place.body}")


def _gear(fields: Fields, name: str, places: Places) -> Rolling:
    first, second = places.pair(fields, "wheels")
    radii = fields.listed("radii", "the pitch radii of the two wheels are wanted")
    signed = [
        fields.numbers.take(f"{fields.at('radii')}.{k}", some, LENGTH, f"pitch radius of {wheel.body}")
        for k, (some, wheel) in enumerate(zip(radii, (first, second), strict=True))
    ]
    if "ring" in fields:
        ring = fields.choice("ring", (first.body, second.body))
        signed[(first.body, second.body).index(ring)] *= -1.0
    return Rolling(name, first.body, second.body, first.point, second.point, *signed)


def _rack(fields: Fields, name: str, places: Places) -> Rack:
    wheel = places.field(fields, "wheel")
    line, direction = _line(fields, "rack", places)
    check_apart(fields.place, wheel, line)
    radius = fields.number("radius", LENGTH, f"radius of {wheel.body}")
    return Rack(name, wheel.body, line.body, wheel.point, line.point, radius, direction)


def _cam(fields: Fields, name: str, places: Places) -> CamContact:
    cam, roller = places.field(fields, "cam"), places.field(fields, "roller")
    check_apart(fields.place, cam, roller)
    if cam.name != ORIGIN:
        raise InvalidInput(f"{fields.at('cam')}: name the body alone; the profile is given in its frame")
    radius = fields.number("roller_radius", LENGTH, f"radius of the roller on {roller.body}")
    profile = read_profile(fields.table("profile"), radius)
    return CamContact(name, cam.body, roller.body, profile, roller.point, radius)


_READERS: dict[str, Callable[[Fields, str, Places], Joint]] = {
    "revolute": _revolute,
    "prismatic": _prismatic,
    "gear": _gear,
    "rack": _rack,
    "cam": _cam,
}


def read_drive(fields: Fields, joints: tuple[Joint, ...]) -> tuple[Driver, float]:
    """The driver, and the crank speed [rad/s]; raises InvalidInput as `read_joints`."""
    table = fields.table("driver")
    name = table.text("joint")
    joint = next((joint for joint in joints if joint.name == name), None)
    cranks = [joint.name for joint in joints if isinstance(joint, Revolute) and GROUND in (joint.a, joint.b)]
    if joint is None:
        raise unknown_choice(table.at("joint"), name[:SHOWN], cranks)
    if joint.name not in cranks:
        found = f"; here {', '.join(sorted(cranks))}" if cranks else ""
        raise InvalidInput(
            f"{table.at('joint')} = {name!r}: the crank's revolute joint with the ground is wanted{found}"
        )
    sense = SENSES[table.choice("sense", SENSES, "counter-clockwise")]
    meaning = "crank speed; negative is the other sense of rotation"
    speed = table.numbers.take(table.at("speed"), table.raw("speed"), SPEED, meaning, SPEED_NAME)
    start = table.number("start", ANGLE, "turn of the crank at crank angle 0", 0.0)
    span = None
    if "from" in table or "to" in table:
        span = (
            table.number("from", ANGLE, "crank angle at which the pass begins"),
            table.number("to", ANGLE, "crank angle at which the pass ends"),
        )
    table.end()
    return Driver(name, sense, start, span), speed
