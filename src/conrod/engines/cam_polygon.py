"""Cam profiles as the convex polygons that engines collide, with their errors, and which cams engines accept.

Every facet stands off its arc by about the same sagitta, and every vertex half a sagitta outside, so that the
polygon straddles the true curve: its normal distance to it is at most half a sagitta either way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from conrod.engines.engine import Machine
from conrod.exact.dynamics.inverse import steady_joint_forces
from conrod.exact.joint_equations import active_arcs, pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.cam import CamProfile
from conrod.mechanism.cam_law import LawProfile, Profile, concave_reason
from conrod.mechanism.mechanism import GROUND, CamContact, Mechanism, Prismatic


@dataclass(frozen=True)
class CamPolygon:
    """A convex polygon that approximates a cam profile when it is rounded by `radius`.

    Attributes:
        vertices: (N, 2) [m] in the cam's frame, counter-clockwise.
        radius: inset of the polygon from the profile, to be added again as rounding of its corners [m].
        facet_turns: largest angle [rad] between the normals of neighbouring facets, for each arc of the profile (or
            segment of its motion law).
        error: bound on the normal distance between the rounded polygon and the profile [m].
    """

    vertices: Array
    radius: float
    facet_turns: tuple[float, ...]
    error: float

    def distance(self, point: Array) -> float:
        """Distance [m] of a point (2,) outside from the rounded polygon, in the cam's frame."""
        begin, edge = self.vertices, np.roll(self.vertices, -1, axis=0) - self.vertices
        share = np.clip(((point - begin) * edge).sum(axis=1) / (edge**2).sum(axis=1), 0.0, 1.0)
        return float(np.linalg.norm(begin + share[:, None] * edge - point, axis=1).min()) - self.radius


def cam_polygon(profile: Profile, vertices: int, radius: float = 0.0) -> CamPolygon:
    """Polygon of about `vertices` vertices, inset by `radius` [m], which is below the least radius of curvature."""
    if isinstance(profile, LawProfile):
        return _law_polygon(profile, vertices, radius)
    return _arc_polygon(profile, vertices, radius)


def _arc_polygon(profile: CamProfile, vertices: int, radius: float) -> CamPolygon:
    """Polygon of a profile of circular arcs, with equal facets on each arc and an even number of them.

    So a vertex lies at the middle of the dwell: the roller starts in contact, not above a facet inside the curve.
    """
    weights = np.array([math.sqrt(arc.radius - radius) * arc.extent for arc in profile.arcs])
    facets = 2 * np.maximum(1, np.rint(vertices * weights / weights.sum() / 2.0)).astype(int)
    turns = [arc.extent / n for arc, n in zip(profile.arcs, facets, strict=True)]
    sagittas = [(arc.radius - radius) * (1.0 - math.cos(t / 2.0)) for arc, t in zip(profile.arcs, turns, strict=True)]
    corners = []
    for i, (arc, n) in enumerate(zip(profile.arcs, facets, strict=True)):
        normals = np.linspace(arc.start, arc.stop, n, endpoint=False)
        outside = np.full(n, 0.5 * sagittas[i])
        outside[0] = 0.5 * min(sagittas[i], sagittas[i - 1])  # a joint's vertex belongs to two arcs
        reach = arc.radius - radius + outside
        corners.append(np.column_stack([np.cos(normals), np.sin(normals)]) * reach[:, None] + np.array(arc.centre))
    return CamPolygon(np.concatenate(corners), radius, tuple(turns), 0.5 * max(sagittas))


# Points of a segment at which the spacing of vertices is integrated, and bisection steps for the depth of a facet.
SEGMENT_POINTS, BISECTIONS = 2001, 24
CACHED_POLYGONS = 16


@lru_cache(CACHED_POLYGONS)
def _law_polygon(profile: LawProfile, vertices: int, radius: float) -> CamPolygon:
    """Polygon of a profile from a motion law, with facets of one sagitta and a vertex where segments meet.

    Between two vertices the integral of sqrt(radius of curvature) over the rotation of the normal is equal.
    """
    inset = profile.roller_radius + radius
    grids, sums = [], []
    for i, (begin, part) in enumerate(zip(profile.begins, profile.segments, strict=True)):
        grid = np.linspace(begin, begin + part.over, SEGMENT_POINTS)
        pitch = profile.pitch(grid, np.full(len(grid), i))
        # sqrt(radius) x rotation of the normal, with radius 1 / curvature - inset and rotation curvature x rate.
        density = np.sqrt(np.maximum(pitch.curvature * (1.0 - pitch.curvature * inset), 0.0)) * pitch.rate
        steps = 0.5 * (density[1:] + density[:-1]) * np.diff(grid)
        grids.append(grid)
        sums.append(np.concatenate([[0.0], np.cumsum(steps)]))
    weights = np.array([total[-1] for total in sums])
    facets = 2 * np.maximum(1, np.rint(vertices * weights / weights.sum() / 2.0)).astype(int)
    outside = 0.5 * (weights / facets) ** 2 / 8.0
    angles, owner, reach = [], [], []
    for i, n in enumerate(facets):
        angles.append(np.interp(np.linspace(0.0, weights[i], n, endpoint=False), sums[i], grids[i]))
        owner.append(np.full(n, i))
        reach.append(np.full(n, outside[i]))
        reach[i][0] = min(outside[i], outside[i - 1])  # a joint's vertex belongs to two segments
    angle, owners = np.concatenate(angles), np.concatenate(owner)
    pitch = profile.pitch(angle, owners)
    corners = pitch.points + (np.concatenate(reach) - inset)[:, None] * pitch.normals
    edges = np.roll(corners, -1, axis=0) - corners
    turns = np.abs(_cross(np.roll(edges, 1, axis=0), edges)) / (np.hypot(*edges.T) * np.hypot(*np.roll(edges, 1, 0).T))
    turn_of = [max(turns[owners == i].max(), turns[np.searchsorted(owners, i)]) for i in range(len(facets))]
    depth = _largest_depth(profile, np.append(angle, 2.0 * math.pi), owners, corners, inset)
    in_order = corners[:: -profile.sense]
    return CamPolygon(in_order, radius, tuple(float(turn) for turn in turn_of), max(float(outside.max()), depth))


