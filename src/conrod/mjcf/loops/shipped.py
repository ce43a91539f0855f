"""The file run as it is, in which nothing is prescribed."""

from __future__ import annotations

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.exact.space.tree import RATES, SpatialTree, lengths
from conrod.mjcf.loops.driving import advanced, gaps_of, opens
from conrod.mjcf.loops.results import ShippedRun
from conrod.mjcf.runs import STATE
from conrod.own.models.loading import name_or_number
from conrod.runs.outcome import OPEN_GAP
from conrod.runs.trajectory import Outcome

# A rate that turns back in this share of all steps, by this share of its range, is the step's, not the machine's.
TURNS_BACK, SWING = 0.6, 1e-3


def shipped_run(
    tree: SpatialTree, model: mujoco.MjModel, data: mujoco.MjData, seconds: float, start: str, travel: float
) -> ShippedRun:  # fmt: skip
    """The file run as it is, with the controls of its start."""
    steps, aside = max(2, round(seconds / float(model.opt.timestep))), mujoco.MjData(model)
    rates, gaps = list[Array](), dict[str, float]()

    def look(done: int) -> None:
        rates.append(data.qvel.copy())
        if (done - 1) % max(1, steps // 400) == 0:
            state = np.empty(mujoco.mj_stateSize(model, STATE))
            mujoco.mj_getState(model, data, state, STATE)
            mujoco.mj_setState(model, aside, state, STATE)
            mujoco.mj_fwdPosition(model, aside)
            for name, gap in gaps_of(tree, model, aside).items():
                gaps[name] = max(gap, gaps.get(name, 0.0))

    with warnings_kept_quiet():
        reason = advanced(model, data, range(steps), look)
    outcome = Outcome.COMPLETED
    if reason:
        outcome = Outcome.RESET if reason.startswith("MuJoCo reset") else Outcome.DIVERGED
    elif gaps and max(gaps.values()) > OPEN_GAP * max(travel, tree.extent):
        outcome, reason = Outcome.OPENED, opens(gaps)
    chatter = None if reason else _chatter(tree, model, np.array(rates))
    return ShippedRun(start, seconds, outcome, reason, max(gaps.values(), default=0.0), chatter)


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
