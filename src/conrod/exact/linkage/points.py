"""The points of a linkage that a velocity or acceleration polygon is about, with letters as a course gives them."""

from __future__ import annotations

import math
import string
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count
from typing import NamedTuple

from conrod.exact.linkage.accelerations import coincident_point
from conrod.exact.linkage.centres import SAME
from conrod.exact.linkage.state import link_numbers
from conrod.mechanism.mechanism import GROUND, Joint, Mechanism, Mesh, Point, Prismatic, Revolute

POLE = "O"  # of a polygon


class Carrier(NamedTuple):
    """A link with the place [m] of a point in its frame."""

    link: str
    point: Point


@dataclass(frozen=True)
class NamedPoint:
    """A point of a linkage."""

    name: str  # its letter, or what it is called in the mechanism
    carriers: tuple[Carrier, ...]  # the links that it is a point of, those that the ground guides first
    joined: bool = True  # whether links meet there; else it is a point of one link that is only looked at
    fixed: bool = False  # whether the other link that it rolls on is the ground


class SlidingPair(NamedTuple):
    """A point of a link, and the point of its guide that it coincides with."""

    guide: str  # the link that carries the path
    guide_point: str  # name of the guide's point: the moving point's, with the guide's number
    moving: str  # name of the point that slides
    carrier: Carrier  # the same on the link that slides in the guide
    straight: bool  # whether the path is a line


class RollingContact(NamedTuple):
    """The contact of two links that roll on each other, another point of both at every crank angle."""

    name: str  # its letter
    joint: Mesh


@dataclass(frozen=True)
class LinkagePoints:
    """All moving points that a polygon shows, from the crank on, those that coincide in slides and cams, contacts."""

    points: tuple[NamedPoint, ...]
    pairs: tuple[SlidingPair, ...]
    contacts: tuple[RollingContact, ...]


def place_name(point: str) -> str:
    """The name of a point's place in a polygon, as the course has it: in small letters."""
    return point.lower()


def linkage_points(mechanism: Mechanism) -> LinkagePoints:
    """Pins between moving links, points of moving slides and cams, observed points.

    A pin has its joint's name where that is one or two characters long, else the name of the observed point at its
    place, else a letter: from A on, in the order of the links' numbers.
    """
    naming = _Naming(mechanism)
    moving = [joint for joint in naming.joints if GROUND not in (joint.a, joint.b)]
    for joint in moving:
        if isinstance(joint, Revolute):
            naming.pin(joint)
    sliding = []
    for joint in moving:
        pair = coincident_point(mechanism, joint)
        if pair is not None:
            guide, carrier = pair[0], Carrier(*pair[1:])
            point = naming.at(carrier) or naming.add(None, [carrier])
            straight = isinstance(joint, Prismatic)
            sliding.append(SlidingPair(guide, f"{point.name}{naming.numbers[guide]}", point.name, carrier, straight))
    for observed in mechanism.observed:
        carrier = Carrier(observed.body, observed.point)
        if naming.at(carrier) is None:
            naming.add(observed.name, [carrier], joined=False)
    contacts = [RollingContact(naming.letter(), joint) for joint in naming.joints if isinstance(joint, Mesh)]
    return LinkagePoints(tuple(naming.points), tuple(sliding), tuple(contacts))


class _Naming:
    """Points found so far."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self.numbers = numbers = link_numbers(mechanism)
        self.joints = sorted(mechanism.joints, key=lambda j: (*sorted((numbers[j.a], numbers[j.b])), j.name))
        self.points: list[NamedPoint] = []
        self._taken = {name for joint in self.joints if (name := _short(joint))}
        self._taken |= {observed.name for observed in mechanism.observed}

    def at(self, carrier: Carrier) -> NamedPoint | None:
        """The point that a place on a link is, if it has a name."""
        return next((point for point in self.points if any(_same(other, carrier) for other in point.carriers)), None)

    def pin(self, joint: Revolute) -> None:
        """Name a pin, or add its other link to the one that it shares a place with."""
        carriers = [Carrier(joint.a, joint.point_a), Carrier(joint.b, joint.point_b)]
        here = next((point for carrier in carriers if (point := self.at(carrier))), None)
        if here is None:
            self.add(_short(joint), carriers)
        else:
            new = [carrier for carrier in carriers if carrier not in here.carriers]
            self.points[self.points.index(here)] = replace(here, carriers=self._ordered([*here.carriers, *new]))

    def add(self, name: str | None, carriers: list[Carrier], joined: bool = True) -> NamedPoint:
        """Name a point; without a name it gets that of an observed point, or a letter."""
        observed = {o.name: Carrier(o.body, o.point) for o in self._mechanism.observed}
        here = (o for o, at in observed.items() if any(_same(carrier, at) for carrier in carriers))
        name = name or next(here, None) or self.letter()
        self._taken.add(name)
        self.points.append(NamedPoint(name, self._ordered(carriers), joined))
        return self.points[-1]

    def letter(self) -> str:
        """The next letter that nothing is called by."""
        letter = next(letter for letter in _letters() if letter not in self._taken)
        self._taken.add(letter)
        return letter

    def _ordered(self, carriers: list[Carrier]) -> tuple[Carrier, ...]:
        return tuple(sorted(carriers, key=lambda c: (self._mechanism.guide(c.link) is None, self.numbers[c.link])))


def _same(first: Carrier, second: Carrier) -> bool:
    return first.link == second.link and math.dist(first.point, second.point) <= SAME


def _short(joint: Joint) -> str | None:
    return joint.name if isinstance(joint, Revolute) and len(joint.name) <= 2 and joint.name != POLE else None


def _letters() -> Iterator[str]:
    letters = [letter for letter in string.ascii_uppercase if letter != POLE]
    yield from letters
    yield from (letter + "'" * k for k in count(1) for letter in letters)
