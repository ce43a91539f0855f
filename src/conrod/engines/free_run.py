"""A motion that nothing prescribes: what an engine reports of it, its energy, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.exact.dynamics.coordinates import coordinate_jet
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import CONSERVATIVE
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.outcome import OPEN_GAP, OUT_OF_REACH, Verdict, joint_gaps
from conrod.runs.trajectory import Outcome


@dataclass(frozen=True)
class Pace:
    """How fast a motion is, in place of the period that a machine with a drive has.

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
        cpu_seconds: of stepping alone [s].
    """

    times: Array
    poses: Array
    rates: Array
    energy: Array
    outcome: Outcome
    reason: str
    cpu_seconds: float

    @classmethod
    def judged(cls, mechanism: Mechanism, times: Array, states: tuple[Array, Array], cpu_seconds: float) -> FreeRun:
        """A run with its energy and its outcome, from poses and rates (T, 3 n)."""
        with np.errstate(all="ignore"):
            verdict, energy = _verdict(mechanism, times, *states), _energy(mechanism, *states)
        return cls(times, *states, energy, verdict.outcome, verdict.reason, cpu_seconds)


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
