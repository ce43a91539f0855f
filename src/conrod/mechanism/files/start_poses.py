"""Approximate start poses of all bodies, from the positions that a file gives.

The driver gives the crank's rotation, a slide the rotation of one body against the other, and a pin on a placed body a
position on another one. Two positions, or one and the rotation, place a body. [start] has to give what is still open.
Newton iteration then assembles the mechanism from these poses.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from conrod.errors import InvalidInput
from conrod.mechanism.files.bodies import ORIGIN, RATE_KEY, TURN_KEY, Places
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
    joint_partner,
    to_world,
)
from conrod.mechanism.units import REVOLUTION, Parameter

MIN_POINT_DISTANCE = 1e-6  # of two points that determine a rotation, over their larger distance from the origin
TURN_RATE = Parameter("rad/s", 0.0, 1e6, magnitude=True)


@dataclass(frozen=True)
class StartHint:
    """Approximate position of a body at crank angle 0, as given in [start]."""

    turn: float | None = None  # [rad]
    places: tuple[tuple[Point, Point], ...] = ()  # points of the body [m], in its frame, and in the document's
    rate: float | None = None  # exact, of its turn where nothing drives the crank [rad/s], counter-clockwise


def read_start(fields: Fields, places: Places, crank: str) -> dict[str, StartHint]:
    """Read the start positions given in a file, by body."""
    hints = {}
    for name, inside in fields.named_tables("start").items():
        places.find_point(f"start.{name}", name)
        if name == GROUND or (name == crank and set(inside.names()) - {RATE_KEY}):
            reason = "it does not move" if name == GROUND else "driver.start tells its turn"
            also = "" if name == GROUND or RATE_KEY not in inside else f" but for its {RATE_KEY}"
            raise InvalidInput(f"{inside.place}: leave it out{also}: {reason}")
        known = []
        for point in inside.names():
            if point not in (TURN_KEY, RATE_KEY):
                place = places.find_point(inside.place, f"{name}.{point}")
                there = inside.pair(point, COORDINATE, f"about where {point} of {name} is at the start")
                known.append((place.point, there))
        turn = inside.optional_number(TURN_KEY, ANGLE, f"about the turn of {name} at the start")
        rate = inside.optional_number(RATE_KEY, TURN_RATE, f"turn rate of {name} where a motion without a drive starts")
        hints[name] = StartHint(turn, tuple(known), rate)
    return hints


def place_bodies(
    names: tuple[str, ...], joints: tuple[Joint, ...], driver: Driver, hints: Mapping[str, StartHint]
) -> dict[str, Pose]:
    """Approximate poses of all bodies, the crank first; InvalidInput names the first that is not determined."""
    search = _PlacementSearch(joints, hints)
    search.turns[names[0]] = driver.start
    # What is given exactly goes before what has to be supposed.
    while open_ones := [name for name in names if name not in search.poses]:
        if not any(attempt(name) for attempt in (search.place, search.place_rolling) for name in open_ones):
            raise InvalidInput(search.missing_message(open_ones))
    return {name: search.poses[name] for name in names}


class _PlacementSearch:
    """Search for poses of bodies, one after another."""

    def __init__(self, joints: tuple[Joint, ...], hints: Mapping[str, StartHint]) -> None:
        self._joints, self._hints = joints, hints
        self.poses: dict[str, Pose] = {GROUND: (0.0, 0.0, 0.0)}
        self.turns: dict[str, float] = {name: hint.turn for name, hint in hints.items() if hint.turn is not None}

    def missing_message(self, bodies: list[str]) -> str:
        """Error message for bodies that could not be placed."""
        first = f"start.{bodies[0]}"
        give = f"where about one of its points is, as in {first}.{ORIGIN} = [0, 0]"
        if self._known_rotation(bodies[0]) is None:
            give = f"{first}.{TURN_KEY}, or {give}"
        others = f", or the same of {', '.join(bodies[1:])}" if bodies[1:] else ""
        return f"{first}: where it is at crank angle 0 does not follow from the other bodies: give {give}{others}"

    def place(self, body: str) -> bool:
        """Place a body if its pose is determined; return whether it is."""
        known, turn = self._known_points(body), self._known_rotation(body)
        turn = _rotation_between(known) if turn is None else turn
        if turn is None or not known:
            return False
        away = [to_world((0.0, 0.0, turn), local) for local, _ in known]
        x = sum(there[0] - off[0] for (_, there), off in zip(known, away, strict=True)) / len(known)
        y = sum(there[1] - off[1] for (_, there), off in zip(known, away, strict=True)) / len(known)
        self.poses[body] = (x, y, turn)
        return True

    def place_rolling(self, body: str) -> bool:
        """Place a rolling body with rotation 0; return whether it could be placed."""
        joints = [joint for joint in self._joints if body in (joint.a, joint.b)]
        if not self._known_points(body) or not any(isinstance(joint, Rolling | Rack) for joint in joints):
            return False
        self.turns[body] = 0.0
        return self.place(body)

    def _known_rotation(self, body: str) -> float | None:
        """Rotation [rad] of a body, from a slide or from [start]; None if it is not known."""
        for joint, other, _, _ in self._joints_with_partner(body, Prismatic):
            if isinstance(joint, Prismatic) and other in self.poses:
                return self.poses[other][2] + (joint.angle if joint.b == body else -joint.angle)
        return self.turns.get(body)

    def _known_points(self, body: str) -> list[tuple[Point, Point]]:
        """Known points of a body and their positions, from [start] or from pins on placed bodies."""
        pins = [x for x in self._joints_with_partner(body, Revolute) if x[1] in self.poses]
        held = [(local, to_world(self.poses[other], there)) for _, other, there, local in pins]
        return [*self._hints.get(body, StartHint()).places, *held]

    def _joints_with_partner(self, body: str, kind: type[LowerPair]) -> list[tuple[LowerPair, str, Point, Point]]:
        """Joints of a kind on a body, with the results of `joint_partner`."""
        return [(j, *joint_partner(j, body)) for j in self._joints if isinstance(j, kind) and body in (j.a, j.b)]


def _rotation_between(known: list[tuple[Point, Point]]) -> float | None:
    """Rotation [rad] of a body by its two known points farthest apart; None without two distinct points."""
    pairs = [(math.dist(a[0], b[0]), i, j) for i, a in enumerate(known) for j, b in enumerate(known[:i])]
    if not pairs:
        return None
    distance, i, j = max(pairs)
    if distance <= MIN_POINT_DISTANCE * max(math.hypot(*local) for local, _ in known):
        return None
    (a, there_a), (b, there_b) = known[i], known[j]
    turned = math.atan2(there_b[1] - there_a[1], there_b[0] - there_a[0])
    return math.remainder(turned - math.atan2(b[1] - a[1], b[0] - a[0]), REVOLUTION)


def with_start_offset(joint: Joint, poses: Mapping[str, Pose]) -> Joint:
    """Return a rolling joint with the offset of the start poses; any other joint unchanged.

    Raises:
        InvalidInput: the line of centres, against which rotations count, has no length.
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
    displacement = (ax - bx) * math.cos(direction) + (ay - by) * math.sin(direction)
    return replace(joint, offset=displacement + joint.radius * (a[2] - b[2]))
