"""How far a cam lifts its follower, exactly, and what a run made of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.kinematics import Kinematics
from conrod.mechanism import GROUND, Mechanism, Prismatic
from conrod.motion import Array

SAMPLES = 3600  # in a turn; the top of a lift is flat, so that one of them is on it, but for the square of this


@dataclass(frozen=True)
class FollowerLift:
    """The way of a follower that slides in the ground.

    Attributes:
        point: an observed point of it.
        along: direction of the slide (2,), from its lowest place.
        lowest: that place, along the direction [m].
        full: the whole lift [m].
    """

    point: str
    along: Array
    lowest: float
    full: float

    def error(self, positions: Array) -> float:
        """|largest lift reached - full lift| / full lift of positions (T, 2) [m] of the point."""
        return abs(float((positions @ self.along).max() - self.lowest) / self.full - 1.0)


def follower_lift(kinematics: Kinematics) -> FollowerLift | None:
    """The lift of the machine's first cam; None where there is none, or its follower does not slide in the ground."""
    followers = [contact.b for contact in kinematics.mechanism.cam_contacts]
    points = [o for o in kinematics.mechanism.observed if followers and o.body == followers[0]]
    if not points or not _slides(kinematics.mechanism, followers[0]):
        return None
    name = points[0].name
    places = kinematics.point_derivatives([kinematics.poses(kinematics.angles(SAMPLES))])[name][0]
    shaft = np.array(kinematics.mechanism.driven_joint.point_a)
    ends = places[np.argmax(np.linalg.norm(places - places[0], axis=1))], places[0]
    low, high = sorted(ends, key=lambda place: float(np.linalg.norm(place - shaft)))
    along = (high - low) / np.linalg.norm(high - low)
    ways = places @ along
    return FollowerLift(name, along, float(ways.min()), float(np.ptp(ways)))


def _slides(mechanism: Mechanism, body: str) -> bool:
    return any(isinstance(j, Prismatic) and {j.a, j.b} == {GROUND, body} for j in mechanism.joints)
