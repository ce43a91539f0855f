"""Edits of <option> made on a compiled model: a mesh need not be compiled again for another step."""

from __future__ import annotations

import mujoco
import numpy as np

from conrod.engines.mujoco.lint.edits import Edit, SetOption

SOLVERS = {"PGS": mujoco.mjtSolver.mjSOL_PGS, "CG": mujoco.mjtSolver.mjSOL_CG, "Newton": mujoco.mjtSolver.mjSOL_NEWTON}


def is_option(edit: Edit) -> bool:
    """Whether an edit can be made on a compiled model."""
    return isinstance(edit, SetOption) and edit.path[0] == "option"


def set_option(model: mujoco.MjModel, edit: SetOption) -> None:
    """Make the edit, in place.

    Raises:
        ValueError: it is none of those that rules make.
    """
    options = model.opt
    match edit.path, edit.attribute:
        case ("option",), "timestep" | "tolerance":
            setattr(options, edit.attribute, float(edit.value))
        case ("option",), "iterations":
            options.iterations = int(edit.value)
        case ("option",), "solver":
            options.solver = SOLVERS[edit.value]
        case ("option",), "gravity":
            options.gravity[:] = np.array(edit.value.split(), dtype=float)
        case ("option", "flag"), "autoreset" if edit.value == "disable":
            options.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        case _:
            raise ValueError(f"no edit of a compiled model: {edit.told}")
