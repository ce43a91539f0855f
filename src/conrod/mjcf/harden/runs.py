"""Runs of a model that nothing drives: the state that they start from, and what loops, contacts and limits do."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.mjcf.equalities import rows_at
from conrod.mjcf.harden.closures import Closure, loops_of, openings
from conrod.mjcf.harden.results import Loop, Touching
from conrod.mjcf.stepping import broken
from conrod.own.models.loading import keyframe_to_start_from, start_words

STATE = mujoco.mjtState.mjSTATE_INTEGRATION  # all that a step depends on
CLOSED = 1e-12  # of the model's size
PASSES = 50
# Singular values below this share of the largest are redundant rows.
REDUNDANT = 1e-9
LIMITS = (mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT, mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON)


@dataclass(frozen=True)
class Start:
    """State from which runs start.

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
    given = largest_by_unit(loops_of(model, closures), openings(model, data, closures))
    closed, changed = _closed(model, data, closures), 0.0
    if closed is not None:
        fastest = float(np.abs(data.qvel).max(initial=0.0))
        changed = float(np.abs(closed[1] - data.qvel).max()) / fastest if fastest else 0.0
        data.qpos[:], data.qvel[:] = closed
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    return Start(state, start_words(model, index), given, closed is not None, changed)


def largest_by_unit(loops: Sequence[Loop], found: Sequence[float] | Array) -> dict[str, float]:
    """The largest opening in m and in rad, of those that there are."""
    largest: dict[str, float] = {}
    for loop, value in zip(loops, found, strict=False):
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
        rows = rows_at(bare, aside)
        kept = np.isin(rows.ids, mine)
        jacobian, gaps = rows.jacobian[kept], rows.gaps[kept]
        if np.abs(gaps).max(initial=0.0) <= CLOSED * float(model.stat.extent):
            parting = np.linalg.lstsq(jacobian, jacobian @ aside.qvel, rcond=REDUNDANT)[0]
            return aside.qpos.copy(), aside.qvel - parting
        step = -np.linalg.lstsq(jacobian, gaps, rcond=REDUNDANT)[0]
        mujoco.mj_integratePos(bare, aside.qpos, step, 1.0)
        if not np.all(np.isfinite(aside.qpos)):
            break
    return None


# -- runs --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pace:
    """Steps and samples of a run.

    Attributes:
        samples: that it is looked at after the start.
        stride: steps from one to the next.
        timestep: [s].
    """

    samples: int
    stride: int
    timestep: float

    def finer(self, times: int) -> Pace:
        """Pace with the same samples, and so many times as many steps."""
        return Pace(self.samples, self.stride * times, self.timestep / times)


@dataclass(frozen=True)
class Swing:
    """A run at its S + 1 samples, the start among them.

    Attributes:
        points: (S + 1, bodies, 3) centres of gravity of all that can move [m].
        openings: (S + 1, loops) as `openings` has them.
        steps: that were completed.
        broke: the engine's warning that ended it, empty where it completed; the samples end before it.
        touching: contacts and limits.
        iterations: of the solver, mean over the last steps of the samples.
    """

    points: Array
    openings: Array
    steps: int
    broke: str
    touching: Touching
    iterations: float


def swing(model: mujoco.MjModel, state: Array, pace: Pace, closures: Sequence[Closure]) -> Swing:
    """Run a model from a state; it ends at the first warning of numbers that are none."""
    run = paced(model, pace)
    data, aside = mujoco.MjData(run), mujoco.MjData(run)
    mujoco.mj_setState(run, data, state, STATE)
    points, gaps, rubs, passes = list[Array](), list[Array](), list[Touching](), list[int]()
    steps, broke = 0, ""
    with warnings_kept_quiet():
        for sample in range(pace.samples + 1):
            look_at(run, data, aside)
            points.append(aside.xipos[run.body_weldid > 0].copy())
            gaps.append(openings(run, aside, closures))
            rubs.append(touching(aside))
            if sample == pace.samples:
                break
            mujoco.mj_step(run, data, pace.stride)
            broke = broken(data)
            if broke:
                break
            passes.append(int(data.solver_niter.max(initial=0)))
            steps += pace.stride
    return Swing(
        np.array(points),
        np.array(gaps),
        steps,
        broke,
        most_touching(rubs),
        float(np.mean(passes)) if passes else 0.0,
    )


def paced(model: mujoco.MjModel, pace: Pace) -> mujoco.MjModel:
    """A copy that steps at the pace and does not begin again by itself where it breaks."""
    run = copy.copy(model)
    run.opt.timestep = pace.timestep
    run.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    return run


def look_at(model: mujoco.MjModel, data: mujoco.MjData, aside: mujoco.MjData) -> None:
    """Make the constraints of the present state: those in the data of a run belong to the instant before."""
    aside.qpos[:], aside.qvel[:], aside.eq_active[:] = data.qpos, data.qvel, data.eq_active
    aside.mocap_pos[:], aside.mocap_quat[:] = data.mocap_pos, data.mocap_quat
    mujoco.mj_fwdPosition(model, aside)


def touching(data: mujoco.MjData) -> Touching:
    """Contacts and limits that act in data whose constraints were made."""
    acting = data.contact.efc_address >= 0
    depths = -np.asarray(data.contact.dist)[acting]
    types = data.efc_type[: data.nefc]
    beyond = -data.efc_pos[: data.nefc][(types == LIMITS[0]) | (types == LIMITS[1])]
    return Touching(
        int(acting.sum()), float(depths.max(initial=0.0)), int(np.sum(beyond > 0.0)), float(beyond.max(initial=0.0))
    )


def most_touching(looks: Sequence[Touching]) -> Touching:
    """The most of each."""
    return Touching(
        max(look.contacts for look in looks),
        max(look.penetration for look in looks),
        max(look.limits for look in looks),
        max(look.excess for look in looks),
    )
