"""Forces that a given motion takes: every joint's reaction and the drive's torque, exactly.

With M q'' = Q + J^T lambda the multipliers of the joints' equations are their reactions, and that of the driver's
equation is the drive's torque. The torque is derived a second time, from energy alone, without the joints' equations or
their multipliers.

The ratio of masses that decides how fast an iteration from link to link converges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import assert_never

import numpy as np

from conrod.exact.dynamics.coordinates import load_forces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, turned
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, Mechanism, Point, Prismatic, Rack, Revolute, Rolling


@dataclass(frozen=True)
class State:
    """A motion in time: the crank's angle, rate and angular acceleration, and the time, each (T,)."""

    angle: Array
    rate: Array
    acceleration: Array
    time: Array


@dataclass(frozen=True)
class JointForces:
    """Forces of the joints and torque of the drive.

    Attributes:
        components: by joint name, then by component, (T,): of a pin "x" and "y", the force on its second body in the
            document's frame [N]; of a slide "normal" [N], on the second body along the line's normal, and "moment"
            [N m]; of a cam "contact", the push between cam and roller [N]; of what rolls "tangential", at the
            pitch point [N].
    """

    components: dict[str, dict[str, Array]]
    drive_torque: Array  # (T,) on the crank, in the sense of the crank angle [N m]


class InverseDynamics:
    """One mechanism under its weight, its constant forces and its loads."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._kinematics = kinematics

    def forces(self, state: State) -> JointForces:
        """Joint forces and drive torque in a motion; see `JointForces`."""
        return self.forces_in(*self.motion(state), state.time)

    def forces_in(self, poses: Array, rates: Array, accelerations: Array, time: Array) -> JointForces:
        """The same in a motion of all bodies (T, 3 n) at times (T,), which the joints allow; no dead centre in it."""
        mechanism = self._kinematics.mechanism
        right = inertia_forces(mechanism, poses, rates, accelerations) - load_forces(mechanism, poses, rates, time)
        transposed = np.swapaxes(self._kinematics.jacobian(poses), 1, 2)
        multipliers = np.linalg.solve(transposed, right[:, :, None])[:, :, 0]
        return self.forces_of(np.asarray(multipliers, dtype=float))

    def forces_of(self, multipliers: Array) -> JointForces:
        """Multipliers (T, 3 n) of all equations by joint and component."""
        mechanism = self._kinematics.mechanism
        by_joint = _by_joint(mechanism, multipliers)
        components = {
            joint.name: dict(zip(component_names(joint), by_joint[joint.name].T, strict=True))
            for joint in mechanism.joints
        }
        return JointForces(components, mechanism.driver.sense * multipliers[:, -1])

    def motion(self, state: State) -> tuple[Array, Array, Array]:
        """Poses, rates and accelerations of all bodies, each (T, 3 n)."""
        poses, first, second = self._kinematics.derivatives(state.angle, 2)
        rate, acceleration = state.rate[:, None], state.acceleration[:, None]
        return poses, first * rate, first * acceleration + second * rate**2


def component_names(joint: Joint) -> tuple[str, ...]:
    """Of a joint's reaction, in the order of its equations."""
    match joint:
        case Revolute():
            return "x", "y"
        case Prismatic():
            return "normal", "moment"
        case CamContact():
            return ("contact",)
        case Rolling() | Rack():
            return ("tangential",)
        case _:
            assert_never(joint)


@dataclass(frozen=True)
class Reactions:
    """Multipliers of the joint equations over the motion.

    Attributes:
        joints: by joint name (T, k): the force [N] along each of its equations (a slide's second one is a torque).
    """

    joints: dict[str, Array]
    drive_torque: Array  # (T,) [N m], on the crank body, counter-clockwise


def reactions(kinematics: Kinematics, angle: Array, speed: float) -> Reactions:
    """Reactions in the exact motion at constant crank speed, at crank angles (T,) [rad]; loads are among the forces."""
    poses, first, second = kinematics.derivatives(angle, 2)
    mechanism, rates = kinematics.mechanism, first * speed
    right = inertia_forces(mechanism, poses, rates, second * speed**2)
    right -= load_forces(mechanism, poses, rates, angle / speed)
    multipliers = kinematics.solve_transposed(poses, right)
    return Reactions(_by_joint(mechanism, multipliers), multipliers[:, -1])


def _by_joint(mechanism: Mechanism, multipliers: Array) -> dict[str, Array]:
    """Multipliers of each joint's equations (T, k), of those of all equations (T, 3 n); the last is the driver's."""
    ends = np.cumsum([len(component_names(joint)) for joint in mechanism.joints])
    parts = np.split(multipliers, ends, axis=1)
    return {joint.name: part for joint, part in zip(mechanism.joints, parts, strict=False)}


def inertia_forces(mechanism: Mechanism, poses: Array, rates: Array, accelerations: Array) -> Array:
    """M q'' - Q of every body, about the origin of its frame, of a state in time; (T, 3 n)."""
    result = np.zeros_like(poses)
    for i, body in enumerate(mechanism.bodies):
        rx, ry = turned(body.centre_of_gravity, poses[:, 3 * i + 2])
        spin, turn = rates[:, 3 * i + 2], accelerations[:, 3 * i + 2]
        push = mechanism.push_on(body.name)
        ax = accelerations[:, 3 * i] - turn * ry - spin**2 * rx
        ay = accelerations[:, 3 * i + 1] + turn * rx - spin**2 * ry
        fx = body.mass * (ax - mechanism.gravity[0]) - push[0]
        fy = body.mass * (ay - mechanism.gravity[1]) - push[1]
        result[:, 3 * i], result[:, 3 * i + 1] = fx, fy
        result[:, 3 * i + 2] = body.inertia * turn + rx * fy - ry * fx
    return result


def mass_ratio(mechanism: Mechanism) -> float:
    """Heaviest link over the lightest that a joint feels, the driven link apart; 1 where that is alone."""
    masses = [body.mass for body in mechanism.bodies if body.name != mechanism.crank]
    felt = [
        _felt_mass(mechanism, body, point)
        for joint in mechanism.joints
        if isinstance(joint, Revolute)
        for body, point in ((joint.a, joint.point_a), (joint.b, joint.point_b))
        if body not in (GROUND, mechanism.crank)
    ]
    return max(masses) / min([*masses, *felt]) if masses else 1.0


def _felt_mass(mechanism: Mechanism, name: str, point: Point) -> float:
    """Mass [kg] of a link as felt at a point: 1 / (1/m + d^2/I), d from its centre of gravity."""
    body = mechanism.body(name)
    if any(isinstance(joint, Prismatic) for joint in mechanism.joints_on(name)):
        return body.mass  # cannot turn
    distance = math.hypot(point[0] - body.centre_of_gravity[0], point[1] - body.centre_of_gravity[1])
    return 1.0 / (1.0 / body.mass + distance**2 / body.inertia)
