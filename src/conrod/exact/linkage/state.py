"""Exact motion of every link of a mechanism at one crank angle, and how the links are numbered."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from conrod.exact.joint_equations import pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, Side
from conrod.mechanism.mechanism import GROUND, Mechanism, Point, Pose, to_world

Vector: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class LinkState:
    """Motion of one link."""

    pose: Pose  # place of its frame's origin and turn [m, m, rad]
    velocity: Vector  # of its frame's origin [m/s]
    acceleration: Vector  # of its frame's origin [m/s^2]
    angular_velocity: float  # [rad/s], counter-clockwise positive
    angular_acceleration: float  # [rad/s^2]

    def place(self, point: Point) -> Array:
        """A point of the link in the document's frame; (2,) [m]."""
        return np.array(to_world(self.pose, point))

    def velocity_at(self, point: Point) -> Array:
        """Velocity of a point of the link, V + omega x r; (2,) [m/s]."""
        return np.asarray(np.array(self.velocity) + self.angular_velocity * left_of(self.arm(point)))

    def acceleration_at(self, point: Point) -> Array:
        """Acceleration of a point of the link, A + alpha x r - omega^2 r; (2,) [m/s^2]."""
        arm = self.arm(point)
        turning = self.angular_acceleration * left_of(arm) - self.angular_velocity**2 * arm
        return np.asarray(np.array(self.acceleration) + turning)

    def arm(self, point: Point) -> Array:
        """From the frame's origin to a point of the link, in the document's directions; (2,) [m]."""
        return np.asarray(self.place(point) - np.array(self.pose[:2]))

    def own(self, place: Array) -> Point:
        """The link's own coordinates [m] of a place (2,) in the document's frame."""
        x, y = place - np.array(self.pose[:2])
        c, s = math.cos(self.pose[2]), math.sin(self.pose[2])
        return (float(c * x + s * y), float(c * y - s * x))

    @property
    def twist(self) -> Array:
        """Angular velocity [rad/s], and the velocity [m/s] of the point of the link at the document's origin; (3,)."""
        at_origin = np.array(self.velocity) - self.angular_velocity * left_of(np.array(self.pose[:2]))
        return np.array([self.angular_velocity, *at_origin])


@dataclass(frozen=True)
class LinkageState:
    """Motion of all links at one crank angle, the ground included."""

    mechanism: Mechanism  # the mechanism
    size: float  # its largest coordinate [m], which lengths are compared with
    angle: float  # the crank's [rad]
    speed: float  # its rate [rad/s]
    acceleration: float  # its angular acceleration [rad/s^2]
    links: Mapping[str, LinkState]  # motion of each link, by name, in the order of `link_numbers`
    derivatives: tuple[Array, ...]  # stacked poses with their first two derivatives by the crank angle, each (1, 3 n)

    def seen_from(self, link: str, other: str, point: Point) -> tuple[Array, Array, Array]:
        """A point of another link as an observer on a link sees it move.

        Place, velocity and acceleration, each (2,) [m, m/s, m/s^2], in the link's own frame. They come from the
        derivatives of the link's own coordinates of the point, and from no formula of relative motion.
        """
        jets = pose_jets(self.mechanism, [d / math.factorial(k) for k, d in enumerate(self.derivatives)])
        frame = jets[link]
        x, y = jets[other].point(point)
        dx, dy = x - frame.x, y - frame.y
        own = (frame.cosine * dx + frame.sine * dy, frame.cosine * dy - frame.sine * dx)
        first, second = (
            np.array([math.factorial(k) * float(np.squeeze(c.coefficients[k])) for c in own]) for k in (1, 2)
        )
        place = np.array([float(np.squeeze(c.coefficients[0])) for c in own])
        return place, first * self.speed, second * self.speed**2 + first * self.acceleration


def linkage_state(
    kinematics: Kinematics, angle: float, speed: float, acceleration: float = 0.0, side: Side = "right"
) -> LinkageState:
    """Exact motion of every link at an angle, rate and angular acceleration of the crank [rad, rad/s, rad/s^2].

    Args:
        side: of a crank angle at which an acceleration jumps.
    """
    derivatives = tuple(kinematics.derivatives(np.array([angle]), 2, side))
    q, first, second = (d[0].reshape(-1, 3) for d in derivatives)
    rate, turn = first * speed, second * speed**2 + first * acceleration
    links = {GROUND: LinkState((0.0, 0.0, 0.0), (0.0, 0.0), (0.0, 0.0), 0.0, 0.0)}
    for name in list(link_numbers(kinematics.mechanism))[1:]:
        i = kinematics.mechanism.body_index[name]
        (x, y, phi), (vx, vy, w), (ax, ay, alpha) = (values[i].tolist() for values in (q, rate, turn))
        links[name] = LinkState((x, y, phi), (vx, vy), (ax, ay), w, alpha)
    return LinkageState(kinematics.mechanism, kinematics.size, angle, speed, acceleration, links, derivatives)


def link_numbers(mechanism: Mechanism) -> dict[str, int]:
    """Number of each link as a course counts them: ground 1, crank 2, then from joint to joint.

    Links that are as many joints away from the crank follow the names of the joints that lead to them, so that the
    order in which a mechanism is declared does not matter.
    """
    numbers = {GROUND: 1, mechanism.crank: 2}
    front = [mechanism.crank]
    joints = sorted(mechanism.joints, key=lambda joint: joint.name)
    while front:
        reached = []
        for name in front:
            for joint in joints:
                other = joint.b if joint.a == name else joint.a if joint.b == name else name
                if other not in numbers:
                    numbers[other] = len(numbers) + 1
                    reached.append(other)
        # What hangs on the ground alone is counted last.
        front = reached
    for name in sorted(mechanism.body_index):
        numbers.setdefault(name, len(numbers) + 1)
    return numbers


def left_of(vector: Array) -> Array:
    """A vector (..., 2) turned by a right angle, counter-clockwise: the cross product of the unit z axis with it."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)
