"""Time histories besides driven motion that engines report: forces, and motion without a drive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.comparison.outcome import MAX_JOINT_GAP, MAX_REACH_SIZES, RunVerdict, joint_gaps
from conrod.comparison.trajectory import Outcome
from conrod.engines.numerics import CRANK_SAMPLES
from conrod.exact.dynamics import coordinate_gradient, coordinate_jet
from conrod.exact.joint_equations import pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, Instants, rotate_planar
from conrod.mechanism.loads import CONSERVATIVE
from conrod.mechanism.mechanism import Mechanism

DRIVE_TORQUE = "drive torque"
EDITED_MODEL_REASON = "what the model carries beside its joints takes a part of the load"


@dataclass(frozen=True)
class ForceTracks:
    """Drive torque and joint reactions of a run, with the instants they belong to.

    Attributes:
        instants: (T,), of all values.
        drive_torque: (T,) [N m] on the crank, in the sense of the crank angle; None if it is not reported.
        joints: by joint name, then by component, (T,) each; names, signs and units as in
            `conrod.exact.dynamics.inverse.JointForces`.
        unsupported: reason why a quantity ("drive torque", or a joint's name) is not reported, by its name.
        outcome: how the run ended; a run that failed reports no forces.
    """

    instants: Instants
    drive_torque: Array | None
    joints: Mapping[str, Mapping[str, Array]]
    unsupported: Mapping[str, str]
    outcome: Outcome = Outcome.COMPLETED


def unreported_forces(mechanism: Mechanism, why: str | RunVerdict) -> ForceTracks:
    """The result of a run that reports no forces, with the reason, or the verdict that ended the run."""
    none, outcome = np.zeros(0), Outcome.UNSUPPORTED
    if isinstance(why, RunVerdict):
        outcome, why = why.outcome, f"the run ended as {why.outcome.slug}: {why.reason}"
    unreported = {DRIVE_TORQUE: why} | {joint.name: why for joint in mechanism.joints}
    return ForceTracks(Instants(none, none, none, none), None, {}, unreported, outcome)


def applied_forces(mechanism: Mechanism, poses: Array, rates: Array, times: Array) -> Array:
    """Force and moment of loads and constant forces on each body (T, n, 3) [N, N, N m], in the mechanism's frame.

    Moments are about the centres of gravity.

    Args:
        poses, rates: poses and rates (T, 3 n) of all bodies.
        times: (T,) [s].
    """
    result = np.zeros((len(poses), len(mechanism.bodies), 3))
    bodies = pose_jets(mechanism, [poses, rates])
    for load in mechanism.loads:
        value, rate = coordinate_jet(load.along, bodies).coefficients
        force = np.asarray(load.law.force(np.asarray(value), np.asarray(rate), times))
        result += (force[:, None] * coordinate_gradient(load.along, mechanism, bodies, len(poses))).reshape(
            result.shape
        )
    for i, body in enumerate(mechanism.bodies):
        # The gradient by a pose is about the origin of the body's frame.
        x, y = rotate_planar(body.centre_of_gravity, poses[:, 3 * i + 2])
        result[:, i, 2] -= x * result[:, i, 1] - y * result[:, i, 0]
    for name, push in mechanism.constant_forces.items():
        result[:, mechanism.body_index[name], :2] += push
    return result


def load_work(kinematics: Kinematics, speed: float) -> float:
    """Energy [J] that loads exchange per revolution, or over the driver's span, at a crank speed [rad/s]."""
    mechanism = kinematics.mechanism
    angles, (first, last) = kinematics.angles(CRANK_SAMPLES), kinematics.span
    poses, derivative = kinematics.derivatives(angles, 1)
    bodies, work = pose_jets(mechanism, [poses, derivative]), 0.0
    for load in mechanism.loads:
        value, slope = (np.asarray(c) for c in coordinate_jet(load.along, bodies).coefficients)
        power = load.law.force(value, slope * speed, angles / speed) * slope
        work += (last - first) * float(np.mean(np.abs(power)))
    return work


@dataclass(frozen=True)
class Pace:
    """Fastest time scale of a motion without a drive, where a driven machine has its period.

    Attributes:
        revolution: duration of the fastest revolution of a link [s].
        crosses_branches: whether the motion passes configurations in which two assembly branches meet.
    """

    revolution: float
    crosses_branches: bool = False


@dataclass(frozen=True)
class FreeRun:
    """A run without a drive, sampled at equal numbers of steps from its start on.

    Attributes:
        times: (T,) [s], step index times step, from 0.
        poses, rates: poses and rates (T, 3 n) [m, m, rad] in the order of `Mechanism.bodies`, both at `times`.
        energy: kinetic, and potential of weight, constant forces and conservative loads, (T,) [J].
        outcome: how the run ended.
        reason: details of the outcome; empty if the run completed.
    """

    times: Array
    poses: Array
    rates: Array
    energy: Array
    outcome: Outcome
    reason: str

    @classmethod
    def from_states(cls, mechanism: Mechanism, times: Array, states: tuple[Array, Array]) -> FreeRun:
        """Make a run from its poses and rates (T, 3 n), with energy and outcome computed from them."""
        with np.errstate(all="ignore"):
            verdict, energy = _judge_free_run(mechanism, times, *states), _mechanical_energy(mechanism, *states)
        return cls(times, *states, energy, verdict.outcome, verdict.reason)


def _mechanical_energy(mechanism: Mechanism, poses: Array, rates: Array) -> Array:
    """Kinetic and potential energy (T,) [J] of states (T, 3 n): weight, constant forces, conservative loads."""
    bodies = pose_jets(mechanism, [poses, rates])
    total = np.zeros(len(poses))
    for body in mechanism.bodies:
        x, y = (jet.coefficients for jet in bodies[body.name].point(body.centre_of_gravity))
        spin = bodies[body.name].phi.coefficients[1]
        px, py = mechanism.constant_force_on(body.name)
        total += 0.5 * (body.mass * (x[1] ** 2 + y[1] ** 2) + body.inertia * spin**2)
        total -= (body.mass * mechanism.gravity[0] + px) * x[0] + (body.mass * mechanism.gravity[1] + py) * y[0]
    for load in mechanism.loads:
        if isinstance(load.law, CONSERVATIVE):
            total += load.law.energy(np.asarray(coordinate_jet(load.along, bodies).coefficients[0]))
    return total


def _judge_free_run(mechanism: Mechanism, times: Array, poses: Array, rates: Array) -> RunVerdict:
    """Judge a free run by its motion (T, 3 n) alone, which does not show a change of branch."""
    finite = np.all(np.isfinite(poses), axis=1) & np.all(np.isfinite(rates), axis=1)
    if not finite.all():
        return RunVerdict(Outcome.DIVERGED, f"not finite from {times[int(np.argmin(finite))]:.6g} s on")
    size = max(max(abs(x), abs(y)) for x, y, _ in mechanism.poses.values()) or 1.0
    away = np.abs((poses - poses[0]).reshape(len(poses), -1, 3)[:, :, :2]).max(axis=(1, 2)) / size
    if away.max() > MAX_REACH_SIZES:
        first = float(times[int(np.argmax(away > MAX_REACH_SIZES))])
        return RunVerdict(Outcome.EXPLODED, f"beyond {MAX_REACH_SIZES:g} sizes of the mechanism from {first:.6g} s on")
    for name, gap in joint_gaps(mechanism, [poses]).items():
        if np.abs(gap).max() > MAX_JOINT_GAP * size:
            return RunVerdict(Outcome.OPENED, f"{name}: gap up to {np.abs(gap).max():.3g} m")
    return RunVerdict(Outcome.COMPLETED)
