"""Edits of compiled models, with all that MuJoCo derives from an edited field; docs/design.md has the table."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import TYPE_CHECKING

from conrod.engines.engine import DeferredLibrary
from conrod.engines.mujoco import HARDENING_FACTOR, compat
from conrod.exact.motion import Array

if TYPE_CHECKING:
    import mujoco
else:
    mujoco = DeferredLibrary("mujoco")

# What MuJoCo's compiler estimates at the reference pose from the inverse of the mass matrix.
INVERSE_WEIGHTS = ("body_invweight0", "dof_invweight0", "tendon_invweight0")


def harden(model: mujoco.MjModel, factor: float = HARDENING_FACTOR) -> None:
    """Make the constraints of a compiled model hard, in place.

    MuJoCo adds to every constraint a regularisation R = (1 - d) / d x (an estimate of its inverse inertia), which
    it takes from `body_invweight0`, `dof_invweight0` and `tendon_invweight0`. MJCF bounds the impedance d by 0.9999;
    scaling the estimate has no such bound. All constraints harden, contacts and limits too; `mj_setConst` undoes it.
    The flag `diagexact`, with which MuJoCo computes the inverse inertia at every step in place of the estimate, is
    switched off.

    Args:
        model: an `mujoco.MjModel` in double precision.
        factor: what the inverse weights are multiplied by, in (0, 1]. The default is for a driven machine that is
            solved to tolerance 0. For a free swing at MuJoCo's stock tolerance 1e-9 d / (1 - d) is best: less is lost
            in rounding (docs/hardening.md, "Which factor").

    Raises:
        ValueError: the factor is out of range.
    """
    if not 0.0 < factor <= 1.0:
        raise ValueError(f"hardening factor {factor!r} is out of range: 0 < factor <= 1")
    model.body_invweight0[:] *= factor
    model.dof_invweight0[:] *= factor
    model.tendon_invweight0[:] *= factor
    model.opt.enableflags &= ~compat.enable_bit("DIAGEXACT")


def set_armature(model: mujoco.MjModel, dofs: Iterable[int], armature: float) -> None:
    """Set the armature of degrees of freedom [kg m^2, kg], and the fields that MuJoCo derives from it, in place.

    MuJoCo derives from `dof_armature` (mj_setConst):

    - `dof_M0`, which *replaces* armature and inertia in the mass matrix where `dof_simplenum` > 0 (mj_makeM):
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
    """Replace estimates by new ones, each with the factor by which its value had been scaled."""
    there = before > 0.0
    values[there] = after[there] * (values[there] / before[there])


def set_step(model: mujoco.MjModel, step: float) -> None:
    """Set the time step [s] of a compiled model, in place, and the flex factorisation that depends on it.

    MuJoCo factorises M + (h^2 + h damping) K of thin flexes when it compiles (setEfm0Factor). Nothing else of a
    compiled model depends on the step.
    """
    model.opt.timestep = step
    if getattr(model, "nefm0dof", 0):
        made = copy.copy(model)
        mujoco.mj_setConst(made, mujoco.MjData(made))
        model.efm0_L[:] = made.efm0_L
