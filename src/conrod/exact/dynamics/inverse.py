"""Inverse dynamics: every joint's reaction and the drive's torque in a given motion, exactly.

With M q'' = Q + J^T lambda the multipliers of the joints' equations are their reactions, and that of the driver's
equation is the drive's torque. The torque is checked from energy alone, without the joints' equations or their
multipliers.

Sensitivities to mass properties p: J does not depend on masses, so d lambda / dp solves J^T d lambda / dp =
d(M q'' - Q) / dp.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import assert_never

import numpy as np

from conrod.exact.dynamics import load_forces
from conrod.exact.equations import inertia_forces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, Instants, rotate_planar
from conrod.mechanism.mechanism import (
    GROUND,
    Body,
    CamContact,
    Joint,
    Mechanism,
    Point,
    Prismatic,
    Rack,
    Revolute,
    Rolling,
)

MASS, CENTRE_X, CENTRE_Y, INERTIA = "mass", "centre_of_gravity.x", "centre_of_gravity.y", "inertia"
PROPERTIES = (MASS, CENTRE_X, CENTRE_Y, INERTIA)
TORQUE = "drive torque"
# Errors of mass properties that a comparison has to detect: 1 % of a mass, 1 % of a length, 5 % of an inertia.
MASS_STEP, LENGTH_STEP, INERTIA_STEP = 0.01, 0.01, 0.05
# Share of a quantity's peak that a detectable error changes: far above rounding, far below any engine's error.
MIN_RELATIVE_CHANGE = 1e-10


@dataclass(frozen=True)
class JointForces:
    """Reaction forces of the joints and torque of the drive.

    Attributes:
        components: (T,) by joint name, then by component: of a pin "x" and "y", the force on its second body in the
            document's frame [N]; of a slide "normal" [N], on the second body along the line's normal, and "moment"
            [N m]; of a cam "contact", the push between cam and roller [N]; of a rolling pair "tangential", at the
            pitch point [N].
    """

    components: dict[str, dict[str, Array]]
    drive_torque: Array  # (T,) on the crank, in the sense of the crank angle [N m]


def joint_forces(kinematics: Kinematics, state: Instants) -> JointForces:
    """Joint forces and drive torque for a motion of the crank."""
    return joint_forces_of_motion(kinematics, *motion_of_bodies(kinematics, state), state.times)


def joint_forces_of_motion(
    kinematics: Kinematics, poses: Array, rates: Array, accelerations: Array, time: Array
) -> JointForces:
    """Joint forces and drive torque for a motion of all bodies.

    Args:
        poses, rates, accelerations: motion (T, 3 n) of the bodies that satisfies the joints, away from dead centres.
        time: (T,) [s].
    """
    mechanism = kinematics.mechanism
    right = inertia_forces(mechanism, poses, rates, accelerations) - load_forces(mechanism, poses, rates, time)
    transposed = np.swapaxes(kinematics.jacobian(poses), 1, 2)
    return _joint_forces_from(mechanism, np.asarray(np.linalg.solve(transposed, right[:, :, None])[:, :, 0]))


def steady_joint_forces(kinematics: Kinematics, angle: Array, speed: float) -> JointForces:
    """Joint forces at constant crank speed [rad/s] and crank angles (T,) [rad]; faster than `joint_forces`."""
    poses, first, second = kinematics.derivatives(angle, 2)
    mechanism, rates = kinematics.mechanism, first * speed
    right = inertia_forces(mechanism, poses, rates, second * speed**2)
    right -= load_forces(mechanism, poses, rates, angle / speed)
    return _joint_forces_from(mechanism, kinematics.factors(poses).solve_transposed(list(right.T)))


def motion_of_bodies(kinematics: Kinematics, state: Instants) -> tuple[Array, Array, Array]:
    """Poses, rates and accelerations of all bodies, each (T, 3 n), for a motion of the crank."""
    poses, first, second = kinematics.derivatives(state.angle, 2)
    rate, acceleration = state.rate[:, None], state.acceleration[:, None]
    return poses, first * rate, first * acceleration + second * rate**2


def _joint_forces_from(mechanism: Mechanism, multipliers: Array) -> JointForces:
    """Sort multipliers (T, 3 n) of all equations by joint and component; the driver's is the last."""
    columns = iter(multipliers.T)
    components = {joint.name: {name: next(columns) for name in component_names(joint)} for joint in mechanism.joints}
    return JointForces(components, mechanism.driver.sense * multipliers[:, -1])


def component_names(joint: Joint) -> tuple[str, ...]:
    """Names of the components of a joint's reaction, in the order of its equations."""
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


