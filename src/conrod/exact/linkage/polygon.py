"""Velocity and acceleration polygons of a linkage: vectors chained from a pole, as a course draws them.

Every vector is computed on its own (omega x r, alpha x r, -omega^2 r, 2 omega x V, the slide's own motion), and every
place in the plane from the absolute motion of one of the links that carry the point. So that the polygon closes says
that the links move together, and is not made so.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from conrod.exact.linkage.accelerations import coincident_parts, link_parts
from conrod.exact.linkage.points import (
    POLE,
    Carrier,
    NamedPoint,
    SlidingPair,
    contact_vector,
    guided,
    linkage_points,
    parted_points,
    pivot_of,
    place_name,
    shared_point,
)
from conrod.exact.linkage.state import LinkageState, left_of, link_numbers
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Prismatic

Kind = Literal["absolute", "relative", "sliding", "normal", "tangential", "coriolis"]


@dataclass(frozen=True)
class PolygonVector:
    """One vector of a polygon.

    Attributes:
        name: as the course writes it: V_A, V_B/A, A^n_B/A, A^t_B/A, A^c_B/B4.
        start, stop: places in the polygon that it leads from and to, keys of `Polygon.places`.
        value: (2,) [m/s] or [m/s^2].
        kind: what it is.
        link: the link whose turning gives it; None for others.
    """

    name: str
    start: str
    stop: str
    value: Array
    kind: Kind
    link: str | None


@dataclass(frozen=True)
class Polygon:
    """A velocity or acceleration polygon.

    Attributes:
        quantity: "velocity" or "acceleration".
        places: end of the absolute velocity or acceleration of each point, in small letters, (2,) [m/s] or [m/s^2];
            the pole O at (0, 0); and the corners between a normal and a tangential part.
        vectors: in the order in which they are drawn.
    """

    quantity: Literal["velocity", "acceleration"]
    places: Mapping[str, Array]
    vectors: tuple[PolygonVector, ...]

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
    return _Velocities(state).polygon()


def acceleration_polygon(state: LinkageState) -> Polygon:
    """The acceleration polygon at a state, each vector in its normal and tangential part."""
    return _Accelerations(state).polygon()


class _Drawing(ABC):
    """A polygon that is being drawn."""

    quantity: Literal["velocity", "acceleration"]
    symbol: str

    def __init__(self, state: LinkageState) -> None:
        self.state = state
        self.points = linkage_points(state.mechanism)
        self.places: dict[str, Array] = {POLE: np.zeros(2)}
        self.vectors: list[PolygonVector] = []

    def polygon(self) -> Polygon:
        pairs = self.points.pairs
        points = [*self.points.points, *(self._guide_point(pair) for pair in pairs), *self.contact_points()]
        for point in points:
            # The first carrier gives the vectors from the pole, so the last one, where there are two, the place.
            self.places[place_name(point.name)] = self.absolute(point.carriers[-1])
        for point in points:
            if not point.fixed:
                self._from_pole(point)
        for link in link_numbers(self.state.mechanism):
            self._image(link, points)
        for pair in pairs:
            parts, turning_link = self.sliding(pair)
            name = f"{pair.moving.name}/{pair.guide_point}"
            self._chain(name, (place_name(pair.guide_point), place_name(pair.moving.name)), parts, turning_link)
        self.roll()
        return Polygon(self.quantity, self.places, tuple(self.vectors))

    def _guide_point(self, pair: SlidingPair) -> NamedPoint:
        """The guide's point under the moving one, at this state."""
        moving, links = pair.moving_carrier(self.state.mechanism), self.state.links
        own = links[pair.guide].own(links[moving.link].place(moving.point))
        return NamedPoint(pair.guide_point, (Carrier(pair.guide, own),))

    def _from_pole(self, point: NamedPoint) -> None:
        """Vectors from the pole to a point's place."""
        carrier, ends = point.carriers[0], (POLE, place_name(point.name))
        pivot = pivot_of(self.state.mechanism, carrier.link)
        if pivot is None:
            self._chain(point.name, ends, [(self.symbol, self.absolute(carrier), "absolute")])
        else:
            self._chain(point.name, ends, self.turning(Carrier(carrier.link, pivot), carrier, "absolute"), carrier.link)

    def _image(self, link: str, points: list[NamedPoint]) -> None:
        """The sides of a floating link's image."""
        if guided(self.state.mechanism, link):
            return
        carried = [(point.name, c) for point in points if point.joined for c in point.carriers if c.link == link]
        sides = [*pairwise(carried), *([(carried[0], carried[-1])] if len(carried) > 2 else [])]
        for (first, origin), (second, carrier) in sides:
            ends = (place_name(first), place_name(second))
            self._chain(f"{second}/{first}", ends, self.turning(origin, carrier, "relative"), link)

    def _chain(self, name: str, ends: tuple[str, str], parts: list[Part], link: str | None = None) -> None:
        """Vectors one after the other, with a corner after each but the last."""
        start = ends[0]
        for k, (symbol, value, kind) in enumerate(parts):
            vector = f"{symbol}_{name}"
            stop = ends[1] if k == len(parts) - 1 else f"{vector}'"
            if k < len(parts) - 1:
                self.places[stop] = self.places[start] + value
            self.vectors.append(PolygonVector(vector, start, stop, value, kind, link))
            start = stop

    @abstractmethod
    def absolute(self, carrier: Carrier) -> Array:
        """Of a point of a link; (2,)."""

    @abstractmethod
    def turning(self, origin: Carrier, carrier: Carrier, kind: Kind) -> list[Part]:
        """Parts of the motion of a point of a link relative to an origin on the same link."""

    @abstractmethod
    def sliding(self, pair: SlidingPair) -> tuple[list[Part], str | None]:
        """Parts of the motion from a guide's point to the one that slides, and the link whose turning gives them."""

    @abstractmethod
    def contact_points(self) -> list[NamedPoint]:
        """Points of the links that roll on others."""

    @abstractmethod
    def roll(self) -> None:
        """Vectors between points of links that roll on each other."""


