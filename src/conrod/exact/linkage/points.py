"""The points of a linkage that a velocity or acceleration polygon is about, with letters as a course gives them.

The points in which links roll on each other, in velocity and acceleration polygons.
"""

from __future__ import annotations

import math
import string
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count

from conrod.exact.linkage.accelerations import coincident_point, rolling_acceleration
from conrod.exact.linkage.centres import SAME, joint_centre
from conrod.exact.linkage.state import LinkageState, link_numbers
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Joint, Mechanism, Mesh, Point, Prismatic, Revolute

POLE = "O"  # of a polygon


@dataclass(frozen=True)
class Carrier:
    """A link with the place [m] of a point in its frame."""

    link: str
    point: Point


@dataclass(frozen=True)
class NamedPoint:
    """A point of a linkage.

    Attributes:
        name: its letter, or what it is called in the mechanism.
        carriers: the links that it is a point of, those that the ground guides first.
        joined: whether links meet there; else it is a point of one link that is only looked at.
        fixed: whether the other link that it rolls on is the ground.
    """

    name: str
    carriers: tuple[Carrier, ...]
    joined: bool = True
    fixed: bool = False


@dataclass(frozen=True)
class SlidingPair:
    """A point of a link, and the point of its guide that it coincides with.

    Attributes:
        joint: name of the slide or the cam.
        guide: name of the link that carries the path.
        guide_point: name of the guide's point: the moving point's, with the guide's number.
        moving: the point that slides.
    """

    joint: str
    guide: str
    guide_point: str
    moving: NamedPoint

    def moving_carrier(self, mechanism: Mechanism) -> Carrier:
        """The moving point on the link that slides in the guide."""
        joint = next(joint for joint in mechanism.joints if joint.name == self.joint)
        return next(c for c in self.moving.carriers if c.link in {joint.a, joint.b} and c.link != self.guide)


@dataclass(frozen=True)
class RollingContact:
    """The contact of two links that roll on each other, another point of both at every crank angle.

    Attributes:
        name: its letter.
        joint: the pair that rolls.
    """

    name: str
    joint: Mesh

    @property
    def on_ground(self) -> bool:
        """True where one of the two is the ground."""
        return GROUND in (self.joint.a, self.joint.b)


@dataclass(frozen=True)
class LinkagePoints:
    """All moving points that a polygon shows, from the crank on, those that coincide in slides and cams, contacts."""

    points: tuple[NamedPoint, ...]
    pairs: tuple[SlidingPair, ...]
    contacts: tuple[RollingContact, ...]


def pivot_of(mechanism: Mechanism, link: str) -> Point | None:
    """The pin [m] that a link turns about on the ground, in the link's frame; None where there is none."""
    for joint in mechanism.joints:
        if isinstance(joint, Revolute) and {joint.a, joint.b} == {GROUND, link}:
            return joint.point_a if joint.a == link else joint.point_b
    return None


def slides_on_ground(mechanism: Mechanism, link: str) -> bool:
    """True of a slider on the ground."""
    return any(isinstance(j, Prismatic) and {j.a, j.b} == {GROUND, link} for j in mechanism.joints)


def linkage_points(mechanism: Mechanism) -> LinkagePoints:
    """Pins between moving links, points of moving slides and cams, observed points.

    A pin has its joint's name where that is one or two characters long, else the name of the observed point at its
    place, else a letter: from A on, in the order of the links' numbers.
    """
    naming = _Naming(mechanism)
    for joint in naming.joints:
        if isinstance(joint, Revolute) and GROUND not in (joint.a, joint.b):
            naming.pin(joint)
    pairs = []
    for joint in naming.joints:
        sliding = None if GROUND in (joint.a, joint.b) else coincident_point(mechanism, joint)
        if sliding is not None:
            guide, moving, point = sliding
            at = naming.at(Carrier(moving, point)) or naming.add(None, [Carrier(moving, point)])
            pairs.append((joint.name, guide, at))
    for observed in mechanism.observed:
        carrier = Carrier(observed.body, observed.point)
        if naming.at(carrier) is None:
            naming.add(observed.name, [carrier], joined=False)
    numbers = link_numbers(mechanism)
    named = []
    for name, guide, at in pairs:
        # Where the guide's point is in the guide's frame changes with the pose: it is not given here.
        named.append(SlidingPair(name, guide, f"{at.name}{numbers[guide]}", at))
    contacts = [RollingContact(naming.letter(), joint) for joint in naming.joints if isinstance(joint, Mesh)]
    return LinkagePoints(tuple(naming.points), tuple(named), tuple(contacts))


