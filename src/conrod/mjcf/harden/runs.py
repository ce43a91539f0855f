"""Runs of a model that nothing drives: their start, and what loops, contacts, limits and the energy do."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.engines.mujoco import older
from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.mjcf.equalities import REDUNDANT, close_loops, rows_at
from conrod.mjcf.harden.closures import Closure, loops_of, openings
from conrod.mjcf.harden.results import Loop, Request, Touching
from conrod.mjcf.runs import STATE, broken, data_at, state_of
from conrod.own.models.loading import data_at_start, start_words

CLOSED = 1e-12  # of the model's size
LIMITS = (mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT, mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON)


@dataclass(frozen=True)
class Start:
    """State from which runs start."""

    state: Array
    name: str  # what a user calls it
    given: dict[str, float]  # largest opening of the pose as given, by unit
    closed: bool  # whether the loops could be closed; the state is as given where they could not
    rates_changed: float = 0.0  # largest change that this made to a rate, over the largest rate


def start_of(model: mujoco.MjModel, request: Request, closures: Sequence[Closure]) -> Start:
    """The start that is asked for, or the first keyframe where there is one, with its loops closed where they can be.

    Raises:
        InvalidInput: the model has no such keyframe or actuator.
    """
    data, index = data_at_start(model, request.keyframe, request.controls)
    mujoco.mj_fwdPosition(model, data)
    given, name = (
        largest_by_unit(loops_of(closures), openings(model, data, closures)),
        start_words(model, index, data.ctrl),
    )
    before = state_of(model, data)
    if not close_loops(model, data, CLOSED * float(model.stat.extent)):
        return Start(before, name, given, closed=False)
    jacobian, fastest = rows_at(model, data).jacobian, float(np.abs(data.qvel).max(initial=0.0))
    parting = np.linalg.lstsq(jacobian, jacobian @ data.qvel, rcond=REDUNDANT)[0]
    data.qvel[:] -= parting
    changed = float(np.abs(parting).max()) / fastest if fastest else 0.0
    return Start(state_of(model, data), name, given, True, changed)


def largest_by_unit(loops: Sequence[Loop], found: Sequence[float] | Array) -> dict[str, float]:
    """The largest opening in m and in rad, of those that there are."""
    largest: dict[str, float] = {}
    for loop, value in zip(loops, found, strict=False):
        largest[loop.unit] = max(largest.get(loop.unit, 0.0), float(value))
    return largest


# -- runs --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pace:
    """Steps and samples of a run."""

    samples: int  # that it is looked at after the start
    stride: int  # steps from one to the next
    timestep: float  # [s]

    def finer(self, times: int) -> Pace:
        """Pace with the same samples, and so many times as many steps."""
        return Pace(self.samples, self.stride * times, self.timestep / times)


@dataclass(frozen=True)
class Swing:
    """A run at its S + 1 samples, the start among them."""

    points: Array  # (S + 1, bodies, 3) centres of gravity of all that can move [m]
    openings: Array  # (S + 1, loops) as `openings` has them
    steps: int  # that were completed
    broke: str  # the engine's warning that ended it, empty where it completed; the samples end before it
    touching: Touching  # contacts and limits
    iterations: float  # of the solver, mean over the last steps of the samples


def swing(model: mujoco.MjModel, state: Array, pace: Pace, closures: Sequence[Closure]) -> Swing:
    """Run a model from a state; it ends at the first warning of numbers that are none."""
    points, gaps, rubs, passes, broke = list[Array](), list[Array](), list[tuple[float, ...]](), list[int](), ""
    for data, aside in _sampled(model, state, pace):
        if broke := broken(data):
            break
        points.append(aside.xipos[model.body_weldid > 0].copy())
        gaps.append(openings(model, aside, closures))
        rubs.append(_touching(aside))
        passes.append(int(data.solver_niter.max(initial=0)))
    contacts, penetration, limits, excess = np.max(rubs, axis=0).tolist()
    return Swing(
        np.array(points),
        np.array(gaps),
        pace.stride * (len(points) - 1),
        broke,
        Touching(int(contacts), penetration, int(limits), excess),
        float(np.mean(passes[1:])) if passes[1:] else 0.0,
    )


def _sampled(model: mujoco.MjModel, state: Array, pace: Pace) -> Iterator[tuple[mujoco.MjData, mujoco.MjData]]:
    """Data of a run at its samples, and data with the constraints of that state: the run's own are of the step before.

    The first that are broken are the last.
    """
    run = paced(model, pace)
    data, aside = data_at(run, state), mujoco.MjData(run)
    with warnings_kept_quiet():
        for sample in range(pace.samples + 1):
            if sample:
                mujoco.mj_step(run, data, pace.stride)
            if not broken(data):
                mujoco.mj_setState(run, aside, state_of(run, data), STATE)
                mujoco.mj_fwdPosition(run, aside)
            yield data, aside


def paced(model: mujoco.MjModel, pace: Pace) -> mujoco.MjModel:
    """A copy that steps at the pace and does not begin again by itself where it breaks."""
    run = copy.copy(model)
    run.opt.timestep = pace.timestep
    run.opt.disableflags |= older.flag("AUTORESET")
    return run


def _touching(data: mujoco.MjData) -> tuple[float, ...]:
    """The fields of `Touching` in data whose constraints were made."""
    acting = data.contact.efc_address >= 0
    depths = -np.asarray(data.contact.dist)[acting]
    beyond = -data.efc_pos[: data.nefc][np.isin(data.efc_type[: data.nefc], LIMITS)]
    return (acting.sum(), depths.max(initial=0.0), np.sum(beyond > 0.0), beyond.max(initial=0.0))


# -- energy ------------------------------------------------------------------------------------------------------------

BIT = mujoco.mjtDisableBit
# Of the largest energy: where what is exchanged is less than this share of it, rounding hides the drift.
HIDDEN = 1e-9


def conservative(model: mujoco.MjModel) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    """A copy without what takes or gives energy, and the names of what was left out of it."""
    flags, bare = int(model.opt.disableflags), copy.copy(model)
    for name in ("CONTACT", "LIMIT", "FRICTIONLOSS", "DAMPER", "ACTUATION"):
        bare.opt.disableflags |= older.flag(name)
    if not older.flag("DAMPER"):
        bare.dof_damping[:] = bare.tendon_damping[:] = 0.0
    # MuJoCo's potential energy does not know of the gravity that it takes away.
    bare.body_gravcomp[:] = 0.0
    bare.opt.density = bare.opt.viscosity = 0.0
    bare.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    collides = model.geom_contype.any() or model.geom_conaffinity.any() or model.npair
    left_out = {
        "contacts": collides and not flags & int(BIT.mjDSBL_CONTACT),
        "limits": (model.jnt_limited.any() or model.tendon_limited.any()) and not flags & int(BIT.mjDSBL_LIMIT),
        "friction": model.dof_frictionloss.any() or model.tendon_frictionloss.any(),
        "damping": model.dof_damping.any() or model.tendon_damping.any(),
        "actuators": model.nu,
        "gravity compensation": model.body_gravcomp.any(),
        "fluid": model.opt.density or model.opt.viscosity,
    }
    return bare, tuple(name for name, there in left_out.items() if there)


def energy_drift(model: mujoco.MjModel, state: Array, pace: Pace) -> tuple[float | None, str]:
    """Largest change of the energy over the kinetic energy exchanged, in a run of a conservative copy of a model.

    Returns:
        None where it says nothing, and why.
    """
    found = []
    for data, aside in _sampled(model, state, pace):
        if broken(data):
            return None, "without them a run breaks off"
        mujoco.mj_fwdVelocity(model, aside)
        mujoco.mj_energyPos(model, aside)
        mujoco.mj_energyVel(model, aside)
        found.append(aside.energy.copy())
    potential, kinetic = np.array(found).T
    exchanged = float(kinetic.max() - kinetic.min())
    largest = float(max(np.abs(potential).max(), kinetic.max()))
    if exchanged == 0.0:
        return None, "nothing moves"
    if exchanged <= HIDDEN * largest:
        return None, f"of {largest:.1e} J only {exchanged:.1e} J are exchanged: rounding hides it"
    total = potential + kinetic
    return float(np.abs(total - total[0]).max()) / exchanged, ""
