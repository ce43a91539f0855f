"""The state that runs start from: a keyframe or the model's own pose, its loops closed."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.engines.mujoco.mobility import equality_jacobian
from conrod.exact.motion import Array
from conrod.mjcf.harden.closures import Closure, equality_violations, loops_of, openings
from conrod.own.models.loading import keyframe_to_start_from, told_start

STATE = mujoco.mjtState.mjSTATE_INTEGRATION  # all that a step depends on
CLOSED = 1e-12  # of the model's size
PASSES = 50
# Singular values below this share of the largest are redundant rows.
REDUNDANT = 1e-9


@dataclass(frozen=True)
class Start:
    """Where runs start.

    Attributes:
        state: as `mj_setState` takes it.
        name: what a user calls it.
        given: largest opening of the pose as given, by unit.
        closed: whether the loops could be closed; the state is as given where they could not.
        rates_changed: largest change that this made to a rate, over the largest rate.
    """

    state: Array
    name: str
    given: dict[str, float]
    closed: bool
    rates_changed: float = 0.0


def start_of(model: mujoco.MjModel, keyframe: str | None, closures: Sequence[Closure]) -> Start:
    """The start that a user names, or the first keyframe where there is one, with controls of 0.

    Raises:
        InvalidInput: the model has no such keyframe.
    """
    data = mujoco.MjData(model)
    index = keyframe_to_start_from(model, keyframe)
    if index is not None:
        mujoco.mj_resetDataKeyframe(model, data, index)
    data.ctrl[:] = 0.0
    mujoco.mj_fwdPosition(model, data)
    given = largest_by_unit(model, closures, openings(model, data, closures))
    closed, changed = _closed(model, data, closures), 0.0
    if closed is not None:
        fastest = float(np.abs(data.qvel).max(initial=0.0))
        changed = float(np.abs(closed[1] - data.qvel).max()) / fastest if fastest else 0.0
        data.qpos[:], data.qvel[:] = closed
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    return Start(state, told_start(model, index), given, closed is not None, changed)


def largest_by_unit(model: mujoco.MjModel, closures: Sequence[Closure], found: Array) -> dict[str, float]:
    """The largest opening in m and in rad, of those that there are."""
    largest: dict[str, float] = {}
    for loop, value in zip(loops_of(model, closures), found, strict=True):
        largest[loop.unit] = max(largest.get(loop.unit, 0.0), float(value))
    return largest


def _closed(model: mujoco.MjModel, data: mujoco.MjData, closures: Sequence[Closure]) -> tuple[Array, Array] | None:
    """Coordinates and rates of the nearest state with closed loops, by Newton iteration; None where there is none."""
    bare = copy.copy(model)
    bare.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT)
    aside = mujoco.MjData(bare)
    mujoco.mj_copyData(aside, bare, data)
    mine = [one.index for one in closures]
    for _ in range(PASSES):
        mujoco.mj_fwdPosition(bare, aside)
        violations, owners = equality_violations(aside)
        kept = np.isin(owners, mine)
        jacobian = equality_jacobian(bare, aside)[kept]
        if np.abs(violations[kept]).max(initial=0.0) <= CLOSED * float(model.stat.extent):
            parting = np.linalg.lstsq(jacobian, jacobian @ aside.qvel, rcond=REDUNDANT)[0]
            return aside.qpos.copy(), aside.qvel - parting
        step = -np.linalg.lstsq(jacobian, violations[kept], rcond=REDUNDANT)[0]
        mujoco.mj_integratePos(bare, aside.qpos, step, 1.0)
        if not np.all(np.isfinite(aside.qpos)):
            break
    return None
