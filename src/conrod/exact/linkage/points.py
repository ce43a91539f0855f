"""The points of a linkage that a velocity or acceleration polygon is about, with letters as a course gives them."""

from __future__ import annotations

import math
import string
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count
from typing import NamedTuple

from conrod.exact.linkage.centres import SAME
from conrod.exact.linkage.state import link_numbers
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, Mechanism, Mesh, Point, Prismatic, Revolute, beside

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


class LinkagePoints(NamedTuple):
    """Moving points that a polygon shows, from the crank on, those that coincide in slides and cams, contacts."""

    points: tuple[NamedPoint, ...]
    pairs: tuple[SlidingPair, ...]
    contacts: dict[str, Mesh]  # where links roll on each other, by letter: another point of both at every crank angle


def linkage_points(mechanism: Mechanism) -> LinkagePoints:
    """Pins between moving links, points of moving slides and cams, observed points.

    A pin has its joint's name where that is one or two characters long, else the name of the observed point at its
    place, else a letter: from A on, in the order of the links' numbers.
    """
    numbers = link_numbers(mechanism)
    joints = sorted(mechanism.joints, key=lambda j: (*sorted((numbers[j.a], numbers[j.b])), j.name))
    moving = [joint for joint in joints if GROUND not in (joint.a, joint.b)]
    observed = {o.name: Carrier(o.body, o.point) for o in mechanism.observed}
    taken = {*map(_short, joints), *observed}
    letters = (letter for letter in _letters() if letter not in taken)
    points: list[NamedPoint] = []

    def at(carrier: Carrier) -> NamedPoint | None:
        return next((point for point in points if any(_same(other, carrier) for other in point.carriers)), None)

    def ordered(carriers: list[Carrier]) -> tuple[Carrier, ...]:
        return tuple(sorted(carriers, key=lambda c: (mechanism.guide(c.link) is None, numbers[c.link])))

    def add(name: str | None, carriers: list[Carrier], joined: bool = True) -> NamedPoint:
        here = (other for other, place in observed.items() if any(_same(carrier, place) for carrier in carriers))
        points.append(NamedPoint(name or next(here, None) or next(letters), ordered(carriers), joined))
        return points[-1]

    for joint in moving:
        if isinstance(joint, Revolute):
            carriers = [Carrier(joint.a, joint.point_a), Carrier(joint.b, joint.point_b)]
            here = next((point for carrier in carriers if (point := at(carrier))), None)
            if here is None:
                add(_short(joint), carriers)
            else:
                new = [carrier for carrier in carriers if carrier not in here.carriers]
                points[points.index(here)] = replace(here, carriers=ordered([*here.carriers, *new]))
    pairs = []
    for joint in moving:
        if (pair := coincident_point(mechanism, joint)) is not None:
            guide, carrier = pair[0], Carrier(*pair[1:])
            name = (at(carrier) or add(None, [carrier])).name
            pairs.append(SlidingPair(guide, f"{name}{numbers[guide]}", name, carrier, isinstance(joint, Prismatic)))
    for other, carrier in observed.items():
        if at(carrier) is None:
            add(other, [carrier], joined=False)
    contacts = {next(letters): joint for joint in joints if isinstance(joint, Mesh)}
    return LinkagePoints(tuple(points), tuple(pairs), contacts)


def coincident_point(mechanism: Mechanism, joint: Joint) -> tuple[str, str, Point] | None:
    """Guide, moving link and the moving link's point of a slide or a cam; None for joints in which nothing slides.

    Of a slide, the link that is a block on a pin moves, and the pin is its point: so the course draws it. Of a cam, it
    is the roller's centre, whose path in the cam is the pitch curve.
    """
    if isinstance(joint, CamContact):
        return joint.a, joint.b, joint.roller_centre
    if not isinstance(joint, Prismatic):
        return None
    for guide, moving in ((joint.a, joint.b), (joint.b, joint.a)):
        others = [other for other in mechanism.joints_on(moving) if other is not joint]
        if len(others) == 1 and isinstance(others[0], Revolute):
            return guide, moving, beside(others[0], moving)[2]
    return joint.a, joint.b, joint.point_b


def _same(first: Carrier, second: Carrier) -> bool:
    return first.link == second.link and math.dist(first.point, second.point) <= SAME


def _short(joint: Joint) -> str | None:
    return joint.name if isinstance(joint, Revolute) and len(joint.name) <= 2 and joint.name != POLE else None


def _letters() -> Iterator[str]:
    letters = [letter for letter in string.ascii_uppercase if letter != POLE]
    yield from letters
    yield from (letter + "'" * k for k in count(1) for letter in letters)