def _largest_depth(profile: LawProfile, angle: Array, owners: NDArray[np.intp], corners: Array, inset: float) -> float:
    """Largest depth [m] of a facet below the curve, where the normals are parallel, by bisection."""
    edges = np.roll(corners, -1, axis=0) - corners
    across = profile.sense * np.column_stack([-edges[:, 1], edges[:, 0]]) / np.hypot(*edges.T)[:, None]
    low, high = angle[:-1].copy(), angle[1:].copy()
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        before = profile.sense * _cross(across, profile.pitch(middle, owners).normals) > 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    pitch = profile.pitch(low, owners)
    return float(np.sum((pitch.points - inset * pitch.normals - corners) * across, axis=1).max())


def _cross(first: Array, second: Array) -> Array:
    """Cross product (N,) of plane vectors (N, 2)."""
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


SUPPORTED_LAYOUT = "contact is derived for one cam, on the crank, and one follower on a slide of the ground"
CAM_AND_FOLLOWER_BODIES = 2


def contact_refusal(mechanism: Mechanism) -> str | None:
    """Return the reason why no engine can run the mechanism's cam, though its motion is solved exactly; else None."""
    for contact in mechanism.cam_contacts:
        reason = concave_reason(contact.profile)
        if reason is None and (otherwise := _layout_refusal(mechanism, contact)):
            reason = f"{SUPPORTED_LAYOUT}; {otherwise}"
        if reason:
            return reason
    return None


def _layout_refusal(mechanism: Mechanism, contact: CamContact) -> str | None:
    """Return how a cam's machine differs from the one layout for which contact is derived, else None."""
    if contact.a != mechanism.crank:
        return f"the cam of {contact.name} is on {contact.a}"
    slide = mechanism.guide(contact.b)
    if not isinstance(slide, Prismatic):
        return f"the follower {contact.b} is on no such slide"
    if slide.a != GROUND:
        return f"the guide of {slide.name} is on the follower: name the line on the ground as the guide"
    if len(mechanism.bodies) != CAM_AND_FOLLOWER_BODIES:
        return f"here {len(mechanism.bodies)} bodies move"
    return None


FOLLOWER_SAMPLES = 7200


@dataclass(frozen=True)
class FollowerMotion:
    """Exact motion and contact force of a translating follower over one revolution; arrays are (T,).

    Attributes:
        lift: travel of the roller's centre [m].
        distance: distance of the roller's centre from the shaft [m].
        acceleration: acceleration of the follower along the slide [m/s^2], at the machine's speed.
        cosine: cosine of the pressure angle, between contact normal and slide.
        force: contact force [N] in the exact motion, positive in compression.
        arcs: index of the arc (or segment) in contact.
        start: position of the roller's centre at crank angle 0 (2,) [m], in the cam's frame.
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
    def from_machine(cls, machine: Machine) -> FollowerMotion:
        """Compute the motion of the machine's first cam contact."""
        kinematics = machine.kinematics
        contact = kinematics.mechanism.cam_contacts[0]
        angles = np.linspace(0.0, 2.0 * np.pi, FOLLOWER_SAMPLES, endpoint=False)
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
            force=steady_joint_forces(kinematics, angles, machine.speed).components[contact.name]["contact"],
            arcs=active_arcs(contact, pose_jets(kinematics.mechanism, [poses])),
            start=np.array([[cosine, sine], [-sine, cosine]]) @ (way[0] - poses[0, cam : cam + 2]),
        )

    def facet_slope_rms(self, polygon: CamPolygon) -> float:
        """RMS error [m/rad] of the lift's derivative on flat facets instead of arcs.

        A facet's normal is off the arc's by up to half the angle between facets, evenly spread, which the
        follower sees as an error of its pressure angle: distance x off / cos^2.
        """
        return float(np.sqrt(np.mean(self._slope_jumps(polygon) ** 2 / 12.0)))

    def corner_slope_rms(self, polygon: CamPolygon, settling: float) -> float:
        """RMS error [m/rad] of the lift's derivative while the follower settles after each corner.

        Args:
            settling: crank angle [rad] in which a jump of the slope dies away.
        """
        share = np.minimum(1.0, settling / np.array(polygon.facet_turns))[self.arcs]
        return float(np.sqrt(np.mean(self._slope_jumps(polygon) ** 2 * share)))

    def largest_slope_jump(self, polygon: CamPolygon) -> float:
        """Largest jump [m/rad] of the lift's derivative from one facet to the next."""
        return float(self._slope_jumps(polygon).max())

    def _slope_jumps(self, polygon: CamPolygon) -> Array:
        """Jump (T,) [m/rad] of the lift's derivative at the polygon's corners, from each sample's arc."""
        return np.asarray(self.distance * np.array(polygon.facet_turns)[self.arcs] / self.cosine**2)
