"""How heavy a flywheel must be that keeps a model's crank at its speed."""

from __future__ import annotations

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.motion import Array
from conrod.user_model import Drive, Scan


def needed_armature(model: mujoco.MjModel, scan: Scan, drive: Drive) -> float:
    """Armature with which the energy that the crank exchanges changes its speed by no more than the ripple.

    Along the exact motion the machine's energy, less the work that dampers, friction and actuators have done, is what
    the flywheel has given: a change of the speed by d takes I w^2 d.
    """
    data = mujoco.MjData(model)
    energy, power = [], []
    with warnings_kept_quiet():
        for state, rates in zip(scan.states, scan.rates, strict=True):
            data.qpos[:], data.qvel[:] = state, drive.rate * rates
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_fwdVelocity(model, data)
            mujoco.mj_fwdActuation(model, data)
            mujoco.mj_energyPos(model, data)
            mujoco.mj_energyVel(model, data)
            energy.append(float(data.energy.sum()))
            power.append(_power(model, data))
    # Turn after turn the same work is done once more.
    step = 2.0 * np.pi / abs(drive.rate) / len(power)
    work = np.cumsum(np.tile(power, max(1, int(np.ceil(drive.turns))))) * step
    given = np.tile(energy, max(1, int(np.ceil(drive.turns)))) - work
    return float(np.ptp(given)) / (drive.rate**2 * drive.ripple)


def _power(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Of all that acts along the joints and has no energy [W]."""
    acting: Array = data.qfrc_passive - data.qfrc_spring + data.qfrc_actuator
    return float(acting @ data.qvel - model.dof_frictionloss @ np.abs(data.qvel))
