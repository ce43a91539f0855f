"""Drift of pymunk's joints, of whose error a step mends only a share.

In cpSpaceStep positions move first, x_(n+1) = x_n + h v_n; then every joint's preStep asks for the velocity
-(1 - bias^h) C / h that mends a share of its error C (bias_coef in Chipmunk's constraint headers), and the iteration
makes v_(n+1) fit all of them. What is left after the next step is therefore

    C_(n+1) = C(x_n + h v_n) = bias^h C_n + D_n,     D_n = h^2/2 J' v + ... ,

D_n being what the straight step departs from the curve that the joint prescribes. Where the curvature J' v changes
slowly against 1 / (-ln bias), C = h J' v / (2 (-ln bias)): of first order in h. Without a bias C = D, of second order.
The crank's speed and the n - 1 joints determine all velocities, so that no mass and no force is in it, once the
iteration has converged.
"""

from __future__ import annotations

import numpy as np

from conrod.engines.capabilities import Softness
from conrod.engines.engine import Machine
from conrod.engines.massless_rod import model_form
from conrod.engines.open_joints import SAMPLES, TURNS, OpenJoints
from conrod.engines.pymunk.built import shaft_centred
from conrod.engines.pymunk.points import turned
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism

LAW = "drift of the joints: bias^h of it is left at each step, and h^2/2 of the joints' curvature comes to it"


def predicted_softness(machine: Machine, settings: PymunkSettings) -> Softness | None:
    """Position error at these settings' step.

    Returns:
        None for contact, dressed models and one pass, where no joint but the driven one is held, and where the drift
        has no end.
    """
    mechanism = machine.kinematics.mechanism
    if mechanism.cam_contacts or settings.dressing or mechanism.driver.span is not None:
        return None
    joints = _Drifting(machine, settings)
    return joints.settled(joints.drifted, joints.size, LAW)


class _Drifting(OpenJoints):
    """Joints in which a share of their error is left, sampled at the steps, or at fewer instants where they are many.

    Their errors are stacked, (T, k): two of a pin or a slide, one of gears or a distance joint; the driven pin none.
    """

    def __init__(self, machine: Machine, settings: PymunkSettings) -> None:
        form = shaft_centred(model_form(machine.kinematics.mechanism, settings.rod))
        super().__init__(machine, form, min(settings.steps_per_revolution, SAMPLES))
        self._h, self._steps = settings.timestep, settings.steps_per_revolution
        self._left = settings.error_bias**self._h if settings.error_bias > 0.0 else 0.0
        replaced_by_length = {name for joint in form.distances for name in (joint.joint_a, joint.joint_b)}
        driven = form.whole.driver.joint
        self.open_rows = [
            self.rows[joint.name] + k
            for joint in form.whole.joints
            if joint.name not in replaced_by_length and joint.name != driven
            for k in range(self.kinematics.equations_of(joint))
        ]

    def drifted(self, errors: Array) -> Array:
        """Errors from a start without, where every step departs from the joints as it does from these errors."""
        poses = self.opened(errors)
        mending = -(1.0 - self._left) / self._h * errors
        rates = self.rates(poses, (self.along(poses) @ mending[:, :, None])[:, :, 0])
        moved = _moved(self.form.whole, poses, rates, self._h)
        return self._summed(self._errors(moved) - self._left * errors)

    def _summed(self, departure: Array) -> Array:
        steps = 2.0 * np.pi / self._steps * np.arange(TURNS * self._steps + 1)
        samples = np.abs(self.angle)
        summed = [self._of_a_joint(np.interp(steps, samples, column)) for column in departure.T]
        return np.column_stack([np.interp(samples, steps, column) for column in summed])

    def _of_a_joint(self, added: Array) -> Array:
        """Errors at all steps, from what each of them adds."""
        # Python's own numbers: one after another they are several times as fast as those of an array.
        left, last = self._left, 0.0
        errors = [last]
        for one in added[:-1].tolist():
            last = left * last + one
            errors.append(last)
        return np.array(errors)

    def _errors(self, poses: Array) -> Array:
        gaps = self.kinematics.residual([poses], self.angle)[:, self.open_rows]
        lengths = [self.distance(joint, [poses]).coefficients[0] - joint.length for joint in self.form.distances]
        return np.column_stack([gaps, *lengths])


def _moved(mechanism: Mechanism, poses: Array, rates: Array, h: float) -> Array:
    """Poses after a step [s] straight ahead, of the centres of gravity, which are what pymunk moves."""
    moved = poses + h * rates
    for i, body in enumerate(mechanism.bodies):
        x, y, turn = 3 * i, 3 * i + 1, 3 * i + 2
        before, after = (turned(body.centre_of_gravity, turns) for turns in (poses[:, turn], moved[:, turn]))
        moved[:, x] += before[0] - h * rates[:, turn] * before[1] - after[0]
        moved[:, y] += before[1] + h * rates[:, turn] * before[0] - after[1]
    return moved
