"""Results of engines beside the motion at constant speed: forces, and a motion that nothing prescribes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.exact.dynamics import coordinate_jet, gradient
from conrod.exact.joint_equations import pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, turned
from conrod.mechanism.loads import CONSERVATIVE
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.outcome import OPEN_GAP, OUT_OF_REACH, Verdict, joint_gaps
from conrod.runs.trajectory import Instants, Outcome

DRIVE = "drive torque"
EDITED = "what the model carries beside its joints takes a part of the load"
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
    angles, (first, last) = kinematics.angles(SAMPLES), kinematics.span
    poses, slopes = kinematics.derivatives(angles, 1)
    bodies, work = pose_jets(mechanism, [poses, slopes]), 0.0
    for load in mechanism.loads:
        value, slope = (np.asarray(c) for c in coordinate_jet(load.along, bodies).coefficients)
        power = load.law.force(value, slope * speed, angles / speed) * slope
        work += (last - first) * float(np.mean(np.abs(power)))
    return work


@dataclass(frozen=True)
class Pace:
    """Pace of a motion, in place of the period that a machine with a drive has.

    Attributes:
        turn: the fastest [s].
        crosses: whether it passes configurations where branches cross.
    """

    turn: float
    crosses: bool = False


@dataclass(frozen=True)
class FreeRun:
    """A free or torque-driven run, sampled at every so-many-th step from its start on.

    Attributes:
        times: (T,) [s], from 0, counted in steps.
        poses, rates: of all bodies in the order of `Mechanism.bodies` (T, 3 n) [m, m, rad], both at `times`.
        energy: kinetic, of weight and constant forces, and stored in loads that are potentials, (T,) [J].
        outcome: how the run ended; reason: its details, empty when completed.
    """

    times: Array
    poses: Array
    rates: Array
    energy: Array
    outcome: Outcome
    reason: str

    @classmethod
    def judged(cls, mechanism: Mechanism, times: Array, states: tuple[Array, Array]) -> FreeRun:
        """A run with its energy and its outcome, from poses and rates (T, 3 n)."""
        with np.errstate(all="ignore"):
            verdict, energy = _verdict(mechanism, times, *states), _energy(mechanism, *states)
        return cls(times, *states, energy, verdict.outcome, verdict.reason)


def _energy(mechanism: Mechanism, poses: Array, rates: Array) -> Array:
    """Kinetic energy and that of weight, constant forces and loads that are potentials (T,) [J], of states (T, 3 n)."""
    bodies = pose_jets(mechanism, [poses, rates])
    total = np.zeros(len(poses))
    for body in mechanism.bodies:
        x, y = (jet.coefficients for jet in bodies[body.name].point(body.centre_of_gravity))
        spin = bodies[body.name].phi.coefficients[1]
        px, py = mechanism.push_on(body.name)
        total += 0.5 * (body.mass * (x[1] ** 2 + y[1] ** 2) + body.inertia * spin**2)
        total -= (body.mass * mechanism.gravity[0] + px) * x[0] + (body.mass * mechanism.gravity[1] + py) * y[0]
    for load in mechanism.loads:
        if isinstance(load.law, CONSERVATIVE):
            total += load.law.energy(np.asarray(coordinate_jet(load.along, bodies).coefficients[0]))
    return total


def _verdict(mechanism: Mechanism, times: Array, poses: Array, rates: Array) -> Verdict:
    """Verdict on a free run from its motion (T, 3 n) alone; another branch is seen only beside the exact motion."""
    finite = np.all(np.isfinite(poses), axis=1) & np.all(np.isfinite(rates), axis=1)
    if not finite.all():
        return Verdict(Outcome.DIVERGED, f"not finite from {times[int(np.argmin(finite))]:.6g} s on")
    size = max(max(abs(x), abs(y)) for x, y, _ in mechanism.poses.values()) or 1.0
    away = np.abs((poses - poses[0]).reshape(len(poses), -1, 3)[:, :, :2]).max(axis=(1, 2)) / size
    if away.max() > OUT_OF_REACH:
        first = float(times[int(np.argmax(away > OUT_OF_REACH))])
        return Verdict(Outcome.EXPLODED, f"beyond {OUT_OF_REACH:g} sizes of the mechanism from {first:.6g} s on")
    for name, gap in joint_gaps(mechanism, [poses]).items():
        if np.abs(gap).max() > OPEN_GAP * size:
            return Verdict(Outcome.OPENED, f"{name}: gap up to {np.abs(gap).max():.3g} m")
    return Verdict(Outcome.COMPLETED)
