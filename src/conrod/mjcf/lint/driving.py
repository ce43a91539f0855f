"""A crank that is driven: the speeds that fit, and a flywheel that keeps them."""

from __future__ import annotations

import copy

import mujoco
import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.lint.document import Document
from conrod.mjcf.lint.edits import Edit, SetAttribute, SetOption
from conrod.mjcf.lint.motion import Observed, Start, run
from conrod.mjcf.lint.poses import equality_rows
from conrod.own.models.loading import listed, names_of
from conrod.own.models.points import Crank, crank_of, find_crank

# Flywheel of a crank, over the inertia that the machine shows to it: what the machine exchanges with it in a turn then
# changes the speed by a per cent.
FLYWHEEL = 100.0
# A speed that is off by more, because of dampers, friction or a servo on the crank, asks for a heavier flywheel: by
# what is missing and a little more, at most so often.
KEPT, SPARE, ATTEMPTS = 0.01, 1.25, 4


def driven_crank(model: mujoco.MjModel, name: str | None) -> Crank:
    """The hinge of a name, or the only one on the frame.

    Raises:
        InvalidInput: there is none, it is no hinge, or there is no telling which.
    """
    if name is not None:
        return find_crank(model, name)
    hinges = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE).tolist()
    on_frame = [j for j in hinges if model.body_weldid[model.body_parentid[model.jnt_bodyid[j]]] == 0]
    if len(on_frame) != 1:
        names = listed(names_of(model, "joint")) or "none has a name"
        raise InvalidInput(f"{len(on_frame)} hinges are on the frame: name the crank with --crank (joints: {names})")
    return crank_of(model, on_frame[0])


def driven(document: Document, data: mujoco.MjData, crank: Crank, speed: float, steps: int) -> tuple[Edit, ...]:
    """Set the machine in motion, in `data`, and give its crank a flywheel that keeps it at its speed.

    MuJoCo scales the solver's tolerance by the mean inertia, which the flywheel is part of: the tolerance is made as
    much finer, so that the solver stops where it would without.

    Args:
        speed: of the crank [rad/s].
        steps: for which it is to be kept.
    """
    model = document.model
    if not document.can_edit("joint", crank.joint):
        raise InvalidInput("the crank is made by a macro of the model; it cannot be driven")
    data.qvel[:] = fitting_speeds(model, data, crank, speed)
    momentum = np.empty(model.nv)
    mujoco.mj_mulM(model, data, momentum, data.qvel)
    inertia = float(data.qvel @ momentum) / speed**2
    start, trial = Start.of(data), copy.copy(model)
    armature = max(float(model.dof_armature[crank.rate]), FLYWHEEL * inertia)
    for _ in range(ATTEMPTS):
        trial.dof_armature[crank.rate] = armature
        off = speed_off(np.array([s.qvel[crank.rate] for s in run(trial, start, steps, Observed()).states]), speed)
        if not KEPT < off < np.inf:
            break
        armature *= SPARE * off / KEPT
    flywheel = SetAttribute("joint", crank.joint, "crank", "armature", repr(armature))
    heavier = document.compiled((flywheel,)).stat.meaninertia / model.stat.meaninertia
    return flywheel, SetOption(("option",), "tolerance", repr(float(model.opt.tolerance / heavier)))


def speed_off(speeds: Array, wanted: float) -> float:
    """The largest deviation of speeds from the wanted one, over it."""
    return float(np.abs(speeds / wanted - 1.0).max())


def fitting_speeds(model: mujoco.MjModel, data: mujoco.MjData, crank: Crank, speed: float) -> Array:
    """Joint rates (nv,) that part no closure at a rate of the crank, the least of them where it leaves some free."""
    data.qvel[:] = 0.0
    mujoco.mj_forward(model, data)
    jacobian = equality_rows(model, data).jacobian
    others = np.delete(np.arange(model.nv), crank.rate)
    speeds = np.zeros(model.nv)
    speeds[crank.rate] = speed
    speeds[others] = -np.linalg.pinv(jacobian[:, others], rcond=1e-9) @ jacobian[:, crank.rate] * speed
    return speeds
