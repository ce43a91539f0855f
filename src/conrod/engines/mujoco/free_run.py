"""Free and torque-driven motion in MuJoCo: no flywheel, and nothing written after the start.

States are of the instants counted in steps; position and rate belong to one instant.
"""

from __future__ import annotations

import time
from dataclasses import replace

import mujoco
import numpy as np
from mujoco import rollout

from conrod.engines.engine import STOCK
from conrod.engines.free_run import FreeRun, free_energy, free_verdict
from conrod.engines.massless_rod import ModelForm
from conrod.engines.mesh_rows import tree_refusal
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.model import Build, compiled, laws_acting
from conrod.engines.mujoco.recorder import STATE, WARNINGS, warnings_kept_quiet
from conrod.engines.mujoco.settings import CONTACT_SOLIMP, PRESETS, STIFF_SOLIMP, MuJoCoSettings, harden
from conrod.engines.tree import spanning_tree
from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism

PIECE = 4096  # steps whose states are kept together
# What is left of the regularisation is 1e-10 of the closures' inertia. At a change point, where a linkage could go two
# ways, what is left of it decides, and rounding where less is left. One parallelogram that turns over for ten seconds
# in steps of 5 ms, its start moved by rounding eight times: error at most 3.9e-7 rad with this factor and four steps of
# time constant, 9.7e-7 with ten steps; 7.3e-7 and 6.8e-7 with a tenth of the factor, 5e-6 and 8e-6 with a hundredth.
# With a factor of 1e-3 and ten steps the branch was lost after 2.5 s, with 1e-5 and forty steps after 3.1 s.
FREE_HARDENING = 1e-6
STOCK_TOLERANCE = 1e-8
FREE_STEPS = 4.0  # time constant of what closes hard loops


def free_settings(mechanism: Mechanism, preset: str, timestep: float) -> MuJoCoSettings:
    """A preset for a motion that no crank prescribes, with a step of this length [s].

    Raises:
        InvalidInput: there is no such preset, or it does not apply, or a value is out of range.
    """
    if preset not in PRESETS:
        raise unknown_choice("preset", preset, PRESETS)
    # There is no turn that steps are counted by: the field has the least that it may have.
    stock = MuJoCoSettings(STOCK, 2, timestep, armature=0.0, tolerance=STOCK_TOLERANCE)
    if preset == STOCK:
        return stock
    contact = bool(mechanism.cam_contacts)
    tuned = replace(
        stock,
        preset="tuned",
        integrator="Euler" if contact else "RK4",
        solref=(8.0 * timestep, 1.0),
        solimp=STIFF_SOLIMP,
        contact_solref=(2.0 * timestep, 1.0),
        contact_solimp=CONTACT_SOLIMP,
    )
    if preset == "tuned":
        return tuned
    if preset != "hardened":
        raise InvalidInput(f"{mechanism.name}: preset {preset!r} has no rule for a motion without a drive")
    if contact:
        raise InvalidInput(f"{mechanism.name}: hardening does not apply to contact; the nearest preset is 'tuned'")
    return replace(tuned, preset="hardened", solref=(FREE_STEPS * timestep, 1.0), hardening=FREE_HARDENING)


def free_run(
    mechanism: Mechanism, settings: MuJoCoSettings, steps: int, poses: Array, rates: Array, every: int = 1
) -> FreeRun:
    """So many steps from exact poses and rates (3 n,), sampled at every so-many-th.

    Raises:
        InvalidInput: MuJoCo cannot have the mechanism as a tree with closures; says why.
    """
    tree = spanning_tree(mechanism, poses)
    if reason := tree_refusal(tree):
        raise InvalidInput(f"{mechanism.name}: {reason}")
    model = compiled(mjcf(tree, settings, f"conrod-{mechanism.name}", sensors=False))
    if settings.hardening is not None:
        harden(model, settings.hardening)
    made = Build(ModelForm(mechanism, mechanism), tree, model)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = made.coordinates(poses[None])[0], made.rates(poses[None], rates[None])[0]
    with warnings_kept_quiet(), laws_acting(model, tree):
        states, seconds = _stepped(model, data, steps, every)
    nq, nv = model.nq, model.nv
    with np.errstate(all="ignore"):
        reported_poses, reported_rates = made.forward(states[:, 1 : 1 + nq], states[:, 1 + nq : 1 + nq + nv])
        times = np.asarray(settings.timestep * every * np.arange(len(states)), dtype=float)
        verdict = free_verdict(mechanism, times, reported_poses, reported_rates)
        energy = free_energy(mechanism, reported_poses, reported_rates)
    return FreeRun(times, reported_poses, reported_rates, energy, verdict.outcome, verdict.reason, seconds)


def _stepped(model: mujoco.MjModel, data: mujoco.MjData, steps: int, every: int) -> tuple[Array, float]:
    """States at every so-many-th step (T, nstate), and the time that stepping took [s].

    From the engine's first warning on states are not finite: they are not the machine's any more.
    """
    start = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, start, STATE)
    length = max(1, PIECE // every) * every
    kept, now, done, seconds = [start[None]], start, 0, 0.0
    while done < steps:
        count = min(length, steps - done)
        states = np.empty((1, count, len(start)))
        if any(data.warning[kind].number for kind in WARNINGS.values()):
            states[:] = np.nan
        else:
            guess = data.qacc_warmstart[None].copy()
            begun = time.process_time()
            rollout.rollout(model, [data], now[None], nstep=count, initial_warmstart=guess, state=states)
            seconds += time.process_time() - begun
            # At a warning a rollout fills the rest with the last state, whose clock stands.
            clock = np.diff(states[0, :, 0], prepend=now[0])
            states[0, clock < 0.5 * model.opt.timestep] = np.nan
        kept.append(states[0, every - 1 :: every])
        now, done = states[0, -1].copy(), done + count
    return np.vstack(kept), seconds
