"""Velocity and acceleration polygons of a linkage: vectors chained from a pole, as a course draws them.

Every vector is computed on its own (omega x r, alpha x r, -omega^2 r, 2 omega x V, the slide's own motion), and every
place in the plane from the absolute motion of one of the links that carry the point. So that the polygon closes says
that the links move together, and is not made so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from conrod.exact.linkage.accelerations import coincident_parts, rolling_acceleration
from conrod.exact.linkage.centres import joint_centre
from conrod.exact.linkage.points import (
    POLE,
    Carrier,
    NamedPoint,
    RollingContact,
    SlidingPair,
    linkage_points,
    place_name,
)
from conrod.exact.linkage.state import LinkageState, left_of, link_numbers
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Revolute, beside

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
        found = {vector.name: vector for vector in self.vectors}
        return found[name]


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
        points += [point for contact in self._points.contacts for point in self._touching(contact)]
        for point in points:
            # The first carrier gives the vectors from the pole, so the last one, where there are two, the place.
            self._places[place_name(point.name)] = self._absolute(point.carriers[-1])
        for point in points:
            if not point.fixed:
                self._from_pole(point)
        for link in link_numbers(self._state.mechanism):
            self._image(link, points)
        for pair in pairs:
            self._slide(pair)
        if self._second:  # of velocities there is one only where links roll
            for contact in self._points.contacts:
                self._roll(contact)
        return Polygon(self._quantity, self._places, tuple(self._vectors))

    # -- points --------------------------------------------------------------------------------------------------

    def _guide_point(self, pair: SlidingPair) -> NamedPoint:
        """The guide's point under the moving one, at this state."""
        links, moving = self._state.links, pair.carrier
        return NamedPoint(
            pair.guide_point, (Carrier(pair.guide, links[pair.guide].own(links[moving.link].place(moving.point))),)
        )

    def _touching(self, contact: RollingContact) -> list[NamedPoint]:
        """The point of both links that roll, which has one velocity; of each, with its number, for accelerations."""
        centre, mechanism = joint_centre(self._state, contact.joint), self._state.mechanism
        assert centre is not None
        pair = (contact.joint.a, contact.joint.b)
        carriers = [Carrier(link, self._state.links[link].own(centre[:2])) for link in pair if link != GROUND]
        if not self._second:
            return [NamedPoint(contact.name, tuple(sorted(carriers, key=lambda c: mechanism.guide(c.link) is None)))]
        numbers = link_numbers(mechanism)
        return [NamedPoint(f"{contact.name}{numbers[c.link]}", (c,), fixed=GROUND in pair) for c in carriers]

    # -- vectors -------------------------------------------------------------------------------------------------

    def _from_pole(self, point: NamedPoint) -> None:
        """Vectors from the pole to a point's place."""
        carrier, ends = point.carriers[0], (POLE, place_name(point.name))
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
            ends = (place_name(first), place_name(second))
            self._chain(f"{second}/{first}", ends, self._turning(origin, carrier, "relative"), link)

    def _slide(self, pair: SlidingPair) -> None:
        """Vectors from a guide's point to the one that slides."""
        motion = coincident_parts(self._state, pair.guide, *pair.carrier)
        parts: list[Part] = [("V", motion.relative_velocity, "sliding")]
        if self._second:
            along: list[Part] = [("A^n", motion.normal, "normal"), ("A^t", motion.tangential, "tangential")]
            if pair.straight:
                along = [("A", motion.relative, "sliding")]
            parts = [("A^c", motion.coriolis, "coriolis"), *along]
        ends = (place_name(pair.guide_point), place_name(pair.moving))
        self._chain(f"{pair.moving}/{pair.guide_point}", ends, parts, pair.guide if self._second else None)

    def _roll(self, contact: RollingContact) -> None:
        """The acceleration of the one link's point against the other's."""
        joint, value = contact.joint, rolling_acceleration(self._state, contact.joint)
        first, second = joint.a, joint.b
        if second == GROUND:
            first, second, value = second, first, -value
        numbers = link_numbers(self._state.mechanism)
        one, other = (f"{contact.name}{numbers[link]}" for link in (first, second))
        if first == GROUND:
            self._chain(other, (POLE, place_name(other)), [("A", value, "normal")])
        else:
            self._chain(f"{other}/{one}", (place_name(one), place_name(other)), [("A", value, "normal")])

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
