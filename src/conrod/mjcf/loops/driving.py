"""A model's runs in MuJoCo: its joints driven by laws, the file as it is, and let go."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.engines.mujoco import older
from conrod.engines.mujoco.model import constraint_jacobian
from conrod.engines.mujoco.recorder import BAD_NUMBERS, WARNINGS, warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.exact.space.motion import RANK_TOLERANCE, DrivenTree, SpatialMotion
from conrod.mjcf.loops.results import FreeRun, ShippedRun
from conrod.mjcf.runs import STATE
from conrod.own.models.driving import look_at
from conrod.own.models.loading import FoundPoint, name_or_number, names_of
from conrod.runs.outcome import OPEN_GAP
from conrod.runs.trajectory import Outcome

# Armature of a driven joint over the inertia that all bodies together could have about it: what the machine asks of its
# drive changes the joint's acceleration by that share of its own size.
FLYWHEEL = 1e12
EQUALITY = mujoco.mjtConstraint.mjCNSTR_EQUALITY
# A rate that turns back in this share of all steps, by this share of its range, is the step's, not the machine's.
TURNS_BACK, SWING = 0.6, 1e-3


@dataclass(frozen=True)
class Recording:
    """A run at K samples.

    Attributes:
        points: by name position, velocity and acceleration (3, K, 3).
        gaps: of each closure (K,), by name.
        forces: of each connect (K, 3), and of each driven joint (K,), by name.
    """

    times: Array
    points: Mapping[str, Array]
    gaps: Mapping[str, Array]
    forces: Mapping[str, Array]
    outcome: Outcome
    reason: str


def start_state(data: mujoco.MjData, motion: SpatialMotion, at: int = 0) -> None:
    """Put the exact coordinates and rates of a sample into data."""
    data.qpos[:], data.qvel[:] = motion.coordinates[:, at], motion.rates[0, :, at]


class Drives:
    """Writes the driven joints' coordinates and rates at every step, and accelerates their flywheels by the laws."""

    def __init__(self, machine: DrivenTree, model: mujoco.MjModel) -> None:
        self.machine, self.model = machine, model
        self.joints = list(zip(machine.driven, machine.laws.values(), strict=True))
        self.held = [joint for joint in machine.tree.joints if joint.name in machine.held]
        inertia = float(model.body_mass.sum()) * (machine.tree.extent**2)
        self.armature = FLYWHEEL * max(inertia, float(model.dof_M0.max(initial=1e-9)))
        for joint in [*machine.driven, *self.held]:
            model.dof_armature[joint.rates] = self.armature

    def write(self, data: mujoco.MjData, time: float) -> None:
        """The driven coordinates and rates of a time."""
        for joint, law in self.joints:
            value, rate, *_ = law.derivatives(np.array([time]))[:, 0]
            data.qpos[joint.coordinate], data.qvel[joint.rate] = value, rate
        for joint in self.held:
            data.qvel[joint.rates] = 0.0
            placed = slice(joint.coordinate, joint.coordinate + 7)
            data.qpos[placed] = self.machine.knots[0].coordinates[placed, 0]

    @contextmanager
    def acting(self) -> Iterator[None]:
        """MuJoCo asks for the forces that accelerate the flywheels at each stage of a step."""

        def push(_: mujoco.MjModel, data: mujoco.MjData) -> None:
            now = np.array([data.time])
            for joint, law in self.joints:
                data.qfrc_applied[joint.rate] = self.armature * law.derivatives(now)[2, 0]

        before = mujoco.get_mjcb_control()
        mujoco.set_mjcb_control(push)
        try:
            yield
        finally:
            mujoco.set_mjcb_control(before)


def driven_run(
    machine: DrivenTree, model: mujoco.MjModel, motion: SpatialMotion, points: tuple[FoundPoint, ...], every: int
) -> Recording:
    """Run a model through its exact motion's times, a sample each `every` steps.

    Args:
        model: with its settings and step, of which a copy gets flywheels; the first sample is its start.
    """
    original, model = model, copy.copy(model)
    model.opt.disableflags |= older.flag("AUTORESET")
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)  # without which MuJoCo asks for no control
    drives, data, aside = Drives(machine, model), mujoco.MjData(model), mujoco.MjData(model)
    start_state(data, motion)
    step, plain = float(model.opt.timestep), mujoco.MjData(original)

    def looked() -> tuple[Array, ...]:
        look_at(model, data, aside)
        carried, torques = carried_forces(machine, original, plain, aside)
        reactions = [carried[rows] for rows in closure_rows(model, aside).values() if len(rows) == 3]
        return (
            np.array([point.motion(model, aside) for point in points]),
            np.array(list(gaps_of(model, aside).values())),
            np.concatenate([*reactions, torques]),
        )

    rows, reason = [], ""
    with drives.acting(), warnings_kept_quiet():
        for k in range(len(motion.times)):
            if k:
                reason = _advanced(model, data, drives, step, (k - 1) * every, every)
            if reason:
                break
            rows.append(looked())
    whole = len(rows) == len(motion.times)
    moved, gaps, forces = (np.array(column) for column in zip(*rows, strict=True)) if rows else (np.zeros((0, 1)),) * 3
    names = [name for name, own in closure_rows(model, aside).items() if len(own) == 3]
    parts: dict[str, Array] = {name: forces[:, 3 * k : 3 * k + 3] for k, name in enumerate(names)} if rows else {}
    parts |= {j.name: forces[:, 3 * len(names) + k] for k, j in enumerate(machine.driven)} if rows else {}
    return Recording(
        motion.times[: len(rows)],
        {point.name: moved[:, k].swapaxes(0, 1) for k, point in enumerate(points)} if rows else {},
        dict(zip(gaps_of(model, aside), gaps.T, strict=True)) if rows else {},
        parts,
        Outcome.COMPLETED if whole else Outcome.DIVERGED,
        reason,
    )


