"""Named points of bodies, and what a file calls them: "crank.A", or "crank" for the origin of its frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.files.fields import Fields, one_line
from conrod.mechanism.files.numbers import COORDINATE, SHOWN, shown
from conrod.mechanism.mechanism import GROUND, Point

ORIGIN = "origin"  # what the point (0, 0) of every body is called
TURN = "turn"  # of a body at the start, beside the places of its points
RATE = "rate"  # of its turn, beside them
PAIR = 2


@dataclass(frozen=True)
class BodyPoint:
    """A point of a body."""

    body: str
    name: str
    point: Point  # [m], in the frame of the body


@dataclass(frozen=True)
class Places:
    """Points of all bodies, the ground among them, by name."""

    of_body: Mapping[str, Mapping[str, Point]]

    def found(self, place: str, given: object) -> BodyPoint:
        """The point that a text names.

        Raises:
            InvalidInput: there is none; names the nearest.
        """
        if not isinstance(given, str):
            raise InvalidInput(f'{place} = {shown(given)}: a point is wanted, as text: "body.point", or the body alone')
        text = one_line(place, given)
        body, dot, name = text.partition(".")
        if body not in self.of_body:
            raise unknown_choice(f"body in {place}", body[:SHOWN], self.of_body)
        points = {ORIGIN: (0.0, 0.0)} | dict(self.of_body[body])
        if not dot:
            return BodyPoint(body, ORIGIN, (0.0, 0.0))
        if name not in points:
            raise unknown_choice(f"point of {body} in {place}", name[:SHOWN], points)
        return BodyPoint(body, name, points[name])

    def field(self, fields: Fields, name: str) -> BodyPoint:
        """The point that a field names."""
        return self.found(fields.at(name), fields.raw(name))

    def pair(self, fields: Fields, name: str) -> tuple[BodyPoint, BodyPoint]:
        """The two points, of different bodies, that a field names.

        Raises:
            InvalidInput: they are not two, or a body is joined with itself.
        """
        given = fields.raw(name)
        if not isinstance(given, list) or len(given) != PAIR:
            raise InvalidInput(f"{fields.at(name)} = {shown(given)}: the points of two bodies are wanted")
        first, second = (self.found(f"{fields.at(name)}[{k}]", some) for k, some in enumerate(given))
        check_apart(fields.place, first, second)
        return first, second


def check_apart(joint: str, first: BodyPoint, second: BodyPoint) -> None:
    """Refuse a joint of a body with itself.

    Raises:
        InvalidInput: names the body.
    """
    if first.body == second.body:
        raise InvalidInput(f"{joint}: it joins {first.body!r} with itself; the points of two bodies are wanted")


def read_points(fields: Fields, body: str) -> dict[str, Point]:
    """The named points of a body [m].

    Raises:
        InvalidInput: a name that is taken for something else, or what is no point.
    """
    table = fields.table("points")
    points = {name: table.pair(name, COORDINATE, f"place of {name} on {body}") for name in table.names()}
    if TURN in points:
        raise InvalidInput(f"{table.at(TURN)}: {TURN!r} cannot be a point's name: [start] uses it for a body's turn")
    if RATE in points:
        raise InvalidInput(
            f"{table.at(RATE)}: {RATE!r} cannot be a point's name: [start] uses it for a body's turn rate"
        )
    if ORIGIN in points:
        raise InvalidInput(f"{table.at(ORIGIN)}: {ORIGIN!r} is the point [0, 0] of every body; leave it out")
    return points


def read_ground(fields: Fields) -> dict[str, Point]:
    """The points of the ground, in the document's frame [m]."""
    ground = fields.table(GROUND)
    points = read_points(ground, "the ground")
    ground.end()
    return points
