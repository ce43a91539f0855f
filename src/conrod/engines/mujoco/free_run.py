"""Free and torque-driven motion in MuJoCo: no flywheel, and nothing written after the start.

States are of the instants counted in steps; position and rate belong to one instant.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from conrod.engines.engine import PIECE_STEPS, STOCK
from conrod.engines.mujoco import MUJOCO_PRESETS, STOCK_TOLERANCE, MuJoCoSettings
from conrod.engines.mujoco.compiled_edits import harden
from conrod.engines.mujoco.dynamics import Recorder
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.model import Build, compiled
from conrod.engines.spanning_tree import grow_spanning_tree, tree_refusal
from conrod.engines.tracks import FreeRun, Pace
from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism

# Both rules below are measured: docs/free-motion.md, "How closures are stabilised". Regularisation is soft and damped,
# and takes energy at every crossing of branches; less damping takes less. A closure that is stiffer still (0.4 steps in
# place of 0.8) is better at crossings, and five times worse where there are none.
TUNED_STEPS, TUNED_DAMPING = 2.0, 0.4  # time constant, damping ratio
# Hardened closures have no such loss. With stock's solver tolerance of 1e-8 the solver's rest was the largest error;
# with 0 it goes on to its last iteration, and more than five change nothing (ten four-bars: 6.7e-8, with 100 6.6e-8).
# Time constants are parts of the fastest turn: the stages of RK4 leave the joints by the square of the step, and a
# closure that follows the step pushes them back by as much as it does at any step, so that order is lost. Where
# branches cross, a gap moves links by it over the sine of their angle, and has to be closed before: a slow
# stabilisation (a fifth of the turn) diverges there.
SETTLING, SETTLING_AT_CROSSINGS = 5.0, 100.0
FREE_HARDENING, HARDENED_ITERATIONS = 1e-8, 5


def free_settings(mechanism: Mechanism, preset: str, timestep: float, pace: Pace) -> MuJoCoSettings:
    """A preset for a motion that no crank prescribes, with a step of this length [s].

    Raises:
        InvalidInput: there is no such preset, or it does not apply, or a value is out of range.
    """
    if preset not in MUJOCO_PRESETS:
        raise unknown_choice("preset", preset, MUJOCO_PRESETS)
    # There is no turn that steps are counted by: the field has the least that it may have.
    stock = MuJoCoSettings(STOCK, 2, timestep, armature=0.0, tolerance=STOCK_TOLERANCE)
    if preset == STOCK:
        return stock
    contact = bool(mechanism.cam_contacts)
    tuned = stock.as_tuned(contact)
    if preset == "tuned":
        # Contact is another matter, and the loops beside it are closed as loosely.
        return tuned if contact else replace(tuned, solref=(TUNED_STEPS * timestep, TUNED_DAMPING))
    if contact:
        raise InvalidInput(f"{mechanism.name}: hardening does not apply to contact; the nearest preset is 'tuned'")
    return replace(
        tuned,
        preset="hardened",
        solref=(pace.revolution / (SETTLING_AT_CROSSINGS if pace.crosses_branches else SETTLING), 1.0),
        hardening=FREE_HARDENING,
        tolerance=0.0,
        iterations=HARDENED_ITERATIONS,
    )


def free_run(
    mechanism: Mechanism, preset: str, timestep: float, steps: int, poses: Array, rates: Array, pace: Pace,
    every: int = 1,
) -> FreeRun:  # fmt: skip
    """So many steps from exact poses and rates (3 n,), sampled at every so-many-th.

    Raises:
        InvalidInput: there is no such preset, or MuJoCo cannot have the mechanism as a tree with closures; says why.
    """
    settings = free_settings(mechanism, preset, timestep, pace)
    tree = grow_spanning_tree(mechanism, poses)
    if reason := tree_refusal(tree):
        raise InvalidInput(f"{mechanism.name}: {reason}")
    model = compiled(mjcf(tree, settings, f"conrod-{mechanism.name}", sensors=False))
    if settings.hardening is not None:
        harden(model, settings.hardening)
    made = Build(tree, model)
    recorder = Recorder(made, made.coordinates(poses[None])[0], made.rates(poses[None], rates[None])[0])
    kept, clock = list[Array](), -settings.timestep
    length = max(1, PIECE_STEPS // every) * every
    for first in range(0, steps + 1, length):
        states = recorder.next(min(length, steps + 1 - first))[0]
        # After a warning the clock stands, and the states are not the machine's any more.
        standing, clock = np.diff(states[:, 0], prepend=clock) < 0.5 * settings.timestep, states[-1, 0]
        states[standing] = np.nan
        kept.append(states[::every])
    found, nq = np.vstack(kept), model.nq
    with np.errstate(all="ignore"):
        reported = made.forward_kinematics(found[:, 1 : 1 + nq], found[:, 1 + nq : 1 + nq + model.nv])
    times = np.asarray(settings.timestep * every * np.arange(len(found)), dtype=float)
    return FreeRun.from_states(mechanism, times, reported)