def _advanced(model: mujoco.MjModel, data: mujoco.MjData, drives: Drives, step: float, first: int, count: int) -> str:
    """Make some steps, with the drives written after each; why it breaks off, or nothing."""
    for k in range(first, first + count):
        mujoco.mj_step(model, data)
        drives.write(data, (k + 1) * step)
        if reason := broken_off(model, data):
            return f"{reason} at {(k + 1) * step:.4g} s"
    return ""


def broken_off(model: mujoco.MjModel, data: mujoco.MjData) -> str:
    """Why a run's numbers mean nothing any more, empty where they do."""
    bad = [name for name in sorted(BAD_NUMBERS) if data.warning[WARNINGS[name]].number]
    if not bad and np.all(np.isfinite(data.qpos)) and np.all(np.isfinite(data.qvel)):
        return ""
    reset = bool(bad) and not model.opt.disableflags & older.flag("AUTORESET")
    return ("MuJoCo reset its state" if reset else "not finite") + (f" ({', '.join(bad)})" if bad else "")


def closure_rows(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, NDArray[np.intp]]:
    """Numbers of the rows of each acting closure among all constraints: three of a connect."""
    rows = np.flatnonzero(data.efc_type[: data.nefc] == EQUALITY)
    ids = data.efc_id[rows]
    return {name_or_number(model, "equality", int(e)): rows[ids == e] for e in dict.fromkeys(ids.tolist())}


def gaps_of(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, float]:
    """How far each acting closure is open: a distance [m], or what a coupling is off."""
    return {name: float(np.linalg.norm(data.efc_pos[rows[:3]])) for name, rows in closure_rows(model, data).items()}


def carried_forces(
    machine: DrivenTree, original: mujoco.MjModel, plain: mujoco.MjData, data: mujoco.MjData
) -> tuple[Array, Array]:
    """Forces of the closures (ne,), and what each driven joint asks of its drive, by the accelerations that were made.

    All joints keep M a + bias = passive + actuator + J' f + drive (MuJoCo documentation, Computation); those that are
    not driven give f, of which hardened closures have lost digits in MuJoCo's own forces.

    Args:
        original: the model without flywheels, and `plain` its data.
    """
    plain.qpos[:], plain.qvel[:] = data.qpos, data.qvel
    mujoco.mj_fwdPosition(original, plain)
    needed = np.empty(original.nv)
    mujoco.mj_mulM(original, plain, needed, np.array(data.qacc))
    needed += data.qfrc_bias - data.qfrc_passive - data.qfrc_actuator
    jacobian = constraint_jacobian(original, data)
    needed -= jacobian[data.ne :].T @ data.efc_force[data.ne :]
    closing = jacobian[: data.ne]
    carried = np.linalg.lstsq(closing[:, machine.free].T, needed[machine.free], rcond=RANK_TOLERANCE)[0]
    needed -= closing.T @ carried
    return carried, np.array([needed[joint.rate] for joint in machine.driven])


# -- nothing prescribed ----------------------------------------------------------------------------------------------


