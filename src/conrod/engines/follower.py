"""The exact motion of a cam's follower: its lift, and all that the laws of contact need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conrod.engines.cam_polygon import CamPolygon
from conrod.engines.engine import Machine
from conrod.exact.dynamics.inverse import reactions
from conrod.exact.joint_equations import active_arcs, pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import CamContact, Prismatic

LIFT_SAMPLES = 3600  # in a turn; the top of a lift is flat, so that one of them is on it, but for the square of this


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

    def reached(self, positions: Array) -> float:
        """Highest of positions (T, 2) [m] of the point, along the direction [m]."""
        return float((positions @ self.along).max())


def follower_lift(kinematics: Kinematics) -> FollowerLift | None:
    """The lift of the machine's first cam; None where there is none, or its follower does not slide in the ground."""
    followers = [contact.b for contact in kinematics.mechanism.cam_contacts]
    points = [o for o in kinematics.mechanism.observed if followers and o.body == followers[0]]
    if not points or not isinstance(kinematics.mechanism.guide(followers[0]), Prismatic):
        return None
    name = points[0].name
    places = kinematics.point_derivatives([kinematics.poses(kinematics.angles(LIFT_SAMPLES))])[name][0]
    shaft = np.array(kinematics.mechanism.driven_joint.point_a)
    ends = places[np.argmax(np.linalg.norm(places - places[0], axis=1))], places[0]
    low, high = sorted(ends, key=lambda place: float(np.linalg.norm(place - shaft)))
    along = (high - low) / np.linalg.norm(high - low)
    ways = places @ along
    return FollowerLift(name, along, float(ways.min()), float(np.ptp(ways)))


SAMPLES = 7200


@dataclass(frozen=True)
class FollowerMotion:
    """One turn of a translating follower; arrays are (T,).

    Attributes:
        lift: travel of the roller's centre [m].
        distance: of the roller's centre from the shaft [m].
        acceleration: along the slide [m/s^2], at the machine's speed.
        cosine: of the pressure angle, between contact normal and slide.
        force: contact force [N] in the exact motion, positive where it presses.
        arcs: index of the active arc.
        start: place of the roller's centre at crank angle 0 (2,) [m], in the cam's frame.
    """

    contact: CamContact
    lift: float
    distance: Array
    acceleration: Array
    cosine: Array
    force: Array
    arcs: NDArray[np.intp]
    start: Array

    @classmethod
    def of(cls, machine: Machine) -> FollowerMotion:
        """The motion of the machine's first cam contact."""
        kinematics = machine.kinematics
        contact = kinematics.mechanism.cam_contacts[0]
        angles = np.linspace(0.0, 2.0 * np.pi, SAMPLES, endpoint=False)
        poses, _, second = kinematics.derivatives(angles, 2)
        cam, follower = (3 * kinematics.mechanism.body_index[name] for name in (contact.a, contact.b))
        row = sum(
            kinematics.equations_of(j)
            for j in kinematics.mechanism.joints[: kinematics.mechanism.joints.index(contact)]
        )
        normal = kinematics.jacobian(poses)[:, row, follower : follower + 2]
        way = poses[:, follower : follower + 2]
        path = way[np.argmax(np.linalg.norm(way - way[0], axis=1))] - way[0]
        along = path / np.linalg.norm(path)
        cosine, sine = np.cos(poses[0, cam + 2]), np.sin(poses[0, cam + 2])
        return cls(
            contact=contact,
            lift=float(np.ptp(way @ along)),
            distance=np.linalg.norm(way - poses[:, cam : cam + 2], axis=1),
            acceleration=second[:, follower : follower + 2] @ along * machine.speed**2,
            cosine=normal @ along,
            force=reactions(kinematics, angles, machine.speed).components[contact.name]["contact"],
            arcs=active_arcs(contact, pose_jets(kinematics.mechanism, [poses])),
            start=np.array([[cosine, sine], [-sine, cosine]]) @ (way[0] - poses[0, cam : cam + 2]),
        )

    def facet_slope_rms(self, polygon: CamPolygon) -> float:
        """Root mean square error [m/rad] of the lift's slope on facets instead of arcs.

        A facet's normal is off the arc's by up to half the turn from facet to facet, evenly spread, which the
        follower sees as an error of its pressure angle: distance x off / cos^2.
        """
        return float(np.sqrt(np.mean(self._corners(polygon) ** 2 / 12.0)))

    def corner_slope_rms(self, polygon: CamPolygon, settling: float) -> float:
        """Root mean square error [m/rad] of the slope while the follower settles after each corner.

        Args:
            settling: crank angle [rad] in which a jump of the slope dies away.
        """
        share = np.minimum(1.0, settling / np.array(polygon.facet_turns))[self.arcs]
        return float(np.sqrt(np.mean(self._corners(polygon) ** 2 * share)))

    def largest_corner(self, polygon: CamPolygon) -> float:
        """Largest jump [m/rad] of the lift's slope from one facet to the next."""
        return float(self._corners(polygon).max())

    def _corners(self, polygon: CamPolygon) -> Array:
        return np.asarray(self.distance * np.array(polygon.facet_turns)[self.arcs] / self.cosine**2)
