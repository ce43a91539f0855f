"""Free and torque-driven motion in MuJoCo: no flywheel, and nothing is written after the start.

The time of a sample is step index times step; position and rate of a sample belong to the same instant.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from conrod.engines.engine import PIECE_STEPS, STOCK
from conrod.engines.mujoco import MUJOCO_PRESETS, STOCK_TOLERANCE, MuJoCoSettings
from conrod.engines.mujoco.compiled_edits import harden
from conrod.engines.mujoco.dynamics import MuJoCoRecorder
from conrod.engines.mujoco.mjcf import mjcf_text
from conrod.engines.mujoco.model import MuJoCoModel, compile_mjcf
from conrod.engines.spanning_tree import grow_spanning_tree, tree_refusal
from conrod.engines.tracks import FreeRun, Pace
from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism

# Both rules below are measured: docs/free-motion.md, "How closures are stabilised". Regularisation is soft and damped,
# and dissipates energy at every crossing of branches; less damping dissipates less. A stiffer closure (0.4 steps, not
# 0.8) is better at crossings, and five times worse elsewhere.
TUNED_TIME_CONSTANT_STEPS, TUNED_DAMPING_RATIO = 2.0, 0.4  # time constant, damping ratio
# Hardened closures have no such loss. With stock's solver tolerance of 1e-8 the solver's residual was the largest
# error; with 0 it runs to its last iteration, and more than five change nothing (ten four-bars: 6.7e-8, with 100
# 6.6e-8). Time constants are fractions of the fastest revolution: the stages of RK4 leave the joints by the square of
# the step, and closures whose time constant followed the step would undo that by as much at any step, and lose order.
# Where branches cross, a gap moves links by the gap over the sine of their angle, and has to be closed before: a slow
# time constant (a fifth of the revolution) diverges there.
REVOLUTION_OVER_TIME_CONSTANT, REVOLUTION_OVER_TIME_CONSTANT_AT_CROSSINGS = 5.0, 100.0
FREE_HARDENING_FACTOR, HARDENED_ITERATIONS = 1e-8, 5


def free_settings(mechanism: Mechanism, preset: str, timestep: float, pace: Pace) -> MuJoCoSettings:
    """Settings of a preset for motion without a drive, with a time step [s].

    Raises:
        InvalidInput: there is no such preset, or it does not apply, or a value is out of range.
    """
    if preset not in MUJOCO_PRESETS:
        raise unknown_choice("preset", preset, MUJOCO_PRESETS)
    # No revolution exists to count steps by: the field has its least value.
    stock = MuJoCoSettings(STOCK, 2, timestep, armature=0.0, tolerance=STOCK_TOLERANCE)
    if preset == STOCK:
        return stock
    contact = bool(mechanism.cam_contacts)
    tuned = stock.with_tuned_solver(contact)
    if preset == "tuned":
        # A machine with contact keeps the softer closures of `tuned`.
        return tuned if contact else replace(tuned, solref=(TUNED_TIME_CONSTANT_STEPS * timestep, TUNED_DAMPING_RATIO))
    if contact:
        raise InvalidInput(f"{mechanism.name}: hardening does not apply to contact; the nearest preset is 'tuned'")
    return replace(
        tuned,
        preset="hardened",
        solref=(
            pace.revolution
            / (REVOLUTION_OVER_TIME_CONSTANT_AT_CROSSINGS if pace.crosses_branches else REVOLUTION_OVER_TIME_CONSTANT),
            1.0,
        ),
        hardening=FREE_HARDENING_FACTOR,
        tolerance=0.0,
        iterations=HARDENED_ITERATIONS,
    )


def free_run(
    mechanism: Mechanism, preset: str, timestep: float, steps: int, poses: Array, rates: Array, pace: Pace,
    every: int = 1,
) -> FreeRun:  # fmt: skip
    """Simulate `steps` steps from exact poses and rates (3 n,), sampled at each `every` steps.

    Raises:
        InvalidInput: there is no such preset, or MuJoCo cannot have the mechanism as a tree with closures; says why.
    """
    settings = free_settings(mechanism, preset, timestep, pace)
    tree = grow_spanning_tree(mechanism, poses)
    if reason := tree_refusal(tree):
        raise InvalidInput(f"{mechanism.name}: {reason}")
    model = compile_mjcf(mjcf_text(tree, settings, f"conrod-{mechanism.name}", sensors=False))
    if settings.hardening is not None:
        harden(model, settings.hardening)
    made = MuJoCoModel(tree, model)
    recorder = MuJoCoRecorder(made, made.coordinates(poses[None])[0], made.rates(poses[None], rates[None])[0])
    kept, clock = list[Array](), -settings.timestep
    length = max(1, PIECE_STEPS // every) * every
    for first in range(0, steps + 1, length):
        states = recorder.next_samples(min(length, steps + 1 - first))[0]
        # After a warning the clock stands still, and the states are no longer the machine's.
        standing, clock = np.diff(states[:, 0], prepend=clock) < 0.5 * settings.timestep, states[-1, 0]
        states[standing] = np.nan
        kept.append(states[::every])
    found, nq = np.vstack(kept), model.nq
    with np.errstate(all="ignore"):
        reported = made.forward_kinematics(found[:, 1 : 1 + nq], found[:, 1 + nq : 1 + nq + model.nv])
    times = np.asarray(settings.timestep * every * np.arange(len(found)), dtype=float)
    return FreeRun.from_states(mechanism, times, reported)
