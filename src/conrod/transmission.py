"""How well a mechanism passes force on: the transmission angle of its driven links."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from conrod.joint_equations import pose_jets
from conrod.kinematics import Kinematics
from conrod.mechanism import GROUND, Mechanism, Point, Prismatic, Revolute
from conrod.motion import Array

SAMPLES = 3600


def least_transmission_angle(kinematics: Kinematics) -> float | None:
    """Least transmission angle [rad] over a turn; None where no link is driven through a rod or a cam.

    The angle between the line along which a driven link is pushed (through both pins of a connecting rod, or normal
    to a cam) and the normal to the path of the point that is pushed (Alt's definition; for a cam it is 90 degrees
    minus the pressure angle). At zero the mechanism is locked.
    """
    poses = kinematics.poses(np.linspace(0.0, 2.0 * np.pi, SAMPLES, endpoint=False))
    sines = [float(along.min()) for along in _along_path(kinematics, poses)]
    return math.asin(min([1.0, *sines])) if sines else None


def _along_path(kinematics: Kinematics, poses: Array) -> Iterator[Array]:
    """For each push its share (T,) along the path of the point that is pushed."""
    mechanism = kinematics.mechanism
    row = 0
    for joint in mechanism.joints:
        rows = kinematics.equations_of(joint)
        if joint in mechanism.cam_contacts:
            column = 3 * mechanism.body_index[joint.b]
            path = _path(mechanism, poses, joint.b, joint.roller_centre)
            if path is not None:
                yield _share(kinematics.jacobian(poses)[:, row, column : column + 2], path)
        row += rows
    for rod in mechanism.bodies:
        ends = _rod_ends(mechanism, rod.name)
        for driven, point, own, other in ends:
            path = _path(mechanism, poses, driven, point)
            if path is not None:
                yield _share(_place(mechanism, poses, rod.name, own) - _place(mechanism, poses, rod.name, other), path)


def _rod_ends(mechanism: Mechanism, name: str) -> list[tuple[str, Point, Point, Point]]:
    """Of a body with two pins and nothing else: each driven partner, its pin, and the rod's own pin and other pin."""
    joints = [j for j in mechanism.joints if name in (j.a, j.b)]
    if len(joints) != 2:
        return []
    ends = []
    for joint in joints:
        if not isinstance(joint, Revolute):
            return []
        own, partner = (joint.point_a, joint.b) if joint.a == name else (joint.point_b, joint.a)
        ends.append((partner, joint.point_b if joint.a == name else joint.point_a, own))
    if any(partner == GROUND for partner, _, _ in ends):
        return []
    return [
        (partner, point, own, ends[1 - k][2])
        for k, (partner, point, own) in enumerate(ends)
        if partner != mechanism.crank
    ]


def _path(mechanism: Mechanism, poses: Array, name: str, point: Point) -> Array | None:
    """Direction (T, 2) in which a point of a body that is guided by the ground moves; None where it is not."""
    for joint in mechanism.joints:
        if {joint.a, joint.b} != {GROUND, name}:
            continue
        if isinstance(joint, Prismatic):
            direction = np.array([math.cos(joint.direction), math.sin(joint.direction)])
            return np.broadcast_to(direction, (len(poses), 2))
        if isinstance(joint, Revolute):
            pivot = joint.point_a if joint.a == GROUND else joint.point_b
            arm = _place(mechanism, poses, name, point) - np.asarray(pivot)
            return np.column_stack([-arm[:, 1], arm[:, 0]])
    return None


def _place(mechanism: Mechanism, poses: Array, name: str, point: Point) -> Array:
    x, y = pose_jets(mechanism, [poses])[name].point(point)
    return np.column_stack([np.broadcast_to(c.coefficients[0], len(poses)) for c in (x, y)])


def _share(push: Array, path: Array) -> Array:
    inner = np.abs(np.sum(push * path, axis=1))
    return np.asarray(inner / np.linalg.norm(push, axis=1) / np.linalg.norm(path, axis=1))
