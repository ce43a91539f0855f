"""Exact sensitivities of drive torque and reactions to masses.

Drive torque and reactions are the multipliers of M q'' - Q = J^T lambda. J has no mass in it, so the derivative by a
mass, a place of a centre of gravity or an inertia solves the same equations with that of M q'' - Q on the left.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from conrod.exact.dynamics.inverse import InverseDynamics, JointForces, State
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, turned
from conrod.mechanism.mechanism import Body, Mechanism

MASS, CENTRE_X, CENTRE_Y, INERTIA = "mass", "centre_of_gravity.x", "centre_of_gravity.y", "inertia"
PROPERTIES = (MASS, CENTRE_X, CENTRE_Y, INERTIA)
TORQUE = "drive torque"
# Changes that are to be seen: 1 % of a mass, 1 % of a length, 5 % of an inertia.
MASS_STEP, LENGTH_STEP, INERTIA_STEP = 0.01, 0.01, 0.05
# Of a quantity's peak, what a change that is to be seen must make: far above rounding, far below any engine.
SEEN = 1e-10


@dataclass(frozen=True)
class Sensitivity:
    """Of all quantities to one property of one body.

    Attributes:
        derivatives: by the name of the quantity, "drive torque" or "joint.component", (T,), by the property.
    """

    body: str
    quality: str
    change: float  # of the property, that is to be seen [kg], [m] or [kg m^2]
    derivatives: dict[str, Array]


def sensitivities(kinematics: Kinematics, state: State) -> Iterator[Sensitivity]:
    """Of drive torque and reactions in a motion, to each property of each body, one after the other."""
    mechanism, inverse = kinematics.mechanism, InverseDynamics(kinematics)
    poses, rates, accelerations = inverse.motion(state)
    factors = kinematics.factors(poses)
    for body in mechanism.bodies:
        by_name = _derivatives(mechanism, body, poses, rates, accelerations)
        for name, right in by_name.items():
            derivatives = quantities(inverse.forces_of(factors.solve_transposed(list(right.T))))
            yield Sensitivity(body.name, name, _change(kinematics, body, name), derivatives)


def quantities(forces: JointForces) -> dict[str, Array]:
    """Drive torque and the components of reactions by name, each (T,)."""
    reactions = {f"{joint}.{name}": value for joint, some in forces.components.items() for name, value in some.items()}
    return {TORQUE: forces.drive_torque} | reactions


def _derivatives(
    mechanism: Mechanism, body: Body, poses: Array, rates: Array, accelerations: Array
) -> dict[str, Array]:
    """Of M q'' - Q, each (T, 3 n), as `conrod.exact.dynamics.inverse.inertia_forces` has it."""
    i = 3 * mechanism.body_index[body.name]
    phi = poses[:, i + 2]
    push = mechanism.push_on(body.name)
    spin, turn = rates[:, i + 2], accelerations[:, i + 2]
    rx, ry = turned(body.centre_of_gravity, phi)
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


def _change(kinematics: Kinematics, body: Body, name: str) -> float:
    match name:
        case "mass":
            return MASS_STEP * body.mass
        case "inertia":
            return INERTIA_STEP * body.inertia
        case _:
            return LENGTH_STEP * _length(kinematics, body)


def _length(kinematics: Kinematics, body: Body) -> float:
    """Largest distance [m] of a joint on the body from its origin; the size of the mechanism where there is none."""
    ends = []
    for joint in kinematics.mechanism.joints:
        for name, point in ((joint.a, "point_a"), (joint.b, "point_b")):
            if name == body.name:
                ends.append(math.hypot(*getattr(joint, point, (0.0, 0.0))))
    return max(ends, default=0.0) or kinematics.size
