"""Start poses of all bodies, from what a file says of some of them.

The driver gives the crank's turn, a slide the turn of the one body against the other, a pin between a placed body and
another one a place on that; two places, or one and the turn, place a body. What is still open is what [start] must
give. All of it is approximate: the assembly is then found by Newton iteration.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from conrod.errors import InvalidInput
from conrod.mechanism.files.bodies import Structure
from conrod.mechanism.files.fields import Fields
from conrod.mechanism.files.numbers import ANGLE, COORDINATE, LENGTH, Measure
from conrod.mechanism.files.places import ORIGIN, RATE, TURN, Places
from conrod.mechanism.mechanism import GROUND, Driver, Joint, Point, Pose, Prismatic, Revolute, to_world
from conrod.mechanism.rolling import Rack, Rolling


def fitted(joint: Joint, poses: Mapping[str, Pose]) -> Joint:
    """A joint that rolls, with the offset that start poses leave; any other one as it is.

    Raises:
        InvalidInput: there is no line of centres to count turns against.
    """
    if not isinstance(joint, Rolling | Rack):
        return joint
    a, b = (poses.get(body, (0.0, 0.0, 0.0)) for body in (joint.a, joint.b))
    (ax, ay), (bx, by) = to_world(a, joint.point_a), to_world(b, joint.point_b)
    if isinstance(joint, Rolling):
        if math.dist((ax, ay), (bx, by)) < LENGTH.lowest:
            raise InvalidInput(f"joints.{joint.name}: the two centres are one and the same place at the start")
        alpha = math.atan2(by - ay, bx - ax)
        return replace(joint, offset=joint.radius_a * (a[2] - alpha) + joint.radius_b * (b[2] - alpha))
    direction = b[2] + joint.direction
    way = (ax - bx) * math.cos(direction) + (ay - by) * math.sin(direction)
    return replace(joint, offset=way + joint.radius * (a[2] - b[2]))


# Two places give a body's turn if they are this far apart, of the larger distance from its origin.
APART = 1e-6
TURN_RATE = Measure("rad/s", 0.0, 1e6, magnitude=True)


@dataclass(frozen=True)
class Hint:
    """Approximate position of a body at crank angle 0, as a file gives it.

    Attributes:
        turn: [rad].
        places: pairs of a point of the body, in its frame, and where that is in the document's frame [m].
        rate: exactly, of its turn where nothing drives the crank [rad/s], counter-clockwise.
    """

    turn: float | None = None
    places: tuple[tuple[Point, Point], ...] = ()
    rate: float | None = None

    @property
    def tells_pose(self) -> bool:
        """True of a hint that says more than a rate."""
        return self.turn is not None or bool(self.places)


def rates_of(hints: Mapping[str, Hint]) -> dict[str, float]:
    """The turn rates [rad/s] that a file gives, by body."""
    return {name: hint.rate for name, hint in hints.items() if hint.rate is not None}


def read_start(fields: Fields, places: Places, crank: str) -> dict[str, Hint]:
    """The start poses that a file gives, by body.

    Raises:
        InvalidInput: of an unknown body or point, or of the crank.
    """
    table = fields.table("start")
    hints = {}
    for name in table.names():
        inside = table.table(name)
        places.found(table.at(name), name)
        if name == GROUND or (name == crank and set(inside.names()) - {RATE}):
            reason = "it does not move" if name == GROUND else "driver.start tells its turn"
            also = "" if name == GROUND or RATE not in inside else f" but for its {RATE}"
            raise InvalidInput(f"{inside.place}: leave it out{also}: {reason}")
        known = {}
        for point in inside.names():
            if point not in (TURN, RATE):
                place = places.found(inside.place, f"{name}.{point}")
                known[point] = (
                    place.point,
                    inside.pair(point, COORDINATE, f"about where {point} of {name} is at the start"),
                )
        turn = inside.number(TURN, ANGLE, f"about the turn of {name} at the start") if TURN in inside else None
        rate = None
        if RATE in inside:
            rate = inside.number(RATE, TURN_RATE, f"turn rate of {name} where a motion without a drive starts")
        hints[name] = Hint(turn, tuple(known.values()), rate)
    return hints


def placed(structure: Structure, driver: Driver, hints: Mapping[str, Hint]) -> dict[str, Pose]:
    """Approximate poses of all bodies.

    Raises:
        InvalidInput: names the first body whose pose does not follow.
    """
    search = _Search(structure.joints, hints, {GROUND: (0.0, 0.0, 0.0)})
    crank = next(b for j in structure.joints if j.name == driver.joint for b in (j.a, j.b) if b != GROUND)
    search.turns[crank] = driver.start
    names = [body.name for body in structure.bodies]
    # What is given exactly goes before what has to be supposed.
    while open_ones := [name for name in names if name not in search.poses]:
        if not any(attempt(name) for attempt in (search.place, search.suppose) for name in open_ones):
            raise InvalidInput(search.missing(open_ones))
    return {name: search.poses[name] for name in names}


class _Search:
    """Bodies placed so far."""

    def __init__(self, joints: tuple[Joint, ...], hints: Mapping[str, Hint], poses: dict[str, Pose]) -> None:
        self._joints, self._hints, self.poses = joints, hints, poses
        self.turns: dict[str, float] = {name: hint.turn for name, hint in hints.items() if hint.turn is not None}

    def missing(self, bodies: list[str]) -> str:
        """Message on bodies that could not be placed."""
        first = f"start.{bodies[0]}"
        give = f"where about one of its points is, as in {first}.{ORIGIN} = [0, 0]"
        if self._turn(bodies[0]) is None:
            give = f"{first}.{TURN}, or {give}"
        others = f", or the same of {', '.join(bodies[1:])}" if bodies[1:] else ""
        return f"{first}: where it is at crank angle 0 does not follow from the other bodies: give {give}{others}"

    def place(self, body: str) -> bool:
        """Place a body by what is known; false where that is not enough."""
        known = [*self._hints.get(body, Hint()).places, *self._pins(body)]
        turn = self._turn(body)
        if turn is None:
            turn = _turn_between(known)
        if turn is None or not known:
            return False
        away = [to_world((0.0, 0.0, turn), local) for local, _ in known]
        x = sum(there[0] - off[0] for (_, there), off in zip(known, away, strict=True)) / len(known)
        y = sum(there[1] - off[1] for (_, there), off in zip(known, away, strict=True)) / len(known)
        self.poses[body] = (x, y, turn)
        return True

    def suppose(self, body: str) -> bool:
        """Place a body that rolls with its turn 0, or one that only slides at its guide's own point."""
        known = [*self._hints.get(body, Hint()).places, *self._pins(body)]
        if known and any(isinstance(joint, Rolling | Rack) and body in (joint.a, joint.b) for joint in self._joints):
            self.turns[body] = 0.0
            return self.place(body)
        turn, slides = self._turn(body), self._slides(body)
        if len(slides) < sum(body in (joint.a, joint.b) for joint in self._joints):
            return False  # what else joins it has a say in where it stands, and may have two places for it
        for joint in slides:
            other = joint.a if joint.b == body else joint.b
            if turn is not None and other in self.poses:
                there, local = (joint.point_a, joint.point_b) if joint.b == body else (joint.point_b, joint.point_a)
                place, off = to_world(self.poses[other], there), to_world((0.0, 0.0, turn), local)
                self.poses[body] = (place[0] - off[0], place[1] - off[1], turn)
                return True
        return False

    def _turn(self, body: str) -> float | None:
        for joint in self._slides(body):
            if joint.b == body and joint.a in self.poses:
                return self.poses[joint.a][2] + joint.angle
            if joint.a == body and joint.b in self.poses:
                return self.poses[joint.b][2] - joint.angle
        return self.turns.get(body)

    def _slides(self, body: str) -> list[Prismatic]:
        return [j for j in self._joints if isinstance(j, Prismatic) and body in (j.a, j.b)]

    def _pins(self, body: str) -> list[tuple[Point, Point]]:
        """Points of a body that a pin holds at a placed one, and where they are."""
        pins = []
        for joint in self._joints:
            if isinstance(joint, Revolute):
                if joint.b == body and joint.a in self.poses:
                    pins.append((joint.point_b, to_world(self.poses[joint.a], joint.point_a)))
                elif joint.a == body and joint.b in self.poses:
                    pins.append((joint.point_a, to_world(self.poses[joint.b], joint.point_b)))
        return pins


def _turn_between(known: list[tuple[Point, Point]]) -> float | None:
    """Turn of a body of which two places are known, those farthest from each other."""
    pairs = [(math.dist(a[0], b[0]), i, j) for i, a in enumerate(known) for j, b in enumerate(known[:i])]
    if not pairs:
        return None
    distance, i, j = max(pairs)
    if distance <= APART * max(math.hypot(*local) for local, _ in known):
        return None
    (a, there_a), (b, there_b) = known[i], known[j]
    turned = math.atan2(there_b[1] - there_a[1], there_b[0] - there_a[0])
    return math.remainder(turned - math.atan2(b[1] - a[1], b[0] - a[0]), 2.0 * math.pi)
