"""Relative velocities of points, and the parts of their accelerations: normal, tangential and Coriolis.

Sources: document 001, chapters V and VI; Norton, *Design of Machinery*, chapters 6 and 7.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from conrod.exact.linkage.link_motion import GROUND_AT_REST, LinkMotion, left_of
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Mechanism, Point, Prismatic, Revolute
from conrod.mechanism.slide import guide_and_block

SAME_PLACE = 1e-12  # [m]: two places on a link that are one


@dataclass(frozen=True)
class RelativeMotion:
    """Motion of a point B about another point A of the same link; vectors are (2,).

    With r from A to B: V_B/A = omega x r, A^n_B/A = -omega^2 r, A^t_B/A = alpha x r (document 001, (6.1) to (6.4)).
    """

    link: str  # its name
    point: str  # B, an observed point or a pin
    about: str  # A
    places: Array  # of B and of A, (2, 2) [m]
    velocity: Array  # [m/s]
    normal: Array  # part of the acceleration along r [m/s^2]
    tangential: Array  # part of the acceleration across r [m/s^2]


@dataclass(frozen=True)
class SlidingMotion:
    """Motion of a point B that slides along a moving link, against the point B' of that link under it.

    A_B = A_B' + 2 omega x V_B/B' + A^n + A^t, with omega of the guide (document 001, (6.6)); A^n and A^t are those that
    an observer on the guide sees, across and along the path. Each array is (2,).
    """

    point: str  # B, the pin of a block or the centre of a roller
    link: str  # of the block or the roller
    guide: str  # the link along which it slides
    place: Array  # of B [m]
    velocity: Array  # V_B/B' [m/s]
    coriolis: Array  # [m/s^2]
    normal: Array  # [m/s^2], 0 in a straight slot
    tangential: Array  # [m/s^2]


def relative_motions(mechanism: Mechanism, links: Sequence[LinkMotion]) -> tuple[RelativeMotion, ...]:
    """Motions of every pair of pins and observed points on each moving link."""
    found = []
    for link in links:
        omega, alpha = link.rate[2], link.acceleration[2]
        for (about, first), (point, second) in combinations(_points_on(mechanism, link.link), 2):
            places = np.array([link.place(second), link.place(first)])
            r = places[0] - places[1]
            parts = omega * left_of(r), -(omega**2) * r, alpha * left_of(r)
            found.append(RelativeMotion(link.link, point, about, places, *parts))
    return tuple(found)


def sliding_motions(mechanism: Mechanism, links: Sequence[LinkMotion]) -> tuple[SlidingMotion, ...]:
    """Motions of all blocks and rollers that slide along a moving link; along the ground no Coriolis part arises."""
    motions = {link.link: link for link in (GROUND_AT_REST, *links)}
    found = []
    for joint in mechanism.joints:
        if isinstance(joint, Prismatic):
            slide = guide_and_block(mechanism, joint)
            guide, carrier, point = motions[slide.guide], motions[slide.moving], slide.point
            turn = guide.pose[2] + slide.direction
            along: Array | None = np.array([math.cos(turn), math.sin(turn)])
        elif isinstance(joint, CamContact):
            guide, carrier, point, along = motions[joint.a], motions[joint.b], joint.roller_centre, None
        else:
            continue
        if guide.link != GROUND:
            name = _point_name(mechanism, carrier.link, point) or carrier.link
            found.append(_sliding_motion(name, point, carrier, guide, along))
    return tuple(found)


def _sliding_motion(
    name: str, point: Point, carrier: LinkMotion, guide: LinkMotion, along: Array | None
) -> SlidingMotion:
    """Motion of a carrier's point along a guide; `along` is the unit vector of a straight path (2,)."""
    place = carrier.place(point)
    velocity = carrier.point_velocity(place) - guide.point_velocity(place)
    coriolis = 2.0 * guide.rate[2] * left_of(velocity)
    seen = carrier.point_acceleration(place) - guide.point_acceleration(place) - coriolis
    if along is None:
        # The path of a roller's centre has the direction of its velocity.
        along = velocity / (float(np.linalg.norm(velocity)) or 1.0)
    tangential = float(seen @ along) * along
    return SlidingMotion(name, carrier.link, guide.link, place, velocity, coriolis, seen - tangential, tangential)


def _points_on(mechanism: Mechanism, link: str) -> list[tuple[str, Point]]:
    """Pins and observed points on a link, each place once: name and place in the link's frame [m].

    Pins on the ground come first, so that other points move about them.
    """
    pins = [joint for joint in mechanism.joints_on(link) if isinstance(joint, Revolute)]
    pins.sort(key=lambda pin: GROUND not in (pin.a, pin.b))
    places = [pin.point_a if pin.a == link else pin.point_b for pin in pins]
    places += [observed.point for observed in mechanism.observed if observed.body == link]
    once = [place for k, place in enumerate(places) if all(math.dist(place, one) > SAME_PLACE for one in places[:k])]
    return [(_point_name(mechanism, link, place) or link, place) for place in once]


def _point_name(mechanism: Mechanism, link: str, place: Point) -> str | None:
    """Name of the observed point at a place of a link or of a link that is pinned there, else of the pin there."""
    pins = [
        joint
        for joint in mechanism.joints_on(link)
        if isinstance(joint, Revolute)
        and math.dist(joint.point_a if joint.a == link else joint.point_b, place) <= SAME_PLACE
    ]
    carriers = [(link, place), *((pin.a, pin.point_a) for pin in pins), *((pin.b, pin.point_b) for pin in pins)]
    for observed in mechanism.observed:
        if any(observed.body == body and math.dist(observed.point, one) <= SAME_PLACE for body, one in carriers):
            return observed.name
    return pins[0].name if pins else None
