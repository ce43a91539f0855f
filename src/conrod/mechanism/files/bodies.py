"""Bodies of a file and their named points: "crank.A", or "crank" for the origin of its frame."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.files.fields import COORDINATE, LENGTH, MAX_SHOWN_CHARACTERS, Fields, describe_value, one_line
from conrod.mechanism.mechanism import GROUND, Body, Point
from conrod.mechanism.units import Parameter

MASS = Parameter("kg", 1e-9, 1e12)
INERTIA = Parameter("kg*m^2", 1e-14, 1e24)  # MuJoCo compiles no body of less than 1e-15
MAX_BODIES = 100
ORIGIN = "origin"  # name of the point (0, 0) of every body
TURN_KEY, RATE_KEY = "turn", "rate"  # fields of a body in [start]
# Names that points cannot have, with the reason.
RESERVED_NAMES = {
    TURN_KEY: "cannot be a point's name: [start] uses it for a body's turn",
    RATE_KEY: "cannot be a point's name: [start] uses it for a body's turn rate",
    ORIGIN: "is the point [0, 0] of every body; leave it out",
}


@dataclass(frozen=True)
class BodyPoint:
    """A named point of a body."""

    body: str
    name: str
    point: Point  # [m], in the frame of the body


@dataclass(frozen=True)
class Places:
    """Named points of all bodies and of the ground."""

    of_body: Mapping[str, Mapping[str, Point]]

    def find_point(self, place: str, given: object) -> BodyPoint:
        """Look up the point that a text names; InvalidInput suggests the nearest name."""
        if not isinstance(given, str):
            raise InvalidInput(
                f'{place} = {describe_value(given)}: a point is wanted, as text: "body.point", or the body alone'
            )
        body, dot, name = one_line(place, given).partition(".")
        if body not in self.of_body:
            raise unknown_choice(f"body in {place}", body[:MAX_SHOWN_CHARACTERS], self.of_body)
        points = {ORIGIN: (0.0, 0.0)} | dict(self.of_body[body])
        name = name if dot else ORIGIN
        if name not in points:
            raise unknown_choice(f"point of {body} in {place}", name[:MAX_SHOWN_CHARACTERS], points)
        return BodyPoint(body, name, points[name])

    def field(self, fields: Fields, name: str) -> BodyPoint:
        """Look up the point that a field names."""
        return self.find_point(fields.place_of(name), fields.raw(name))

    def pair(self, fields: Fields, name: str) -> tuple[BodyPoint, BodyPoint]:
        """Look up the two points, of different bodies, that a field names."""
        given = fields.entries(name, "the points of two bodies are wanted")
        first, second = (self.find_point(f"{fields.place_of(name)}[{k}]", some) for k, some in enumerate(given))
        check_two_bodies(fields.place, first, second)
        return first, second


def check_two_bodies(joint: str, first: BodyPoint, second: BodyPoint) -> None:
    """Refuse a joint that connects a body with itself; raises InvalidInput."""
    if first.body == second.body:
        raise InvalidInput(f"{joint}: it joins {first.body!r} with itself; the points of two bodies are wanted")


def read_points(fields: Fields, body: str) -> dict[str, Point]:
    """Read the points of a body, or of the ground, in its frame [m]."""
    table = fields.table("points")
    points = {name: table.pair(name, COORDINATE, f"place of {name} on {body}") for name in table.names()}
    for name, why in RESERVED_NAMES.items():
        if name in points:
            raise InvalidInput(f"{table.place_of(name)}: {name!r} {why}")
    return points


def read_bodies(fields: Fields) -> tuple[tuple[Body, ...], dict[str, Mapping[str, Point]]]:
    """All bodies by name, and their points; raises InvalidInput, which names what cannot be used."""
    tables = fields.named_tables("bodies")
    if not tables:
        raise InvalidInput("there are no bodies: give a table [bodies.NAME] for each moving link")
    if len(tables) > MAX_BODIES:
        raise InvalidInput(f"there are {len(tables)} bodies: at most {MAX_BODIES} are read")
    if GROUND in tables:
        raise InvalidInput(f"bodies.{GROUND}: the ground does not move; its points stand in [ground]")
    read = {name: _read_body(table, name) for name, table in tables.items()}
    return tuple(body for body, _ in read.values()), {name: points for name, (_, points) in read.items()}


def _read_body(fields: Fields, name: str) -> tuple[Body, dict[str, Point]]:
    """Read mass, inertia, centre of gravity and points of a body."""
    points = read_points(fields, name)
    mass = fields.number("mass", MASS, f"mass of {name}")
    if "uniform" not in fields:
        inertia = fields.number("inertia", INERTIA, f"inertia of {name} about its centre of gravity")
        centre = fields.pair("centre_of_gravity", COORDINATE, f"centre of gravity of {name}", (0.0, 0.0))
    else:
        kind = fields.choice("uniform", ("bar", "disc"))
        for own in ("inertia", "centre_of_gravity") if kind == "bar" else ("inertia",):
            if own in fields:
                raise InvalidInput(f"{fields.place_of(own)}: a uniform {kind} has its own; leave out one of the two")
        if kind == "bar":
            start, stop = (points[end] for end in _bar_ends(fields, points))
            centre = (0.5 * (start[0] + stop[0]), 0.5 * (start[1] + stop[1]))
            inertia = mass * math.dist(start, stop) ** 2 / 12.0
        else:
            radius = fields.number("radius", LENGTH, f"radius of the uniform disc {name}")
            centre = fields.pair("centre_of_gravity", COORDINATE, f"centre of the uniform disc {name}", (0.0, 0.0))
            inertia = 0.5 * mass * radius**2
        if inertia < INERTIA.lowest:
            raise InvalidInput(
                f"{fields.place}: the inertia of this uniform {kind} is {inertia:.3g} kg m²: at least "
                f"{INERTIA.lowest:g} is wanted"
            )
    fields.refuse_unknown()
    return Body(name, mass, inertia, centre), points


def _bar_ends(fields: Fields, points: Mapping[str, Point]) -> list[str]:
    """The two end points of a bar: those named, or its only ones."""
    if "ends" in fields:
        ends = fields.entries("ends", "the names of two points are wanted", kind=str)
        for end in ends:
            if end not in points:
                raise unknown_choice(f"point in {fields.place_of('ends')}", end[:MAX_SHOWN_CHARACTERS], points)
    elif len(points) == 2:
        ends = list(points)
    else:
        shown = ", ".join(points)[:MAX_SHOWN_CHARACTERS]
        if len(points) > 2:
            first, second, *_ = points
            missing = f'which of {shown} are its ends is not said: give for instance ends = ["{first}", "{second}"]'
        else:
            missing = f"{shown or 'none'} alone is given: add its other end to points, such as O = [0, 0]"
        raise InvalidInput(f"{fields.place}: a uniform bar lies between two points; {missing}")
    if math.dist(points[ends[0]], points[ends[1]]) < LENGTH.lowest:
        raise InvalidInput(f"{fields.place}: the ends of the uniform bar are one and the same place")
    return ends
