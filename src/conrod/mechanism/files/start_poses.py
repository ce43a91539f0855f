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
from conrod.mechanism.files.bodies import ORIGIN, RATE, TURN, Places
from conrod.mechanism.files.fields import ANGLE, COORDINATE, LENGTH, Fields
from conrod.mechanism.mechanism import (
    GROUND,
    Driver,
    Joint,
    LowerPair,
    Point,
    Pose,
    Prismatic,
    Rack,
    Revolute,
    Rolling,
    beside,
    to_world,
)
from conrod.mechanism.units import REVOLUTION, Parameter

# Two places give a body's turn if they are this far apart, of the larger distance from its origin.
APART = 1e-6
TURN_RATE = Parameter("rad/s", 0.0, 1e6, magnitude=True)


@dataclass(frozen=True)
class Hint:
    """Approximate position of a body at crank angle 0, as a file gives it."""

    turn: float | None = None  # [rad]
    places: tuple[tuple[Point, Point], ...] = ()  # points of the body [m], in its frame, and in the document's
    rate: float | None = None  # exact, of its turn where nothing drives the crank [rad/s], counter-clockwise


def read_start(fields: Fields, places: Places, crank: str) -> dict[str, Hint]:
    """The start poses that a file gives, by body."""
    hints = {}
    for name, inside in fields.named("start").items():
        places.found(f"start.{name}", name)
        if name == GROUND or (name == crank and set(inside.names()) - {RATE}):
            reason = "it does not move" if name == GROUND else "driver.start tells its turn"
            also = "" if name == GROUND or RATE not in inside else f" but for its {RATE}"
            raise InvalidInput(f"{inside.place}: leave it out{also}: {reason}")
        known = []
        for point in inside.names():
            if point not in (TURN, RATE):
                place = places.found(inside.place, f"{name}.{point}")
                there = inside.pair(point, COORDINATE, f"about where {point} of {name} is at the start")
                known.append((place.point, there))
        turn = inside.optional(TURN, ANGLE, f"about the turn of {name} at the start")
        rate = inside.optional(RATE, TURN_RATE, f"turn rate of {name} where a motion without a drive starts")
        hints[name] = Hint(turn, tuple(known), rate)
    return hints


def placed(
    names: tuple[str, ...], joints: tuple[Joint, ...], driver: Driver, hints: Mapping[str, Hint]
) -> dict[str, Pose]:
    """Approximate poses of all bodies, the crank first; raises InvalidInput on the first whose pose does not follow."""
    search = _Search(joints, hints)
    search.turns[names[0]] = driver.start
    # What is given exactly goes before what has to be supposed.
    while open_ones := [name for name in names if name not in search.poses]:
        if not any(attempt(name) for attempt in (search.place, search.suppose) for name in open_ones):
            raise InvalidInput(search.missing(open_ones))
    return {name: search.poses[name] for name in names}


class _Search:
    """Bodies placed so far."""

    def __init__(self, joints: tuple[Joint, ...], hints: Mapping[str, Hint]) -> None:
        self._joints, self._hints = joints, hints
        self.poses: dict[str, Pose] = {GROUND: (0.0, 0.0, 0.0)}
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
        known, turn = self._known(body), self._turn(body)
        turn = _turn_between(known) if turn is None else turn
        if turn is None or not known:
            return False
        away = [to_world((0.0, 0.0, turn), local) for local, _ in known]
        x = sum(there[0] - off[0] for (_, there), off in zip(known, away, strict=True)) / len(known)
        y = sum(there[1] - off[1] for (_, there), off in zip(known, away, strict=True)) / len(known)
        self.poses[body] = (x, y, turn)
        return True

    def suppose(self, body: str) -> bool:
        """Place a body that rolls with its turn 0."""
        joints = [joint for joint in self._joints if body in (joint.a, joint.b)]
        if not self._known(body) or not any(isinstance(joint, Rolling | Rack) for joint in joints):
            return False
        self.turns[body] = 0.0
        return self.place(body)

    def _turn(self, body: str) -> float | None:
        for joint, other, _, _ in self._beside(body, Prismatic):
            if isinstance(joint, Prismatic) and other in self.poses:
                return self.poses[other][2] + (joint.angle if joint.b == body else -joint.angle)
        return self.turns.get(body)

    def _known(self, body: str) -> list[tuple[Point, Point]]:
        """Points of a body that the file places, or a pin holds at a placed body, and where they are."""
        pins = [x for x in self._beside(body, Revolute) if x[1] in self.poses]
        held = [(local, to_world(self.poses[other], there)) for _, other, there, local in pins]
        return [*self._hints.get(body, Hint()).places, *held]

    def _beside(self, body: str, kind: type[LowerPair]) -> list[tuple[LowerPair, str, Point, Point]]:
        """Joints of a kind on a body, with the other body, the point on that, and its own."""
        return [(j, *beside(j, body)) for j in self._joints if isinstance(j, kind) and body in (j.a, j.b)]


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
    return math.remainder(turned - math.atan2(b[1] - a[1], b[0] - a[0]), REVOLUTION)


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
