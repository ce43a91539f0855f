"""Edits of compiled models that take along what MuJoCo derives from the edited field; docs/design.md has the table."""

from __future__ import annotations

import copy
from collections.abc import Iterable

import mujoco

from conrod.exact.motion import Array

# What MuJoCo's compiler estimates at the reference pose from the inverse of the mass matrix.
INVERSE_WEIGHTS = ("body_invweight0", "dof_invweight0", "tendon_invweight0")


def set_armature(model: mujoco.MjModel, dofs: Iterable[int], armature: float) -> None:
    """Set the armature of degrees of freedom [kg m^2, kg], and what MuJoCo makes of it, in place.

    MuJoCo derives from `dof_armature` (mj_setConst):

    - `dof_M0`, which stands in the mass matrix *in place of* armature and inertia where `dof_simplenum` > 0 (mj_makeM):
      a body without children that hangs on the world, centred on a joint along an axis of its own;
    - `body_`, `dof_` and `tendon_invweight0`, by which constraints are softened (mj_diagApprox). They keep the factor
      that they have been scaled by, so that a hardened model stays as hard;
    - `stat.meaninertia`, which is left: with a flywheel in it the solver stops before its first iteration;
    - `actuator_acc0`, which is left: a muscle's strength is made of it, and the drive is no part of the machine.

    mj_setConst is called on copies: on the model it would undo hardening and the statistics that its file gives. Nor is
    the file compiled again: a binary model has none, and a spring with a `springdamper`, or an actuator with a
    `dampratio`, would become another one.
    """
    before, after = copy.copy(model), copy.copy(model)
    for dof in dofs:
        after.dof_armature[dof] = armature
    for made in (before, after):
        mujoco.mj_setConst(made, mujoco.MjData(made))
    model.dof_armature[:], model.dof_M0[:] = after.dof_armature, after.dof_M0
    for name in INVERSE_WEIGHTS:
        _rescale(getattr(model, name), getattr(before, name), getattr(after, name))


def _rescale(values: Array, before: Array, after: Array) -> None:
    """Put new estimates in place of old ones, each times the factor that its value had been scaled by."""
    there = before > 0.0
    values[there] = after[there] * (values[there] / before[there])


def set_step(model: mujoco.MjModel, step: float) -> None:
    """Set the time step [s], and the factor of the bending stiffness of a flex that it is in, in place.

    MuJoCo factorises M + (h^2 + h damping) K of thin flexes when it compiles (setEfm0Factor). Nothing else of a
    compiled model depends on the step.
    """
    model.opt.timestep = step
    if getattr(model, "nefm0dof", 0):
        made = copy.copy(model)
        mujoco.mj_setConst(made, mujoco.MjData(made))
        model.efm0_L[:] = made.efm0_L
