"""Bodies of a file: points, mass, inertia and centre of gravity."""

from __future__ import annotations

import math
from collections.abc import Mapping

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism import GROUND, Body, Point
from conrod.mechanism_files.fields import Fields
from conrod.mechanism_files.numbers import COORDINATE, INERTIA, LENGTH, MASS, SHOWN, shown
from conrod.mechanism_files.places import read_points

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
