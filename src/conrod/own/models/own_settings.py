"""Settings and limits that a user's model comes with, and the flywheel that keeps its crank at its speed."""

from __future__ import annotations

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.own.models.loading import listed, name_or_number
from conrod.own.models.model_facts import OwnSettings
from conrod.own.models.points import Crank
from conrod.own.models.request import Drive, Scan


def required_armature(model: mujoco.MjModel, scan: Scan, drive: Drive) -> float:
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


# Joints of a single coordinate.
ALONE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
TURN = 2.0 * np.pi * (1.0 - 1e-9)


def own_settings(model: mujoco.MjModel) -> OwnSettings:
    """Options of the model, and all softnesses that its closures have."""
    option = model.opt
    x, y, z = option.gravity
    return OwnSettings(
        timestep=float(option.timestep),
        integrator=mujoco.mjtIntegrator(int(option.integrator)).name.removeprefix("mjINT_"),
        solver=mujoco.mjtSolver(int(option.solver)).name.removeprefix("mjSOL_"),
        iterations=int(option.iterations),
        tolerance=float(option.tolerance),
        gravity=(float(x), float(y), float(z)),
        closure_solref=tuple(dict.fromkeys((a, b) for a, b, *_ in model.eq_solref.tolist())),
        closure_impedance=tuple(dict.fromkeys((a, b) for a, b, *_ in model.eq_solimp.tolist())),
    )


def remarks(model: mujoco.MjModel, crank: Crank) -> tuple[str, ...]:
    """Parts of the model that act on the crank beside the drive, or are treated otherwise than in the file."""
    found = []
    joint, dof = crank.joint, crank.rate
    if model.dof_armature[dof] > 0.0:
        found.append(f"the crank has an armature of {model.dof_armature[dof]:g} by itself")
    on_crank = [a for a in range(model.nu) if _acts_on(model, a, joint)]
    if on_crank:
        names = listed(name_or_number(model, "actuator", a) for a in on_crank)
        found.append(f"on the crank acts {names}: its control is left at 0, and the drive overcomes it")
    elif model.nu:
        found.append("controls of actuators are left at 0")
    if model.jnt_limited[joint]:
        low, high = model.jnt_range[joint]
        found.append(f"the crank has limits, {low:g} to {high:g} rad: the drive turns it through them")
    for what, value in (("damping", model.dof_damping[dof]), ("friction", model.dof_frictionloss[dof])):
        size = float(abs(value).max())
        if size > 0.0:
            found.append(f"the crank has a {what} of {size:g}, which the drive overcomes")
    if not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET:
        found.append("autoreset is on: a run that fails starts again in silence; it is off in these runs")
    return tuple(found)


def stops(model: mujoco.MjModel, crank: Crank, states: Array) -> tuple[str, ...]:
    """Joints whose limits keep the model from its turn.

    Args:
        states: all joint coordinates along the turn (T, nq), made without limits.
    """
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_LIMIT:
        return ()
    found = []
    for joint in np.flatnonzero(model.jnt_limited).tolist():
        if int(model.jnt_type[joint]) not in ALONE:
            continue
        low, high = (float(value) for value in model.jnt_range[joint])
        way = states[:, model.jnt_qposadr[joint]]
        # A crank may begin its turn at the lower of its limits.
        left = high - low < TURN if joint == crank.joint else bool(way.min() < low or way.max() > high)
        if left:
            unit = "rad" if int(model.jnt_type[joint]) == mujoco.mjtJoint.mjJNT_HINGE else "units of length"
            needs = "a full turn" if joint == crank.joint else f"{way.min():.6g} to {way.max():.6g}"
            found.append(
                f"{name_or_number(model, 'joint', joint)} is held to {low:.6g} to {high:.6g} {unit}, needs {needs}"
            )
    return tuple(found)


def _acts_on(model: mujoco.MjModel, actuator: int, joint: int) -> bool:
    by_joint = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    return int(model.actuator_trntype[actuator]) in by_joint and int(model.actuator_trnid[actuator][0]) == joint