def mass_ratio(mechanism: Mechanism) -> float:
    """Mass of the heaviest link over the lightest one felt at a joint, without the crank; 1 if it is alone."""
    masses = [body.mass for body in mechanism.bodies if body.name != mechanism.crank]
    felt = [
        _effective_mass(mechanism, body, point)
        for joint in mechanism.joints
        if isinstance(joint, Revolute)
        for body, point in ((joint.a, joint.point_a), (joint.b, joint.point_b))
        if body not in (GROUND, mechanism.crank)
    ]
    return max(masses) / min([*masses, *felt]) if masses else 1.0


def _effective_mass(mechanism: Mechanism, name: str, point: Point) -> float:
    """Mass [kg] of a link as felt at a point: 1 / (1/m + d^2/I), with d from its centre of gravity."""
    body = mechanism.body(name)
    if any(isinstance(joint, Prismatic) for joint in mechanism.joints_on(name)):
        return body.mass  # cannot turn
    distance = math.hypot(point[0] - body.centre_of_gravity[0], point[1] - body.centre_of_gravity[1])
    return 1.0 / (1.0 / body.mass + distance**2 / body.inertia)


# -- sensitivities -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of all force quantities by one mass property of one body.

    Attributes:
        quality: name of the property, one of `PROPERTIES`.
        derivatives: (T,) by name of the quantity, "drive torque" or "joint.component".
    """

    body: str
    quality: str
    change: float  # of the property, that should be detected [kg], [m] or [kg m^2]
    derivatives: dict[str, Array]


def sensitivities(kinematics: Kinematics, state: Instants) -> Iterator[Sensitivity]:
    """Yield the derivatives of drive torque and reactions by each mass property of each body."""
    mechanism = kinematics.mechanism
    poses, rates, accelerations = motion_of_bodies(kinematics, state)
    factors = kinematics.factors(poses)
    for body in mechanism.bodies:
        changes = dict.fromkeys((CENTRE_X, CENTRE_Y), LENGTH_STEP * _body_length(kinematics, body))
        changes |= {MASS: MASS_STEP * body.mass, INERTIA: INERTIA_STEP * body.inertia}
        for name, right in _inertia_force_derivatives(mechanism, body, poses, rates, accelerations).items():
            derivatives = quantities(_joint_forces_from(mechanism, factors.solve_transposed(list(right.T))))
            yield Sensitivity(body.name, name, changes[name], derivatives)


def quantities(forces: JointForces) -> dict[str, Array]:
    """Drive torque and all components of reactions by name, each (T,)."""
    reactions = {f"{joint}.{name}": value for joint, some in forces.components.items() for name, value in some.items()}
    return {TORQUE: forces.drive_torque} | reactions


def _inertia_force_derivatives(
    mechanism: Mechanism, body: Body, poses: Array, rates: Array, accelerations: Array
) -> dict[str, Array]:
    """Derivatives (T, 3 n) of `inertia_forces` by each mass property of a body."""
    i = 3 * mechanism.body_index[body.name]
    phi = poses[:, i + 2]
    push = mechanism.constant_force_on(body.name)
    spin, turn = rates[:, i + 2], accelerations[:, i + 2]
    rx, ry = rotate_planar(body.centre_of_gravity, phi)
    ax = accelerations[:, i] - turn * ry - spin**2 * rx - mechanism.gravity[0]
    ay = accelerations[:, i + 1] + turn * rx - spin**2 * ry - mechanism.gravity[1]
    result = {name: np.zeros_like(poses) for name in PROPERTIES}
    result[MASS][:, i : i + 3] = np.column_stack([ax, ay, rx * ay - ry * ax])
    for name, (dx, dy) in {CENTRE_X: (np.cos(phi), np.sin(phi)), CENTRE_Y: (-np.sin(phi), np.cos(phi))}.items():
        # The constant force acts at the centre of gravity, and goes with it.
        fx, fy = body.mass * ax - push[0], body.mass * ay - push[1]
        gx, gy = body.mass * (-turn * dy - spin**2 * dx), body.mass * (turn * dx - spin**2 * dy)
        result[name][:, i : i + 3] = np.column_stack([gx, gy, dx * fy - dy * fx + rx * gy - ry * gx])
    result[INERTIA][:, i + 2] = turn
    return result


def _body_length(kinematics: Kinematics, body: Body) -> float:
    """Largest distance [m] of a joint from the body's origin; the mechanism's size if that is 0."""
    ends = []
    for joint in kinematics.mechanism.joints:
        for name, point in ((joint.a, "point_a"), (joint.b, "point_b")):
            if name == body.name:
                ends.append(math.hypot(*getattr(joint, point, (0.0, 0.0))))
    return max(ends, default=0.0) or kinematics.size
