"""Runs in which nothing is prescribed: the file as it is, and a floating machine let go."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping

import mujoco
import numpy as np

from conrod.engines.mujoco import older
from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.exact.space.coordinates import lengths
from conrod.exact.space.motion import SpatialMotion
from conrod.exact.space.tree import RATES, SpatialTree
from conrod.mjcf.loops.driving import broken_off, gaps_of, opens, start_state
from conrod.mjcf.loops.results import FreeRun, ShippedRun
from conrod.mjcf.runs import STATE
from conrod.own.models.driving import look_at
from conrod.own.models.loading import name_or_number
from conrod.runs.outcome import OPEN_GAP
from conrod.runs.trajectory import Outcome

# A rate that turns back in this share of all steps, by this share of its range, is the step's, not the machine's.
TURNS_BACK, SWING = 0.6, 1e-3


def shipped_run(
    tree: SpatialTree, model: mujoco.MjModel, data: mujoco.MjData, controls: Mapping[int, Callable[[float], float]],
    seconds: float, start: str, travel: float,
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
                for name, gap in gaps_of(tree, model, aside).items():
                    gaps[name] = max(gap, gaps.get(name, 0.0))
    outcome = Outcome.COMPLETED
    if reason:
        outcome = Outcome.RESET if reason.startswith("MuJoCo reset") else Outcome.DIVERGED
    elif gaps and max(gaps.values()) > OPEN_GAP * max(travel, tree.extent):
        outcome, reason = Outcome.OPENED, opens(tree, gaps)
    return ShippedRun(start, seconds, outcome, reason, gaps, None if reason else _chatter(tree, model, np.array(rates)))


def _chatter(tree: SpatialTree, model: mujoco.MjModel, rates: Array) -> tuple[str, float] | None:
    """The joint whose rate turns back at nearly every step of the last half, and its swing over its range."""
    late = rates[len(rates) // 2 :]
    if len(late) < 20:
        return None
    changes = np.diff(late, axis=0)
    back = np.mean(changes[1:] * changes[:-1] < 0.0, axis=0)
    size, ranges = np.median(np.abs(changes), axis=0), np.ptp(rates, axis=0)
    swing = size / np.maximum(ranges, 1e-9)
    # What settles while others move, or rounds, swings in nothing.
    weights = np.concatenate([lengths(tree, joint, RATES) for joint in tree.joints])
    swing[(ranges < 1e-6) | (size * weights < SWING * float(np.max(ranges * weights)))] = 0.0
    worst = int(np.argmax(np.where(back > TURNS_BACK, swing, 0.0)))
    if back[worst] <= TURNS_BACK or swing[worst] <= SWING:
        return None
    return name_or_number(model, "joint", int(model.dof_jntid[worst])), float(swing[worst])


def free_run(label: str, tree: SpatialTree, model: mujoco.MjModel, motion: SpatialMotion, seconds: float) -> FreeRun:
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
            momentum = total * (aside.subtree_linvel[0] - tree.gravity * data.time)
            parts = _sizes(model, aside)
            rows.append(
                [
                    *momentum,
                    *aside.subtree_angmom[0],
                    *aside.energy,
                    max(gaps_of(tree, model, aside).values(), default=0.0),
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
