"""Motion of one rigid link at an instant, and of any of its points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Point, to_world


@dataclass(frozen=True)
class LinkMotion:
    """Motion of one link at an instant; each array is (3,)."""

    link: str  # its name
    pose: Array  # place of its frame's origin and turn [m, m, rad]
    rate: Array  # of the pose [m/s, m/s, rad/s]
    acceleration: Array  # of the pose [m/s^2, m/s^2, rad/s^2]

    def place(self, point: Point) -> Array:
        """Place (2,) [m] of a point in the link's frame [m]."""
        x, y, phi = self.pose.tolist()
        return np.array(to_world((x, y, phi), point))

    def point_velocity(self, place: Array) -> Array:
        """Velocity (2,) [m/s] of the link's point at a place (2,) [m]: V = V_origin + omega x r."""
        return np.asarray(self.rate[:2] + self.rate[2] * left_of(place - self.pose[:2]))

    def point_acceleration(self, place: Array) -> Array:
        """Acceleration (2,) [m/s^2] of the link's point at a place [m]: A = A_origin + alpha x r - omega^2 r."""
        arm = place - self.pose[:2]
        return np.asarray(self.acceleration[:2] + self.acceleration[2] * left_of(arm) - self.rate[2] ** 2 * arm)


GROUND_AT_REST = LinkMotion(GROUND, np.zeros(3), np.zeros(3), np.zeros(3))


def left_of(vector: Array) -> Array:
    """Vector (2,) at a right angle to another, counter-clockwise: the cross product of the unit z axis with it."""
    return np.array([-vector[1], vector[0]])
