"""The driver of a file: which joint, which way, how fast, and whether it turns or makes one pass."""

from __future__ import annotations

import math

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism import GROUND, Driver, Joint, Revolute
from conrod.mechanism_files.fields import Fields
from conrod.mechanism_files.numbers import ANGLE, SHOWN, SPEED

SENSES = {"counter-clockwise": 1, "clockwise": -1}
SPEED_PARAMETER = "speed"  # what all scenes call it; in the file it stands at driver.speed


def read_drive(fields: Fields, joints: tuple[Joint, ...]) -> tuple[Driver, float]:
    """The driver, and the crank speed [rad/s].

    Raises:
        InvalidInput: names what cannot be used.
    """
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
    speed = table.numbers.take(table.at("speed"), table.raw("speed"), SPEED, meaning, SPEED_PARAMETER)
    start = table.number("start", ANGLE, "turn of the crank at crank angle 0", 0.0)
    span = None
    if "from" in table or "to" in table:
        span = (
            table.number("from", ANGLE, "crank angle at which the pass begins"),
            table.number("to", ANGLE, "crank angle at which the pass ends"),
        )
        if not span[0] <= 0.0 <= span[1] or span[0] == span[1]:
            first, last = (math.degrees(end) for end in span)
            raise InvalidInput(
                f"{table.place}: from = {first:.6g} deg, to = {last:.6g} deg: from must be less than to, with the "
                "crank angle 0, where the start poses are, between them"
            )
    table.end()
    return Driver(name, sense, start, span), speed
