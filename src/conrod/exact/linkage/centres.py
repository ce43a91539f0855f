"""Instant centres of every pair of links, from the links' exact velocities.

Sources: document 001, chapter III (Kennedy's theorem, and (3.1): n links have n (n - 1) / 2 centres); Norton, *Design
of Machinery*, chapter 6.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from conrod.exact.linkage.link_motion import GROUND_AT_REST, LinkMotion, left_of
from conrod.exact.motion import Array

# Below this share of the largest motion of a link, a relative motion is rounding; below it a relative angular velocity,
# times the mechanism's size, puts the centre at infinity.
NEGLIGIBLE = 1e-10


@dataclass(frozen=True)
class InstantCentre:
    """Point at which two links have the same velocity.

    A centre at infinity has a direction and no place; where two links stay at rest to each other it has neither.
    """

    links: tuple[str, str]  # their names, the ground first
    place: Array | None  # (2,) [m]
    direction: float | None  # in which a centre at infinity lies [rad], in [0, pi)


def instant_centres(links: Sequence[LinkMotion], size: float) -> tuple[InstantCentre, ...]:
    """Instant centres of every pair of links, the ground included.

    Where two links are at rest to each other for an instant, as at a dead centre, the centre is the limit of those just
    before and after: it follows from the relative acceleration as otherwise from the relative velocity.

    Args:
        links: the moving links, at a constant crank speed.
        size: of the mechanism [m], with which lengths are compared.
    """
    twists = {link.link: _twists(link) for link in (GROUND_AT_REST, *links)}
    scale = np.array([1.0, 1.0, size])
    least = NEGLIGIBLE * np.max([np.linalg.norm(twist * scale, axis=1) for twist in twists.values()], axis=0)
    found = []
    for pair in combinations(twists, 2):
        relative = twists[pair[1]] - twists[pair[0]]
        moving = np.linalg.norm(relative * scale, axis=1) > least
        twist = relative[0] if moving[0] else relative[1] if moving[1] else None
        found.append(InstantCentre(pair, *(None, None) if twist is None else _pole(twist, size)))
    return tuple(found)


def _twists(link: LinkMotion) -> Array:
    """Velocity of a link's point at the origin and angular velocity, (v_x, v_y, omega), and their rates; (2, 3).

    v = V - omega x r, and v' = A - alpha x r - omega x V, with r the place of the link's frame.
    """
    r, (*velocity, omega), (*acceleration, alpha) = link.pose[:2], link.rate, link.acceleration
    at_origin = velocity - omega * left_of(r)
    changing = acceleration - alpha * left_of(r) - omega * left_of(np.array(velocity))
    return np.array([[*at_origin, omega], [*changing, alpha]])


def _pole(twist: Array, size: float) -> tuple[Array | None, float | None]:
    """Place [m] of the pole of a relative motion, or the direction [rad] of a pole at infinity.

    The velocity v + omega x p vanishes at p = (-v_y, v_x) / omega; at omega = 0 all points move alike, and the pole
    lies at infinity at a right angle to v.
    """
    velocity, omega = twist[:2], float(twist[2])
    towards = left_of(velocity)
    if abs(omega) * size > NEGLIGIBLE * float(np.linalg.norm(velocity)):
        return np.asarray(towards / omega), None
    direction = math.atan2(towards[1], towards[0]) % math.pi
    return None, 0.0 if math.pi - direction < NEGLIGIBLE else direction
