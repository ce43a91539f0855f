"""Forces that the joints carry in the exact motion: what a soft constraint gives way to.

With M q'' = Q + J^T lambda, the multipliers of the joint equations are the joint reactions, by the direction of each
equation, and that of the driver's equation is the drive torque.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.dynamics.coordinates import load_forces
from conrod.kinematics import Kinematics
from conrod.mechanism import Mechanism
from conrod.motion import Array


@dataclass(frozen=True)
class Reactions:
    """Multipliers of the joint equations over the motion.

    Attributes:
        joints: by joint name (T, k): the force [N] along each of its equations (a slide's second one is a torque).
        drive_torque: (T,) [N m], on the crank body, counter-clockwise.
    """

    joints: dict[str, Array]
    drive_torque: Array


def reactions(kinematics: Kinematics, angle: Array, speed: float) -> Reactions:
    """Reactions in the exact motion at constant crank speed, at crank angles (T,) [rad]; loads are among the forces."""
    poses, first, second = kinematics.derivatives(angle, 2)
    mechanism, rates = kinematics.mechanism, first * speed
    right = inertia_forces(mechanism, poses, rates, second * speed**2)
    right -= load_forces(mechanism, poses, rates, angle / speed)
    multipliers = kinematics.solve_transposed(poses, right)
    joints, row = {}, 0
    for joint in mechanism.joints:
        rows = kinematics.equations_of(joint)
        joints[joint.name] = multipliers[:, row : row + rows]
        row += rows
    return Reactions(joints, multipliers[:, row])


def inertia_forces(mechanism: Mechanism, poses: Array, rates: Array, accelerations: Array) -> Array:
    """M q'' - Q of every body, about the origin of its frame, of a state in time; (T, 3 n)."""
    pushes = {force.body: force.force for force in mechanism.forces}
    result = np.zeros_like(poses)
    for i, body in enumerate(mechanism.bodies):
        (cx, cy), phi = body.centre_of_gravity, poses[:, 3 * i + 2]
        rx, ry = np.cos(phi) * cx - np.sin(phi) * cy, np.sin(phi) * cx + np.cos(phi) * cy
        spin, turn = rates[:, 3 * i + 2], accelerations[:, 3 * i + 2]
        push = pushes.get(body.name, (0.0, 0.0))
        ax = accelerations[:, 3 * i] - turn * ry - spin**2 * rx
        ay = accelerations[:, 3 * i + 1] + turn * rx - spin**2 * ry
        fx = body.mass * (ax - mechanism.gravity[0]) - push[0]
        fy = body.mass * (ay - mechanism.gravity[1]) - push[1]
        result[:, 3 * i], result[:, 3 * i + 1] = fx, fy
        result[:, 3 * i + 2] = body.inertia * turn + rx * fy - ry * fx
    return result
