"""Velocity and acceleration polygons of a linkage: vectors chained from a pole, as a course draws them.

Every vector is computed on its own (omega x r, alpha x r, -omega^2 r, 2 omega x V, the slide's own motion), and every
place in the plane from the absolute motion of one of the links that carry the point. So that the polygon closes says
that the links move together, and is not made so. The same parts of the acceleration of single points stand here too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from conrod.exact.linkage.centres import joint_centre
from conrod.exact.linkage.points import POLE, Carrier, NamedPoint, SlidingPair, linkage_points
from conrod.exact.linkage.state import LinkageState, left_of, link_numbers
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mesh, Point, Revolute, Rolling, beside

# A point slower than this share of the linkage's own speed stands still, and its path has no direction.
AT_REST = 1e-12
Kind = Literal["absolute", "relative", "sliding", "normal", "tangential", "coriolis"]


@dataclass(frozen=True)
class PolygonVector:
    """One vector of a polygon.

    Attributes:
        start, stop: places in the polygon that it leads from and to, keys of `Polygon.places`.
    """

    name: str  # as the course writes it: V_A, V_B/A, A^n_B/A, A^t_B/A, A^c_B/B4
    start: str
    stop: str
    value: Array  # (2,) [m/s] or [m/s^2]
    kind: Kind  # what it is
    link: str | None  # the link whose turning gives it; None for others


@dataclass(frozen=True)
class Polygon:
    """A velocity or acceleration polygon.

    Attributes:
        places: end of the absolute velocity or acceleration of each point, in small letters, (2,) [m/s] or [m/s^2];
            the pole O at (0, 0); and the corners between a normal and a tangential part.
    """

    quantity: Literal["velocity", "acceleration"]  # "velocity" or "acceleration"
    places: Mapping[str, Array]
    vectors: tuple[PolygonVector, ...]  # in the order in which they are drawn

    @property
    def size(self) -> float:
        """The longest vector [m/s] or [m/s^2]."""
        return max((float(np.linalg.norm(vector.value)) for vector in self.vectors), default=0.0)

    @property
    def gap(self) -> float:
        """The farthest that a vector misses the place that it leads to, against the longest vector [1]."""
        misses = [
            float(np.linalg.norm(self.places[vector.start] + vector.value - self.places[vector.stop]))
            for vector in self.vectors
        ]
        return max(misses, default=0.0) / (self.size or 1.0)

    def vector(self, name: str) -> PolygonVector:
        """The vector of a name; KeyError if there is none."""
        return {vector.name: vector for vector in self.vectors}[name]


# A vector's symbol, which the name of its points follows; its value; its kind.
Part: TypeAlias = tuple[str, Array, Kind]


def velocity_polygon(state: LinkageState) -> Polygon:
    """The velocity polygon at a state."""
    return _Drawing(state, "velocity").polygon()


def acceleration_polygon(state: LinkageState) -> Polygon:
    """The acceleration polygon at a state, each vector in its normal and tangential part."""
    return _Drawing(state, "acceleration").polygon()


class _Drawing:
    """A polygon that is being drawn."""

    def __init__(self, state: LinkageState, quantity: Literal["velocity", "acceleration"]) -> None:
        self._state, self._quantity = state, quantity
        self._symbol, self._second = ("V", False) if quantity == "velocity" else ("A", True)
        self._points = linkage_points(state.mechanism)
        self._places: dict[str, Array] = {POLE: np.zeros(2)}
        self._vectors: list[PolygonVector] = []

    def polygon(self) -> Polygon:
        pairs = self._points.pairs
        points = [*self._points.points, *map(self._guide_point, pairs)]
        points += [point for contact in self._points.contacts.items() for point in self._touching(*contact)]
        for point in points:
            # The first carrier gives the vectors from the pole, so the last one, where there are two, the place.
            self._places[point.name.lower()] = self._absolute(point.carriers[-1])
        for point in points:
            if not point.fixed:
                self._from_pole(point)
        for link in link_numbers(self._state.mechanism):
            self._image(link, points)
        for pair in pairs:
            self._slide(pair)
        if self._second:  # of velocities there is one only where links roll
            for contact in self._points.contacts.items():
                self._roll(*contact)
        return Polygon(self._quantity, self._places, tuple(self._vectors))

    # -- points --------------------------------------------------------------------------------------------------

    def _guide_point(self, pair: SlidingPair) -> NamedPoint:
        """The guide's point under the moving one, at this state."""
        links, moving = self._state.links, pair.carrier
        return NamedPoint(
            pair.guide_point, (Carrier(pair.guide, links[pair.guide].own(links[moving.link].place(moving.point))),)
        )

    def _touching(self, name: str, joint: Mesh) -> list[NamedPoint]:
        """The point of both links that roll, which has one velocity; of each, with its number, for accelerations."""
        centre, mechanism = joint_centre(self._state, joint), self._state.mechanism
        assert centre is not None
        pair = (joint.a, joint.b)
        carriers = [Carrier(link, self._state.links[link].own(centre[:2])) for link in pair if link != GROUND]
        if not self._second:
            return [NamedPoint(name, tuple(sorted(carriers, key=lambda c: mechanism.guide(c.link) is None)))]
        numbers = link_numbers(mechanism)
        return [NamedPoint(f"{name}{numbers[c.link]}", (c,), fixed=GROUND in pair) for c in carriers]

    # -- vectors -------------------------------------------------------------------------------------------------

    def _from_pole(self, point: NamedPoint) -> None:
        """Vectors from the pole to a point's place."""
        carrier, ends = point.carriers[0], (POLE, point.name.lower())
        guide = self._state.mechanism.guide(carrier.link)
        if not isinstance(guide, Revolute):
            self._chain(point.name, ends, [(self._symbol, self._absolute(carrier), "absolute")])
        else:
            parts = self._turning(Carrier(carrier.link, beside(guide, carrier.link)[2]), carrier, "absolute")
            self._chain(point.name, ends, parts, carrier.link)

    def _image(self, link: str, points: list[NamedPoint]) -> None:
        """The sides of a floating link's image."""
        if self._state.mechanism.guide(link) is not None:
            return
        carried = [(point.name, c) for point in points if point.joined for c in point.carriers if c.link == link]
        sides = [*pairwise(carried), *([(carried[0], carried[-1])] if len(carried) > 2 else [])]
        for (first, origin), (second, carrier) in sides:
            ends = (first.lower(), second.lower())
            self._chain(f"{second}/{first}", ends, self._turning(origin, carrier, "relative"), link)

    def _slide(self, pair: SlidingPair) -> None:
        """Vectors from a guide's point to the one that slides."""
        motion = coincident_parts(self._state, pair.guide, *pair.carrier)
        parts: list[Part] = [("V", motion.relative_velocity, "sliding")]
        if self._second:
            along: list[Part] = [("A^n", motion.normal, "normal"), ("A^t", motion.tangential, "tangential")]
            if pair.straight:
                along = [("A", motion.normal + motion.tangential, "sliding")]
            parts = [("A^c", motion.coriolis, "coriolis"), *along]
        ends = (pair.guide_point.lower(), pair.moving.lower())
        self._chain(f"{pair.moving}/{pair.guide_point}", ends, parts, pair.guide if self._second else None)

    def _roll(self, name: str, joint: Mesh) -> None:
        """The acceleration of the one link's point against the other's."""
        first, second, value = joint.a, joint.b, rolling_acceleration(self._state, joint)
        if second == GROUND:
            first, second, value = second, first, -value
        numbers = link_numbers(self._state.mechanism)
        one, other = (f"{name}{numbers[link]}" for link in (first, second))
        if first == GROUND:
            self._chain(other, (POLE, other.lower()), [("A", value, "normal")])
        else:
            self._chain(f"{other}/{one}", (one.lower(), other.lower()), [("A", value, "normal")])

    def _chain(self, name: str, ends: tuple[str, str], parts: list[Part], link: str | None = None) -> None:
        """Vectors one after the other, with a corner after each but the last."""
        start = ends[0]
        for k, (symbol, value, kind) in enumerate(parts):
            vector = f"{symbol}_{name}"
            stop = ends[1] if k == len(parts) - 1 else f"{vector}'"
            if k < len(parts) - 1:
                self._places[stop] = self._places[start] + value
            self._vectors.append(PolygonVector(vector, start, stop, value, kind, link))
            start = stop

    def _absolute(self, carrier: Carrier) -> Array:
        """Velocity or acceleration of a point of a link; (2,)."""
        link = self._state.links[carrier.link]
        return link.acceleration_at(carrier.point) if self._second else link.velocity_at(carrier.point)

    def _turning(self, origin: Carrier, carrier: Carrier, kind: Kind) -> list[Part]:
        """Parts of the motion of a point of a link relative to an origin on the same link."""
        link = self._state.links[carrier.link]
        arm = link.place(carrier.point) - link.place(origin.point)
        if not self._second:
            return [("V", link.angular_velocity * left_of(arm), kind)]
        normal, tangential = -(link.angular_velocity**2) * arm, link.angular_acceleration * left_of(arm)
        return [("A^n", normal, "normal"), ("A^t", tangential, "tangential")]