class _Velocities(_Drawing):
    quantity, symbol = "velocity", "V"

    def absolute(self, carrier: Carrier) -> Array:
        return self.state.links[carrier.link].velocity_at(carrier.point)

    def turning(self, origin: Carrier, carrier: Carrier, kind: Kind) -> list[Part]:
        link = self.state.links[carrier.link]
        arm = link.place(carrier.point) - link.place(origin.point)
        return [("V", link.angular_velocity * left_of(arm), kind)]

    def sliding(self, pair: SlidingPair) -> tuple[list[Part], str | None]:
        moving = pair.moving_carrier(self.state.mechanism)
        parts = coincident_parts(self.state, pair.guide, moving.link, moving.point)
        return [("V", parts.relative_velocity, "sliding")], None

    def contact_points(self) -> list[NamedPoint]:
        return [shared_point(self.state, contact) for contact in self.points.contacts]

    def roll(self) -> None:
        """Nothing to draw: they have one velocity."""


class _Accelerations(_Drawing):
    quantity, symbol = "acceleration", "A"

    def absolute(self, carrier: Carrier) -> Array:
        return self.state.links[carrier.link].acceleration_at(carrier.point)

    def turning(self, origin: Carrier, carrier: Carrier, kind: Kind) -> list[Part]:
        parts = link_parts(self.state, carrier.link, carrier.point, origin.point)
        return [("A^n", parts.normal, "normal"), ("A^t", parts.tangential, "tangential")]

    def sliding(self, pair: SlidingPair) -> tuple[list[Part], str | None]:
        moving = pair.moving_carrier(self.state.mechanism)
        parts = coincident_parts(self.state, pair.guide, moving.link, moving.point)
        along: list[Part] = [("A^n", parts.normal, "normal"), ("A^t", parts.tangential, "tangential")]
        if any(joint.name == pair.joint and isinstance(joint, Prismatic) for joint in self.state.mechanism.joints):
            along = [("A", parts.relative, "sliding")]
        return [("A^c", parts.coriolis, "coriolis"), *along], pair.guide

    def contact_points(self) -> list[NamedPoint]:
        return [point for contact in self.points.contacts for point in parted_points(self.state, contact)]

    def roll(self) -> None:
        for contact in self.points.contacts:
            name, ends, value = contact_vector(self.state, contact)
            self.vectors.append(PolygonVector(name, *ends, value, "normal", None))
