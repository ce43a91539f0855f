"""Free and torque-driven motion in MuJoCo: no flywheel, and nothing written after the start.

States are of the instants counted in steps; position and rate belong to one instant.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from conrod.engines.engine import PIECE, STOCK
from conrod.engines.free_run import FreeRun
from conrod.engines.massless_rod import ModelForm
from conrod.engines.mesh_rows import tree_refusal
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.model import Build, compiled
from conrod.engines.mujoco.recorder import Recorder
from conrod.engines.mujoco.settings import PRESETS, MuJoCoSettings, harden
from conrod.engines.tree import spanning_tree
from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism

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
    tuned = stock.as_tuned(contact)
    if preset == "tuned":
        return tuned
    if preset != "hardened":
        raise InvalidInput(f"{mechanism.name}: preset {preset!r} has no rule for a motion without a drive")
    if contact:
        raise InvalidInput(f"{mechanism.name}: hardening does not apply to contact; the nearest preset is 'tuned'")
    return replace(tuned, preset="hardened", solref=(FREE_STEPS * timestep, 1.0), hardening=FREE_HARDENING)


def free_run(
    mechanism: Mechanism, preset: str, timestep: float, steps: int, poses: Array, rates: Array, every: int = 1
) -> FreeRun:
    """So many steps from exact poses and rates (3 n,), sampled at every so-many-th.

    Raises:
        InvalidInput: there is no such preset, or MuJoCo cannot have the mechanism as a tree with closures; says why.
    """
    settings, tree = free_settings(mechanism, preset, timestep), spanning_tree(mechanism, poses)
    if reason := tree_refusal(tree):
        raise InvalidInput(f"{mechanism.name}: {reason}")
    model = compiled(mjcf(tree, settings, f"conrod-{mechanism.name}", sensors=False))
    if settings.hardening is not None:
        harden(model, settings.hardening)
    made = Build(ModelForm(mechanism, mechanism), tree, model)
    recorder = Recorder(made, settings, made.coordinates(poses[None])[0], made.rates(poses[None], rates[None])[0])
    kept, seconds, clock = list[Array](), 0.0, -settings.timestep
    length = max(1, PIECE // every) * every
    for first in range(0, steps + 1, length):
        begun = time.process_time()
        states = recorder.next(min(length, steps + 1 - first))[0]
        seconds += time.process_time() - begun
        # After a warning the clock stands, and the states are not the machine's any more.
        standing, clock = np.diff(states[:, 0], prepend=clock) < 0.5 * settings.timestep, states[-1, 0]
        states[standing] = np.nan
        kept.append(states[::every])
    found, nq = np.vstack(kept), model.nq
    with np.errstate(all="ignore"):
        reported = made.forward(found[:, 1 : 1 + nq], found[:, 1 + nq : 1 + nq + model.nv])
    times = np.asarray(settings.timestep * every * np.arange(len(found)), dtype=float)
    return FreeRun.judged(mechanism, times, reported, seconds)