def shipped_run(
    model: mujoco.MjModel, data: mujoco.MjData, controls: Mapping[int, Callable[[float], float]], seconds: float,
    start: str, travel: float,
) -> ShippedRun:  # fmt: skip
    """The file run as it is, its controls those of the start or of laws in time, by actuator."""
    steps, aside = max(2, round(seconds / float(model.opt.timestep))), mujoco.MjData(model)
    rates, gaps, reason = list[Array](), dict[str, float](), ""
    with warnings_kept_quiet():
        for k in range(steps):
            for actuator, law in controls.items():
                data.ctrl[actuator] = law(float(data.time))
            mujoco.mj_step(model, data)
            if reason := broken_off(model, data):
                reason += f" at {(k + 1) * float(model.opt.timestep):.4g} s"
                break
            rates.append(data.qvel.copy())
            if k % max(1, steps // 400) == 0:
                state = np.empty(mujoco.mj_stateSize(model, STATE))
                mujoco.mj_getState(model, data, state, STATE)
                mujoco.mj_setState(model, aside, state, STATE)
                mujoco.mj_fwdPosition(model, aside)
                for name, gap in gaps_of(model, aside).items():
                    gaps[name] = max(gap, gaps.get(name, 0.0))
    outcome = Outcome.COMPLETED
    if reason:
        outcome = Outcome.RESET if reason.startswith("MuJoCo reset") else Outcome.DIVERGED
    elif gaps and max(gaps.values()) > OPEN_GAP * travel:
        worst = max(gaps, key=lambda name: gaps[name])
        outcome, reason = Outcome.OPENED, f"{worst} opens by {1e3 * gaps[worst]:.3g} mm"
    return ShippedRun(start, seconds, outcome, reason, gaps, None if reason else _chatter(model, np.array(rates)))


def _chatter(model: mujoco.MjModel, rates: Array) -> tuple[str, float] | None:
    """The joint whose rate turns back at nearly every step of the last half, and its swing over its range."""
    late = rates[len(rates) // 2 :]
    if len(late) < 20:
        return None
    changes = np.diff(late, axis=0)
    back = np.mean(changes[1:] * changes[:-1] < 0.0, axis=0)
    swing = np.median(np.abs(changes), axis=0) / np.maximum(np.ptp(rates, axis=0), 1e-9)
    # A rate whose whole range is rounding swings in nothing.
    swing[np.ptp(rates, axis=0) < 1e-6] = 0.0
    worst = int(np.argmax(np.where(back > TURNS_BACK, swing, 0.0)))
    if back[worst] <= TURNS_BACK or swing[worst] <= SWING:
        return None
    return name_or_number(model, "joint", int(model.dof_jntid[worst])), float(swing[worst])


def free_run(label: str, model: mujoco.MjModel, motion: SpatialMotion, seconds: float) -> FreeRun:
    """A model let go from its exact start without contacts, limits and controls: what drifts."""
    model = copy.copy(model)
    switched = older.flag("AUTORESET") | int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT)
    model.opt.disableflags |= switched | int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    data, aside = mujoco.MjData(model), mujoco.MjData(model)
    start_state(data, motion)
    step, reason, rows = float(model.opt.timestep), "", []
    total = float(model.body_mass.sum())
    with warnings_kept_quiet():
        for _ in range(max(2, round(seconds / step)) + 1):
            look_at(model, data, aside)
            mujoco.mj_energyPos(model, aside)
            mujoco.mj_energyVel(model, aside)
            mujoco.mj_subtreeVel(model, aside)
            momentum = total * (aside.subtree_linvel[0] - model.opt.gravity * data.time)
            parts = _sizes(model, aside)
            rows.append(
                [
                    *momentum,
                    *aside.subtree_angmom[0],
                    *aside.energy,
                    max(gaps_of(model, aside).values(), default=0.0),
                    *parts,
                ]
            )
            mujoco.mj_step(model, data)
            if reason := broken_off(model, data):
                reason += f" at {data.time:.4g} s"
                break
    table = np.array(rows)
    drift = np.abs(table - table[0]).max(axis=0)
    dissipates = bool(np.any(model.dof_damping) or np.any(model.dof_frictionloss) or np.any(model.tendon_damping))
    energy = np.abs(table[:, 6:8].sum(axis=1) - table[0, 6:8].sum()).max() / max(table[:, 7].max(), 1e-300)
    return FreeRun(
        label, Outcome.DIVERGED if reason else Outcome.COMPLETED, reason, float(table[:, 8].max()),
        float(drift[:3].max() / max(table[:, 9].max(), 1e-300)),
        float(drift[3:6].max() / max(table[:, 10].max(), 1e-300)),
        None if dissipates else float(energy),
    )  # fmt: skip


def _sizes(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[float, float]:
    """Linear and angular momenta of all bodies, each by its size, that a drift is compared with."""
    centre, linear, angular = data.subtree_com[0], 0.0, 0.0
    for body in range(1, model.nbody):
        velocity = np.empty(6)
        mujoco.mj_objectVelocity(model, data, int(mujoco.mjtObj.mjOBJ_BODY), body, velocity, 0)
        one = float(model.body_mass[body] * np.linalg.norm(velocity[3:]))
        linear += one
        angular += one * float(np.linalg.norm(data.xipos[body] - centre))
    return linear, angular


def site_points(model: mujoco.MjModel, names: tuple[str, ...]) -> tuple[FoundPoint, ...]:
    """Sites of these names or, where a model has none, frames of bodies."""
    if not model.nsite:
        bodies = [name_or_number(model, "body", k) for k in range(model.nbody)]
        return tuple(FoundPoint(name, "body", bodies.index(name), bodies.index(name)) for name in names)
    sites = [name or f"site {k}" for k, name in enumerate(names_of(model, "site"))]
    return tuple(FoundPoint(n, "site", sites.index(n), int(model.site_bodyid[sites.index(n)])) for n in names)
