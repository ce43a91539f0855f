"""The state at which a file's own run starts: loops that are open, or that its rates open, and a closed pose."""

from __future__ import annotations

import copy

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.exact.motion import Array
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.exact.space.loop_closure import jacobian
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.equalities import close_loops, closure_name, constraint_violations, handle_indices
from conrod.mjcf.request import MIN_NAMED_OPENING, OpenStart, StartRates

CLOSING_TOLERANCE = 1e-12  # of the machine's extent
POSE_DIGITS, POSE_DECIMALS = 10, 12  # of a pose in words: what they leave open is far below what is said to be open


def open_start(model: mujoco.MjModel, data: mujoco.MjData, extent: float, pose: str) -> OpenStart | None:
    """Find the closures that are open in a pose; None if all are closed.

    Args:
        data: MuJoCo's data at the pose.
        extent: size of the machine, in the model's unit of length.
        pose: the pose, in words.
    """
    looked_at = copy.copy(data)
    with silence_warnings():
        mujoco.mj_fwdPosition(model, looked_at)
        found, dragged = constraint_violations(model, looked_at, extent), handle_indices(model)
        gaps = {closure_name(model, k): float(found[k]) for k in range(model.neq) if k not in dragged}
        ajar = {name: gap for name, gap in gaps.items() if gap > MIN_NAMED_OPENING * extent}
        if not ajar:
            return None
        closed = close_loops(model, looked_at, CLOSING_TOLERANCE * extent)
    return OpenStart(pose, ajar, extent, pose_words(looked_at.qpos) if closed else "")


def pose_words(coordinates: Array) -> str:
    """Coordinates (nq,) as the text of MJCF's `qpos`."""
    return " ".join(f"{value:.{POSE_DIGITS}g}" for value in np.round(coordinates, POSE_DECIMALS) + 0.0)


def start_rate_violation(machine: DrivenTree, data: mujoco.MjData) -> StartRates | None:
    """Compare the rates of a closed start with the nearest rates that satisfy its loops; None if they agree.

    Rates v open the closures at J v, with J their Jacobian. The rates that the loops ask for are the nearest ones with
    J v = 0 that leave those of driven joints as they are.

    Args:
        machine: the machine; the laws of its drives are not used.
        data: MuJoCo's data at the start.
    """
    tree, found = machine.tree, forward_kinematics(machine.tree, np.array(data.qpos)[:, None])
    rates, matrix = np.array(data.qvel), jacobian(found, 1)[0]
    speed = float(np.abs(machine.rate_sizes * rates).max(initial=0.0))
    opening = float(np.abs(matrix @ rates).max(initial=0.0))
    if not opening > MIN_NAMED_OPENING * speed:
        return None
    step = np.linalg.lstsq(machine.scaled_jacobian(found), -(matrix @ rates), rcond=RANK_TOLERANCE)[0]
    asked = rates.copy()
    asked[machine.free] += machine.weights * step
    worst = int(np.argmax(np.abs(machine.rate_sizes * (asked - rates))))
    joint = next(one for one in tree.joints if worst in range(tree.freedom)[one.rates])
    unit = "m/s" if joint.unit == "m" else "rad/s"
    return StartRates(opening, joint.name, float(rates[worst]), float(asked[worst]), unit)
