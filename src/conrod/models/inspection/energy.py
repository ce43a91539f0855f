"""Energy of an open chain that swings freely: what the time step adds to it, and the step at which it adds none."""

from __future__ import annotations

import copy
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco import compat
from conrod.engines.mujoco.compiled_edits import set_step
from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.exact.motion import Array
from conrod.mjcf.driving import break_off_reason
from conrod.models.inspection.moving_results import MAX_GROWTH, FreeEnergy

SECONDS, MAX_STEPS, INSTANTS = 4.0, 8000, 200  # of a run
HALVINGS = 5
START_RATE = 1.0  # [rad/s or m/s] of all joints, where nothing else moves the chain
STILL = 1e-9  # kinetic energy over that at the start rates, below which nothing moves
SWITCHED_OFF = ("ACTUATION", "CONTACT", "DAMPER", "FRICTIONLOSS", "LIMIT")


def free_energy(model: mujoco.MjModel, start: mujoco.MjData) -> FreeEnergy | None:
    """Measure how a freely swinging open chain gains or loses energy; None for any other model.

    Kinetic energy is v' M v / 2, potential energy that of weight and springs (MuJoCo documentation, mjData.energy).
    Without loads their sum stays.

    Args:
        start: data at the start; it is not changed.
    """
    if np.any(model.eq_active0) or not model.nv or model.nflex or model.nplugin or np.any(model.body_gravcomp):
        return None
    if model.opt.density or model.opt.viscosity or np.any(model.opt.wind):
        return None
    made = copy.copy(model)
    for name in (*SWITCHED_OFF, "AUTORESET"):
        made.opt.disableflags |= compat.disable_bit(name)
    step = float(model.opt.timestep)
    seconds = min(SECONDS, MAX_STEPS * step)
    state = np.array(start.qpos), np.array(start.qvel)
    growth, broke, kinetic = _run_freely(made, state, seconds)
    pushed = kinetic is not None and kinetic <= STILL * _kinetic(made, state[0], np.full(model.nv, START_RATE))
    if pushed:
        state = state[0], np.full(model.nv, START_RATE)
        growth, broke, _ = _run_freely(made, state, seconds)
    name = mujoco.mjtIntegrator(model.opt.integrator).name.removeprefix("mjINT_")
    shown = name if name == "RK4" else "Euler" if name == "EULER" else name.lower()
    parts = (model.dof_damping, model.dof_frictionloss, model.tendon_damping, model.actuator_biasprm[:, 2])
    damped = any(bool(np.any(part)) for part in parts)
    found = FreeEnergy(step, shown, seconds, growth, broke, pushed=pushed, damped=damped)
    if not found.grows:
        return found
    steady, rk4 = None, None
    for k in range(1, HALVINGS + 1):
        set_step(made, 0.5**k * step)
        less, _, _ = _run_freely(made, state, seconds)
        if less is not None and less <= MAX_GROWTH:
            steady = 0.5**k * step
            break
    if name != "RK4":
        set_step(made, step)
        made.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
        rk4, _, _ = _run_freely(made, state, seconds)
    return replace(found, steady_step=steady, rk4=rk4)


def _kinetic(model: mujoco.MjModel, coordinates: Array, rates: Array) -> float:
    data = mujoco.MjData(model)
    return _energy(model, data, coordinates, rates)[1]


def _energy(model: mujoco.MjModel, aside: mujoco.MjData, coordinates: Array, rates: Array) -> tuple[float, float]:
    """Potential and kinetic energy [J] of a state."""
    aside.qpos[:], aside.qvel[:] = coordinates, rates
    mujoco.mj_fwdPosition(model, aside)
    mujoco.mj_fwdVelocity(model, aside)
    mujoco.mj_energyPos(model, aside)
    mujoco.mj_energyVel(model, aside)
    return float(aside.energy[0]), float(aside.energy[1])


def _run_freely(
    model: mujoco.MjModel, state: tuple[Array, Array], seconds: float
) -> tuple[float | None, str, float | None]:
    """Swing freely; return energy gain over largest kinetic energy, reason of a stop, the latter [J]."""
    data, aside = mujoco.MjData(model), mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = state
    step = float(model.opt.timestep)
    count = max(2, round(seconds / step))
    every = max(1, count // INSTANTS)
    seen = [_energy(model, aside, *state)]
    with silence_warnings():
        for _ in range(0, count, every):
            mujoco.mj_step(model, data, every)
            if reason := break_off_reason(model, data):
                return None, f"{reason} at {float(data.time):.3g} s", None
            seen.append(_energy(model, aside, data.qpos, data.qvel))
    found = np.array(seen)
    total, most = found.sum(axis=1), float(found[:, 1].max())
    # Within a swing the energy of a symplectic step oscillates: what stays of it in the last quarter is gained.
    last = float(np.median(total[-max(1, len(total) // 4) :]))
    return (last - float(total[0])) / max(most, 1e-300), "", most
