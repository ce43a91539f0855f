"""Forces that a given motion takes: every joint's reaction and the drive's torque, exactly.

With M q'' = Q + J^T lambda the multipliers of the joints' equations are their reactions, and that of the driver's
equation is the drive's torque. The torque is derived a second time, from energy alone, without the joints' equations or
their multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import assert_never

import numpy as np

from conrod.dynamics.coordinates import coordinate_jet, load_forces
from conrod.joint_equations import pose_jets
from conrod.kinematics import Kinematics
from conrod.mechanism import CamContact, Joint, Prismatic, Revolute
from conrod.motion import Array
from conrod.reactions import inertia_forces
from conrod.rolling import Rack, Rolling


@dataclass(frozen=True)
class State:
    """A motion in time: the crank's angle, rate and angular acceleration, and the time, each (T,)."""

    angle: Array
    rate: Array
    acceleration: Array
    time: Array


@dataclass(frozen=True)
class JointForces:
    """What the joints carry and the drive gives.

    Attributes:
        components: by joint name, then by component, (T,): of a pin "x" and "y", the force on its second body in the
            document's frame [N]; of a slide "normal" [N], on the second body along the line's normal, and "moment"
            [N m]; of a cam "contact", the push between cam and roller [N]; of what rolls "tangential", at the
            pitch point [N].
        drive_torque: (T,) on the crank, in the sense of the crank angle [N m].
    """

    components: dict[str, dict[str, Array]]
    drive_torque: Array


class InverseDynamics:
    """One mechanism under its weight, its constant forces and its loads."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._kinematics, self._loads = kinematics, kinematics.mechanism.loads

    def forces(self, state: State) -> JointForces:
        """Joint forces and drive torque in a motion; see `JointForces`.

        Raises:
            InvalidInput: the linkage does not reach an angle.
        """
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
        components, row = {}, 0
        for joint in mechanism.joints:
            count = self._kinematics.equations_of(joint)
            told = (multipliers[:, row + k] for k in range(count))
            components[joint.name] = dict(zip(component_names(joint), told, strict=True))
            row += count
        return JointForces(components, mechanism.driver.sense * multipliers[:, row])

    def torque_from_energy(self, state: State) -> Array:
        """The drive's torque (T,) [N m] in the sense of the crank angle, by the balance of power over the crank's rate.

        T theta' = d(kinetic energy)/dt - power of weight, constant forces and loads. At rest the limit is taken:
        virtual work at rate 1 with the accelerations as they are.
        """
        poses, first, second = self._kinematics.derivatives(state.angle, 2)
        mechanism = self._kinematics.mechanism
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
        for load in self._loads:
            value, slope = coordinate_jet(load.along, along).coefficients[:2]
            torque -= load.law.force(np.asarray(value), np.asarray(slope * rate), state.time) * slope
        return torque

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
