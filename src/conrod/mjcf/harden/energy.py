"""Energy drift of closed loops, on copies of the model in which nothing takes or gives energy."""

from __future__ import annotations

import copy
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.mjcf.harden.runs import STATE, Pace, paced
from conrod.mjcf.stepping import broken

BIT = mujoco.mjtDisableBit
# Of the largest energy: where what is exchanged is less than this share of it, rounding hides the drift.
HIDDEN = 1e-9


@dataclass(frozen=True)
class EnergyDrift:
    """Energy drift of one run.

    Attributes:
        share: largest change of the energy over the kinetic energy exchanged; None where it says nothing.
        note: why it says nothing.
    """

    share: float | None
    note: str = ""


def conservative(model: mujoco.MjModel) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    """A copy without what takes or gives energy, and the names of what was left out of it."""
    bare = copy.copy(model)
    bare.opt.disableflags |= int(
        BIT.mjDSBL_CONTACT | BIT.mjDSBL_LIMIT | BIT.mjDSBL_FRICTIONLOSS | BIT.mjDSBL_DAMPER | BIT.mjDSBL_ACTUATION
    )
    # MuJoCo's potential energy does not know of the gravity that it takes away.
    bare.body_gravcomp[:] = 0.0
    bare.opt.density = bare.opt.viscosity = 0.0
    bare.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    collides = bool(model.geom_contype.any() or model.geom_conaffinity.any() or model.npair)
    left_out = {
        "contacts": collides and not _off(model, BIT.mjDSBL_CONTACT),
        "limits": bool(model.jnt_limited.any() or model.tendon_limited.any()) and not _off(model, BIT.mjDSBL_LIMIT),
        "friction": bool(model.dof_frictionloss.any() or model.tendon_frictionloss.any()),
        "damping": bool(model.dof_damping.any() or model.tendon_damping.any()),
        "actuators": bool(model.nu),
        "gravity compensation": bool(model.body_gravcomp.any()),
        "fluid": bool(model.opt.density or model.opt.viscosity),
    }
    return bare, tuple(name for name, there in left_out.items() if there)


def energy_drift(model: mujoco.MjModel, state: Array, pace: Pace) -> EnergyDrift:
    """Largest change of the energy in a run of a conservative copy of a model."""
    run = paced(model, pace)
    data, aside = mujoco.MjData(run), mujoco.MjData(run)
    mujoco.mj_setState(run, data, state, STATE)
    found = []
    with warnings_kept_quiet():
        for sample in range(pace.samples + 1):
            aside.qpos[:], aside.qvel[:] = data.qpos, data.qvel
            mujoco.mj_fwdPosition(run, aside)
            mujoco.mj_fwdVelocity(run, aside)
            mujoco.mj_energyPos(run, aside)
            mujoco.mj_energyVel(run, aside)
            found.append(aside.energy.copy())
            if sample < pace.samples:
                mujoco.mj_step(run, data, pace.stride)
            if broken(data):
                return EnergyDrift(None, "without them a run breaks off")
    potential, kinetic = np.array(found).T
    exchanged = float(kinetic.max() - kinetic.min())
    largest = float(max(np.abs(potential).max(), kinetic.max()))
    if exchanged <= HIDDEN * largest:
        if exchanged == 0.0:
            return EnergyDrift(None, "nothing moves")
        return EnergyDrift(None, f"of {largest:.1e} J only {exchanged:.1e} J are exchanged: rounding hides it")
    total = potential + kinetic
    return EnergyDrift(float(np.abs(total - total[0]).max()) / exchanged)


def _off(model: mujoco.MjModel, flag: mujoco.mjtDisableBit) -> bool:
    return bool(int(model.opt.disableflags) & int(flag))
