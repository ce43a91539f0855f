"""Forces in a machine at constant crank speed: what an engine reports, and what acts from outside by its laws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.exact.dynamics.coordinates import coordinate_jet, gradient
from conrod.exact.joint_equations import pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, turned
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.outcome import Verdict
from conrod.runs.trajectory import Instants, Outcome

DRIVE = "drive torque"
EDITED = "what the model carries beside its joints takes a part of the load"
FORM = "a distance joint stands in the engine for links whose masses it does not have"
SAMPLES = 720  # of a turn, for the work of loads: an estimate of its size


@dataclass(frozen=True)
class ForceTracks:
    """Drive torque and joint reactions of a run, with the instants that they belong to.

    Attributes:
        instants: (T,), of all values.
        drive_torque: (T,) [N m] on the crank, in the sense of the crank angle; None where it is not reported.
        joints: by joint name, then by component, (T,) each; names, signs and units as in
            `conrod.exact.dynamics.inverse.JointForces`.
        unsupported: by quantity ("drive torque", or a joint's name), why it is not reported.
        outcome: of the run; of one that did not come to its end nothing is reported.
    """

    instants: Instants
    drive_torque: Array | None
    joints: Mapping[str, Mapping[str, Array]]
    unsupported: Mapping[str, str]
    outcome: Outcome = Outcome.COMPLETED


def no_forces(mechanism: Mechanism, why: str | Verdict) -> ForceTracks:
    """The result of a run that reports no force, for one reason, or as it came to no end."""
    none, outcome = np.zeros(0), Outcome.UNSUPPORTED
    if isinstance(why, Verdict):
        outcome, why = why.outcome, f"the run ended as {why.outcome.slug}: {why.reason}"
    unreported = {DRIVE: why} | {joint.name: why for joint in mechanism.joints}
    return ForceTracks(Instants(none, none, none, none), None, {}, unreported, outcome)


def applied_forces(mechanism: Mechanism, poses: Array, rates: Array, times: Array) -> Array:
    """Force and moment on each body (T, n, 3) [N, N, N m], in the document's frame, about its centre of gravity.

    Args:
        poses, rates: of all bodies (T, 3 n).
        times: (T,) [s].
    """
    result = np.zeros((len(poses), len(mechanism.bodies), 3))
    bodies = pose_jets(mechanism, [poses, rates])
    for load in mechanism.loads:
        value, rate = coordinate_jet(load.along, bodies).coefficients
        force = np.asarray(load.law.force(np.asarray(value), np.asarray(rate), times))
        result += (force[:, None] * gradient(load.along, mechanism, bodies, len(poses))).reshape(result.shape)
    for i, body in enumerate(mechanism.bodies):
        # The gradient by a pose is about the origin of the body's frame.
        x, y = turned(body.centre_of_gravity, poses[:, 3 * i + 2])
        result[:, i, 2] -= x * result[:, i, 1] - y * result[:, i, 0]
    for name, push in mechanism.pushes.items():
        result[:, mechanism.body_index[name], :2] += push
    return result


def load_work(kinematics: Kinematics, speed: float) -> float:
    """Energy [J] that loads give and take in a turn, or over the driver's span, at a crank speed [rad/s]."""
    mechanism = kinematics.mechanism
    if not mechanism.loads:
        return 0.0
    angles, (first, last) = kinematics.angles(SAMPLES), kinematics.span
    poses, slopes = kinematics.derivatives(angles, 1)
    bodies, work = pose_jets(mechanism, [poses, slopes]), 0.0
    for load in mechanism.loads:
        value, slope = (np.asarray(c) for c in coordinate_jet(load.along, bodies).coefficients)
        power = load.law.force(value, slope * speed, angles / speed) * slope
        work += (last - first) * float(np.mean(np.abs(power)))
    return work
