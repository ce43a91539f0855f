"""Instant centres of the links of a mechanism, of every pair, from their exact velocities.

A centre is a point of the projective plane, (x, y, w) with w = 1 [m], or w = 0 where two links slide along each
other and it lies at infinity in the direction (x, y). The velocities of link j seen from link i, with the relative
angular velocity w_ij and the velocity v of the point of j at the origin, vanish at (-v_y, v_x) / w_ij.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, TypeAlias, assert_never

import numpy as np

from conrod.exact.linkage.state import LinkageState, left_of, link_numbers
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, Mechanism, Point, Prismatic, Rack, Revolute, Rolling

CentreKind = Literal["fixed", "permanent", "contact", "secondary"]

Pair: TypeAlias = frozenset[str]

SECONDARY: tuple[CentreKind, None] = ("secondary", None)
SAME = 1e-12  # [m]: two places on a link that are one
# A centre so many sizes of the mechanism away is the rounding of one at infinity.
FARTHEST = 1e10


@dataclass(frozen=True)
class InstantCentre:
    """The place where two links have one velocity.

    Attributes:
        kind: "fixed", a pin or a slide on the ground; "permanent", one between moving links, which moves with them but
            stays the same point of both; "contact", where one rolls on the other, a new point at every angle;
            "secondary", one that is found by Kennedy's theorem. All but the last are primary.
    """

    links: tuple[str, str]  # the two links' names, the one with the smaller number first
    name: str  # as the course writes it, O and the two links' numbers
    kind: CentreKind
    place: tuple[float, float] | None  # (x, y) [m]; None at infinity, and where the two links move as one
    direction: tuple[float, float] | None  # (x, y) of length 1 in which a centre at infinity lies; None for others


def centre_count(mechanism: Mechanism) -> int:
    """Number of instant centres, n (n - 1) / 2 of n links with the ground (document 001, equation (3.1))."""
    links = len(mechanism.bodies) + 1
    return links * (links - 1) // 2


def instant_centres(state: LinkageState) -> tuple[InstantCentre, ...]:
    """The centre of every pair of links, in the order of their numbers."""
    numbers = link_numbers(state.mechanism)
    primary = primary_joints(state.mechanism)
    found = []
    for first, second in combinations(numbers, 2):
        twist = state.links[second].twist - state.links[first].twist
        place, direction = _pole(twist, state.size, _fastest(state))
        low, high = numbers[first], numbers[second]
        name = f"O{low}{high}" if high < 10 else f"O{low},{high}"  # a comma parts numbers of two digits
        kind, joint = primary.get(frozenset((first, second)), SECONDARY)
        if place is None and direction is None and joint is not None:
            # Two links at rest to each other, as at a dead centre: their joint is still the centre.
            point = joint_centre(state, joint)
            assert point is not None
            x, y, finite = (float(value) for value in point)
            place, direction = ((x, y), None) if finite else (None, (x, y))
        found.append(InstantCentre((first, second), name, kind, place, direction))
    return tuple(found)


def _pole(twist: Array, size: float, fastest: float) -> tuple[tuple[float, float] | None, tuple[float, float] | None]:
    """Place and direction of the centre of a relative motion: one of them, or neither where it is rest."""
    turning, velocity = float(twist[0]), twist[1:]
    speed = math.hypot(*velocity)
    if max(abs(turning) * size, speed) <= fastest / FARTHEST:
        return None, None
    towards = left_of(velocity)
    if abs(turning) * size * FARTHEST <= speed:
        unit = towards / speed
        # A direction and its opposite are one point at infinity: upwards, or to the right.
        sign = -1.0 if unit[1] < -1e-12 or (abs(unit[1]) <= 1e-12 and unit[0] < 0.0) else 1.0
        return None, (float(sign * unit[0]), float(sign * unit[1]))
    return (float(towards[0] / turning), float(towards[1] / turning)), None


def joint_centre(state: LinkageState, joint: Joint) -> Array | None:
    """The centre that a joint alone gives, (x, y, 1), or (x, y, 0) at infinity; None where it gives a line only."""
    link = state.links[joint.a]
    match joint:
        case Revolute():
            return np.array([*link.place(joint.point_a), 1.0])
        case Prismatic():
            turn = link.pose[2] + joint.direction
            return np.array([-math.sin(turn), math.cos(turn), 0.0])
        case Rolling():
            # The ratio of the radii divides the line of centres, from outside where one circle holds the other.
            centre, other = link.place(joint.point_a), state.links[joint.b].place(joint.point_b)
            share = joint.radius_a / (joint.radius_a + joint.radius_b)
            return np.array([*(centre + share * (other - centre)), 1.0])
        case Rack():
            turn = state.links[joint.b].pose[2] + joint.direction
            foot = joint.radius * np.array([math.sin(turn), -math.cos(turn)])
            return np.array([*(link.place(joint.point_a) + foot), 1.0])
        case CamContact():
            return None
        case _:
            assert_never(joint)


def _fastest(state: LinkageState) -> float:
    """The largest speed [m/s] of any link, which rounding is measured by."""
    return max(
        max(abs(link.angular_velocity) * state.size, math.hypot(*link.velocity)) for link in state.links.values()
    )


def primary_joints(mechanism: Mechanism) -> dict[Pair, tuple[CentreKind, Joint]]:
    """The pairs of links whose centre a joint alone gives, with its kind and that joint.

    Where one pin holds three links, every two of them have their centre there, whichever joints were declared.
    """
    found: dict[Pair, tuple[CentreKind, Joint]] = {}
    for joint in mechanism.joints:
        pair = frozenset((joint.a, joint.b))
        match joint:
            case Revolute() | Prismatic():
                found[pair] = ("fixed" if GROUND in pair else "permanent", joint)
            case Rolling() | Rack():
                found.setdefault(pair, ("contact", joint))
            case CamContact():
                pass  # the centre lies on the common normal, but where on it the rest of the linkage decides
            case _:
                assert_never(joint)
    pins = [(j, *end) for j in mechanism.joints if isinstance(j, Revolute) for end in _ends(j)]
    for (first, link, point, one), (_, shared, other_point, other) in combinations(pins, 2):
        if link == shared and math.dist(point, other_point) <= SAME and one != other:
            fixed = GROUND in {link, one, other}
            found.setdefault(frozenset((one, other)), ("fixed" if fixed else "permanent", first))
    return found


def _ends(pin: Revolute) -> tuple[tuple[str, Point, str], tuple[str, Point, str]]:
    """Each link of a pin with its place on it, and the other link."""
    return (pin.a, pin.point_a, pin.b), (pin.b, pin.point_b, pin.a)