# -- parts of accelerations --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PathParts:
    """Parts of a point's acceleration by its path.

    Attributes:
        radius: of the path's curvature [m]; infinite where the path is straight, None where the point stands still.
    """

    normal: Array  # towards the path's centre of curvature, V^2 / rho; (2,) [m/s^2]
    tangential: Array  # along the path; (2,) [m/s^2]
    radius: float | None


@dataclass(frozen=True)
class CoincidentParts:
    """Motion of a point of one link against the point of another link that it coincides with.

    A = A_guide + 2 omega x V_rel + A_rel, with omega the guide's.
    """

    relative_velocity: Array  # of the point in the guide; (2,) [m/s]
    coriolis: Array  # 2 omega x V_rel; (2,) [m/s^2]
    normal: Array  # part of A_rel across the path in the guide, zero for a straight slide; (2,) [m/s^2]
    tangential: Array  # part of A_rel along it; (2,) [m/s^2]


def path_parts(state: LinkageState, link: str, point: Point) -> PathParts:
    """Normal and tangential part of the acceleration of a point of a link."""
    velocity, acceleration = state.links[link].velocity_at(point), state.links[link].acceleration_at(point)
    speed = float(np.linalg.norm(velocity))
    if speed <= AT_REST * abs(state.speed) * state.size:
        return PathParts(np.zeros(2), acceleration, None)
    along = velocity / speed
    tangential = (acceleration @ along) * along
    normal = acceleration - tangential
    across = float(np.linalg.norm(normal))
    # A normal part that is rounding belongs to a straight path.
    straight = across <= AT_REST * max(float(np.linalg.norm(acceleration)), state.speed**2 * state.size)
    return PathParts(normal, tangential, np.inf if straight else speed**2 / across)