class _Naming:
    """Points found so far."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        numbers = link_numbers(mechanism)
        self._numbers = numbers
        self.joints = sorted(mechanism.joints, key=lambda j: (*sorted((numbers[j.a], numbers[j.b])), j.name))
        self.points: list[NamedPoint] = []
        self._taken = {name for joint in self.joints if (name := _short(joint))}
        self._taken |= {observed.name for observed in mechanism.observed}

    def at(self, carrier: Carrier) -> NamedPoint | None:
        """The point that a place on a link is, if it has a name."""
        for point in self.points:
            for other in point.carriers:
                if other.link == carrier.link and math.dist(other.point, carrier.point) <= SAME:
                    return point
        return None

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
        name = name or self._observed(carriers) or self.letter()
        self._taken.add(name)
        point = NamedPoint(name, self._ordered(carriers), joined)
        self.points.append(point)
        return point

    def letter(self) -> str:
        """The next letter that nothing is called by."""
        letter = next(letter for letter in _letters() if letter not in self._taken)
        self._taken.add(letter)
        return letter

    def _ordered(self, carriers: list[Carrier]) -> tuple[Carrier, ...]:
        def order(carrier: Carrier) -> tuple[bool, int]:
            return not guided(self._mechanism, carrier.link), self._numbers[carrier.link]

        return tuple(sorted(carriers, key=order))

    def _observed(self, carriers: list[Carrier]) -> str | None:
        for observed in self._mechanism.observed:
            if any(c.link == observed.body and math.dist(c.point, observed.point) <= SAME for c in carriers):
                return observed.name
        return None


def place_name(point: str) -> str:
    """The name of a point's place in a polygon, as the course has it: in small letters."""
    return point.lower()


def guided(mechanism: Mechanism, link: str) -> bool:
    """True of a link that a pin or a slide guides in the ground."""
    return pivot_of(mechanism, link) is not None or slides_on_ground(mechanism, link)


def _short(joint: Joint) -> str | None:
    return joint.name if isinstance(joint, Revolute) and len(joint.name) <= 2 and joint.name != POLE else None


def _letters() -> Iterator[str]:
    letters = [letter for letter in string.ascii_uppercase if letter != POLE]
    yield from letters
    yield from (letter + "'" * k for k in count(1) for letter in letters)


def shared_point(state: LinkageState, contact: RollingContact) -> NamedPoint:
    """The point of both links: they have one velocity there."""
    carriers = _carriers(state, contact)
    carriers.sort(key=lambda carrier: not guided(state.mechanism, carrier.link))
    return NamedPoint(contact.name, tuple(carriers))


def parted_points(state: LinkageState, contact: RollingContact) -> list[NamedPoint]:
    """The point of each moving link, with that link's number: their accelerations differ."""
    numbers = link_numbers(state.mechanism)
    return [
        NamedPoint(f"{contact.name}{numbers[carrier.link]}", (carrier,), fixed=contact.on_ground)
        for carrier in _carriers(state, contact)
    ]


def contact_vector(state: LinkageState, contact: RollingContact) -> tuple[str, tuple[str, str], Array]:
    """Name, places and value [m/s^2] of the acceleration of the one link's point against the other's."""
    numbers = link_numbers(state.mechanism)
    joint, value = contact.joint, rolling_acceleration(state, contact.joint)
    first, second = joint.a, joint.b
    if second == GROUND:
        first, second, value = second, first, -value
    one, other = (f"{contact.name}{numbers[link]}" for link in (first, second))
    if first == GROUND:
        return f"A_{other}", (POLE, place_name(other)), value
    return f"A_{other}/{one}", (place_name(one), place_name(other)), value


def _carriers(state: LinkageState, contact: RollingContact) -> list[Carrier]:
    centre = joint_centre(state, contact.joint)
    assert centre is not None
    moving = [link for link in (contact.joint.a, contact.joint.b) if link != GROUND]
    return [Carrier(link, state.links[link].own(centre[:2])) for link in moving]
