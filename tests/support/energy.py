"""A second derivation of the drive's torque, from the balance of power."""

from __future__ import annotations

import numpy as np

from conrod.exact.dynamics import coordinate_jet
from conrod.exact.dynamics.inverse import State
from conrod.exact.joint_equations import pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array


def torque_from_energy(kinematics: Kinematics, state: State) -> Array:
    """The drive's torque (T,) [N m] in the sense of the crank angle, by the balance of power over the crank's rate.

    T theta' = d(kinetic energy)/dt - power of weight, constant forces and loads. At rest the limit is taken:
    virtual work at rate 1 with the accelerations as they are.
    """
    poses, first, second = kinematics.derivatives(state.angle, 2)
    mechanism = kinematics.mechanism
    rate, acceleration = state.rate, state.acceleration
    along = pose_jets(mechanism, [poses, first, 0.5 * second])
    constant = {force.body: force.force for force in mechanism.forces}
    torque = np.zeros(len(poses))
    for body in mechanism.bodies:
        pose, push = along[body.name], constant.get(body.name, (0.0, 0.0))
        x, y = (jet.coefficients for jet in pose.point(body.centre_of_gravity))
        turn = pose.phi.coefficients
        fx, fy = body.mass * mechanism.gravity[0] + push[0], body.mass * mechanism.gravity[1] + push[1]
        # Kinetic energy inertia(theta) theta'^2 / 2 has the rate (inertia theta'' + inertia' theta'^2 / 2) theta'.
        inertia = body.mass * (x[1] ** 2 + y[1] ** 2) + body.inertia * turn[1] ** 2
        half_slope = 2.0 * (body.mass * (x[1] * x[2] + y[1] * y[2]) + body.inertia * turn[1] * turn[2])
        torque += inertia * acceleration + half_slope * rate**2 - fx * x[1] - fy * y[1]
    for load in mechanism.loads:
        value, slope = coordinate_jet(load.along, along).coefficients[:2]
        torque -= load.law.force(np.asarray(value), np.asarray(slope * rate), state.time) * slope
    return torque