def coincident_parts(state: LinkageState, guide: str, moving: str, point: Point) -> CoincidentParts:
    """Parts of the acceleration of a point [m] of a moving link, seen from the guide in which its path is.

    The guide's angular velocity gives the Coriolis part.
    """
    _, velocity, acceleration = state.seen_from(guide, moving, point)
    frame = state.links[guide]
    turned = frame.pose[2]
    axes = np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
    sliding, change = axes @ velocity, axes @ acceleration
    speed = float(np.linalg.norm(sliding))
    # A point that turns round in its slot has no speed, but an acceleration along the slot.
    along = sliding / speed if speed > AT_REST * abs(state.speed) * state.size else _direction(change)
    tangential = (change @ along) * along
    coriolis = 2.0 * frame.angular_velocity * left_of(sliding)
    return CoincidentParts(sliding, coriolis, change - tangential, tangential)


def rolling_acceleration(state: LinkageState, joint: Mesh) -> Array:
    """Acceleration of the point of `b` in contact against that of `a`; (2,) [m/s^2].

    The two have one velocity, and accelerations that differ along the common normal alone, by omega^2 r R / (R + r)
    with signed radii and their relative angular velocity omega (document 001, figures 6.12 to 6.14).
    """
    a, b = state.links[joint.a], state.links[joint.b]
    turning = (b.angular_velocity - a.angular_velocity) ** 2
    centre = a.place(joint.point_a)
    if isinstance(joint, Rolling):
        share = joint.radius_a * joint.radius_b / (joint.radius_a + joint.radius_b) ** 2
        return np.asarray(turning * share * (b.place(joint.point_b) - centre))
    contact = joint_centre(state, joint)
    assert contact is not None
    return np.asarray(turning * (contact[:2] - centre))


def _direction(vector: Array) -> Array:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else np.array([1.0, 0.0])
