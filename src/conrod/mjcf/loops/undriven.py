"""Runs in which nothing is prescribed: the file as it is, and a floating machine let go."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import NamedTuple

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
    step, reason, kept = float(model.opt.timestep), "", list[_Kept]()
    with warnings_kept_quiet():
        for _ in range(max(2, round(seconds / step)) + 1):
            look_at(model, data, aside)
            kept.append(_kept(tree, model, aside))
            mujoco.mj_step(model, data)
            if reason := broken_off(model, data):
                reason += f" at {data.time:.4g} s"
                break
    momenta, spins, energies, gaps, sizes = (np.array(column) for column in zip(*kept, strict=True))
    dissipates = bool(np.any(model.dof_damping) or np.any(model.dof_frictionloss) or np.any(model.tendon_damping))
    momentum, spin, energy = (
        float(np.abs(values - values[0]).max() / max(float(size), 1e-300))
        for values, size in zip((momenta, spins, energies), sizes.max(axis=0), strict=True)
    )
    outcome = Outcome.DIVERGED if reason else Outcome.COMPLETED
    return FreeRun(label, outcome, reason, float(gaps.max()), momentum, spin, None if dissipates else energy)


class _Kept(NamedTuple):
    """What does not change in free motion, and the sizes that its drift is compared with.

    Attributes:
        momentum: less that of the weight (3,).
        spin: about the centre of gravity (3,).
        sizes: of the momenta and spins of all bodies, each by its size, and the kinetic energy.
    """

    momentum: Array
    spin: Array
    energy: float
    gap: float
    sizes: tuple[float, float, float]


def _kept(tree: SpatialTree, model: mujoco.MjModel, data: mujoco.MjData) -> _Kept:
    """What is kept, in data that `look_at` has made."""
    for make in (mujoco.mj_energyPos, mujoco.mj_energyVel, mujoco.mj_subtreeVel):
        make(model, data)
    momentum = float(model.body_mass.sum()) * (data.subtree_linvel[0] - tree.gravity * data.time)
    gap = max(gaps_of(tree, model, data).values(), default=0.0)
    sizes = (*_sizes(model, data), float(data.energy[1]))
    return _Kept(momentum, data.subtree_angmom[0].copy(), float(data.energy.sum()), gap, sizes)


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
