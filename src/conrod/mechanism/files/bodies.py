"""Bodies of a file, and the order in which bodies and joints are taken, whatever their order in the file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.files.fields import Fields
from conrod.mechanism.files.numbers import COORDINATE, INERTIA, LENGTH, MASS, SHOWN, shown
from conrod.mechanism.files.places import read_points
from conrod.mechanism.mechanism import GROUND, Body, Driver, HigherPair, Joint, Point, Revolute

MOST_BODIES = 100
ENDS = 2
OWN_INERTIA = ("inertia", "centre_of_gravity")


def read_bodies(fields: Fields) -> tuple[tuple[Body, ...], dict[str, Mapping[str, Point]]]:
    """All bodies by name, and their points.

    Raises:
        InvalidInput: names what cannot be used.
    """
    table = fields.table("bodies")
    names = table.names()
    if not names:
        raise InvalidInput("there are no bodies: give a table [bodies.NAME] for each moving link")
    if len(names) > MOST_BODIES:
        raise InvalidInput(f"there are {len(names)} bodies: at most {MOST_BODIES} are read")
    if GROUND in names:
        raise InvalidInput(f"bodies.{GROUND}: the ground does not move; its points stand in [ground]")
    read = {name: _read_body(table.table(name), name) for name in names}
    return tuple(body for body, _ in read.values()), {name: points for name, (_, points) in read.items()}


def _read_body(fields: Fields, name: str) -> tuple[Body, dict[str, Point]]:
    points = read_points(fields, name)
    mass = fields.number("mass", MASS, f"mass of {name}")
    if "uniform" not in fields:
        inertia = fields.number("inertia", INERTIA, f"inertia of {name} about its centre of gravity")
        centre = fields.pair("centre_of_gravity", COORDINATE, f"centre of gravity of {name}", (0.0, 0.0))
    else:
        kind = fields.choice("uniform", ("bar", "disc"))
        for own in OWN_INERTIA:
            if own in fields and not (kind == "disc" and own == "centre_of_gravity"):
                raise InvalidInput(f"{fields.at(own)}: a uniform {kind} has its own; leave out one of the two")
        if kind == "bar":
            start, stop = (points[end] for end in _ends(fields, points))
            centre = (0.5 * (start[0] + stop[0]), 0.5 * (start[1] + stop[1]))
            inertia = mass * math.dist(start, stop) ** 2 / 12.0
        else:
            radius = fields.number("radius", LENGTH, f"radius of the uniform disc {name}")
            centre = fields.pair("centre_of_gravity", COORDINATE, f"centre of the uniform disc {name}", (0.0, 0.0))
            inertia = 0.5 * mass * radius**2
        if inertia < INERTIA.lowest:
            raise InvalidInput(
                f"{fields.place}: the inertia of this uniform {kind} is {inertia:.3g} kg m^2: at least "
                f"{INERTIA.lowest:g} is wanted"
            )
    fields.end()
    return Body(name, mass, inertia, centre), points


def _ends(fields: Fields, points: Mapping[str, Point]) -> tuple[str, str]:
    """The two points between which a bar lies: those named, or its only ones."""
    if "ends" not in fields:
        if len(points) != ENDS:
            raise InvalidInput(
                f"{fields.place}: a uniform bar with {len(points)} points needs ends, its two end points by name"
            )
        first, second = points
        given = [first, second]
    else:
        given = fields.raw("ends")
        if not isinstance(given, list) or len(given) != ENDS or not all(isinstance(end, str) for end in given):
            raise InvalidInput(f"{fields.at('ends')} = {shown(given)}: the names of two points are wanted")
        for end in given:
            if end not in points:
                raise unknown_choice(f"point in {fields.at('ends')}", end[:SHOWN], points)
    if math.dist(points[given[0]], points[given[1]]) < LENGTH.lowest:
        raise InvalidInput(f"{fields.place}: the ends of the uniform bar are one and the same place")
    return given[0], given[1]


@dataclass(frozen=True)
class Structure:
    """Bodies and joints in the order in which motion reaches them from the crank."""

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]


def ordered(bodies: tuple[Body, ...], joints: tuple[Joint, ...], driver: Driver) -> Structure:
    """Bodies as a search in breadth from the crank finds them, and each body's joints with it; ties by name.

    Engines solve joints one after the other, and results depend on the order where they stop early: so that of a file
    must not count, and this one follows the motion. A pin's body `a` is the one that is reached first.

    Raises:
        InvalidInput: a body has no joint, or its mobility is not one.
    """
    _check_joined(bodies, joints)
    _check_mobility(bodies, joints)
    by_name = sorted(joints, key=lambda joint: (joint.name != driver.joint, joint.name))
    crank = next(body for joint in by_name[:1] for body in (joint.a, joint.b) if body != GROUND)
    reached, taken = [crank], []
    for body in reached:
        here = [joint for joint in by_name if body in (joint.a, joint.b) and joint not in taken]
        taken += here
        reached += _new(here, reached)
    loose = sorted({body.name for body in bodies} - set(reached))
    if loose:
        raise InvalidInput(
            f"bodies.{loose[0]}: no chain of joints leads to it from the crank {crank!r}: it would not move"
        )
    known = {body.name: body for body in bodies}
    place = {name: k for k, name in enumerate([GROUND, *reached])}
    return Structure(tuple(known[name] for name in reached), tuple(_turned(joint, place) for joint in taken))


def _new(joints: list[Joint], reached: list[str]) -> list[str]:
    found = {body: None for joint in joints for body in (joint.a, joint.b) if body != GROUND and body not in reached}
    return list(found)


def _turned(joint: Joint, place: dict[str, int]) -> Joint:
    if isinstance(joint, Revolute) and place[joint.a] > place[joint.b]:
        return replace(joint, a=joint.b, b=joint.a, point_a=joint.point_b, point_b=joint.point_a)
    return joint


def _check_joined(bodies: tuple[Body, ...], joints: tuple[Joint, ...]) -> None:
    joined = {body for joint in joints for body in (joint.a, joint.b)}
    for body in bodies:
        if body.name not in joined:
            raise InvalidInput(f"bodies.{body.name}: no joint holds it")


def _check_mobility(bodies: tuple[Body, ...], joints: tuple[Joint, ...]) -> None:
    higher = sum(isinstance(joint, HigherPair) for joint in joints)
    lower = len(joints) - higher
    mobility = 3 * len(bodies) - 2 * lower - higher
    if mobility == 1:
        return
    count = f"mobility {mobility}: 3 x {len(bodies)} moving bodies - 2 x {lower} lower - {higher} higher pairs"
    if mobility > 1:
        raise InvalidInput(f"{count}; one driven crank needs exactly 1: more joints, or fewer bodies, are wanted")
    raise InvalidInput(
        f"{count}; it cannot move, or only because of special lengths, which is not supported: exactly 1 is needed"
    )
