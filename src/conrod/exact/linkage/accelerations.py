"""Normal, tangential and Coriolis parts of accelerations: of a point, of two points of a link, of coincident points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import assert_never

import numpy as np

from conrod.exact.linkage.centres import joint_centre
from conrod.exact.linkage.state import LinkageState, left_of
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import (
    CamContact,
    Joint,
    Mechanism,
    Mesh,
    Point,
    Prismatic,
    Rack,
    Revolute,
    Rolling,
    beside,
)

# A point slower than this share of the linkage's own speed stands still, and its path has no direction.
AT_REST = 1e-12


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

    @property
    def relative(self) -> Array:
        """A_rel, both parts together; (2,) [m/s^2]."""
        return np.asarray(self.normal + self.tangential)


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


def coincident_point(mechanism: Mechanism, joint: Joint) -> tuple[str, str, Point] | None:
    """Guide, moving link and the moving link's point of a slide or a cam; None for joints in which nothing slides.

    Of a slide, the link that is a block on a pin moves, and the pin is its point: so the course draws it. Of a cam, it
    is the roller's centre, whose path in the cam is the pitch curve.
    """
    match joint:
        case Revolute() | Rolling() | Rack():
            return None
        case Prismatic():
            for guide, moving in ((joint.a, joint.b), (joint.b, joint.a)):
                pins = _only_pins(mechanism, moving, joint)
                if len(pins) == 1:
                    return guide, moving, pins[0]
            return joint.a, joint.b, joint.point_b
        case CamContact():
            return joint.a, joint.b, joint.roller_centre
        case _:
            assert_never(joint)


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


def _only_pins(mechanism: Mechanism, body: str, slide: Joint) -> list[Point]:
    """Pins of a body to moving links, if it has no joint but these and a slide."""
    others = [joint for joint in mechanism.joints_on(body) if joint is not slide]
    pins = [beside(joint, body)[2] for joint in others if isinstance(joint, Revolute)]
    return pins if len(pins) == len(others) == 1 else []


def _direction(vector: Array) -> Array:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else np.array([1.0, 0.0])
