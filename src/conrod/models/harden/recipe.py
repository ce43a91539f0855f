"""The edits that harden closures of a compiled model, as Python too, and objections to them."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from conrod.engines.mujoco import MAX_IMPEDANCE, MIN_IMPEDANCE, STOCK_SOLIMP, STOCK_SOLREF, compat
from conrod.errors import list_names
from conrod.exact.motion import Array
from conrod.mjcf.edits import Edit, Recipe
from conrod.mjcf.equalities import equality_kind, handle_indices, handle_words
from conrod.mjcf.hardenable import Closure, weight_edits, weight_rows
from conrod.mjcf.loading import name_or_number

# What is left of the regularisation, over the inverse inertia: (1 - d) / d x factor. Softness leaves an error in
# proportion to it; Newton's one iteration at MuJoCo's stock tolerance leaves one of rounding in inverse proportion,
# and below 1e-13 the solver fails. On free swings of saw, press, Robotiq 2F-85 and Cassie the sum was least between
# 1e-8 and 1e-9 (docs/hardening.md).
RESIDUAL_REGULARISATION = 1e-9
# Time constant of closures, in steps, from which on slower ones closed no better (docs/hardening.md).
MIN_TIME_CONSTANT_STEPS = 10.0


def recipe_for(model: mujoco.MjModel, closures: Sequence[Closure]) -> Recipe:
    """Build the edits that harden one or more closures, inverse weights first."""
    stiffest = max(impedance(model.eq_solimp[one.index]) for one in closures)
    factor = float(f"{min(1.0, RESIDUAL_REGULARISATION * stiffest / (1.0 - stiffest)):.3g}")
    edits = weight_edits(model, closures, factor)
    enough = float(f"{MIN_TIME_CONSTANT_STEPS * float(model.opt.timestep):.6g}")
    # Stiffness and damping given as such have no time constant; a curved closure opens with the square of its own.
    slowed = [one.index for one in closures if 0.0 < model.eq_solref[one.index, 0] < enough and not one.curved]
    if slowed:
        edits.append(Edit("eq_solref", enough, slowed, [name_or_number(model, "equality", index) for index in slowed]))
    options: dict[str, Any] = {"integrator": mujoco.mjtIntegrator.mjINT_RK4, "solver": mujoco.mjtSolver.mjSOL_NEWTON}
    # With this flag MuJoCo computes the inverse inertia at every step, and takes no weights.
    options["enableflags"] = int(model.opt.enableflags) & ~compat.enable_bit("DIAGEXACT")
    return (*edits, *(Edit(name, value) for name, value in options.items() if getattr(model.opt, name) != value))


def inverse_weights(model: mujoco.MjModel, closures: Sequence[Closure]) -> Array:
    """Inverse weights that soften closures, concatenated (n,)."""
    arrays = [getattr(model, f"{holder}_invweight0")[rows] for holder, rows in weight_rows(closures).items()]
    return np.concatenate([np.empty(0), *map(np.ravel, arrays)])


def python_lines(recipe: Recipe, path: Path) -> str:
    """The recipe as lines of Python, with the absolute path of the file."""
    reader = "from_binary_path" if path.suffix.lower() == ".mjb" else "from_xml_path"
    head = ("import mujoco", "", f"model = mujoco.MjModel.{reader}({str(path)!r})")
    again = "# again, after mj_setConst has computed these anew:"
    return "\n".join([*head, again, *(edit.line for edit in recipe)]) + "\n"


# -- softness --------------------------------------------------------------------------------------------------------


def impedance(solimp: Array) -> float:
    """MuJoCo's impedance d of a closed constraint: d0 of solimp, or the mean of d0 and d_width if width is 0."""
    first, last = np.clip(solimp[:2], MIN_IMPEDANCE, MAX_IMPEDANCE)
    return float(first if solimp[2] > 0.0 else 0.5 * (first + last))


def compliance(solref: Array, solimp: Array, least_time: float) -> float:
    """Opening of a constraint [m] under a force, over the acceleration that this gives its inverse weight [s^2].

    A constraint at rest under a force f is open by f R / (k d), R = (1 - d) / d x (inverse weight),
    k = 1 / (d_max^2 x time constant^2 x damping ratio^2) (MuJoCo's documentation, "Computation", solver parameters).
    """
    d, widest = impedance(solimp), float(np.clip(solimp[1], MIN_IMPEDANCE, MAX_IMPEDANCE))
    constant = max(float(solref[0]), least_time)
    return (1.0 - d) / d**2 * (widest * constant * float(solref[1])) ** 2


def softer_than_stock(model: mujoco.MjModel, index: int) -> bool:
    """True if an equality has a larger compliance than with MuJoCo's default solref and solimp."""
    unsafe = int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
    least = 0.0 if unsafe else 2.0 * float(model.opt.timestep)  # the least time constant that MuJoCo admits [s]
    stock = compliance(np.array(STOCK_SOLREF), np.array(STOCK_SOLIMP), least)
    # Twelve digits: what was written as stock is stock.
    return compliance(model.eq_solref[index], model.eq_solimp[index], least) > stock * (1.0 + 1e-12)


# -- objections ------------------------------------------------------------------------------------------------------

# A weight of less than this share of what MuJoCo would give it has been scaled.
MAX_SCALED_SHARE = 0.5


def refusal_reason(model: mujoco.MjModel, closures: Sequence[Closure]) -> str:
    """Why a model cannot be hardened, forced or not; empty if it can."""
    if not closures:
        if dragged := handle_indices(model):
            return f"{handle_words(model, dragged)}; nothing to harden"
        if off := [name_or_number(model, "equality", i) for i in range(model.neq) if equality_kind(model, i)]:
            return f"none of its equality constraints is active at the start: {list_names(off)}"
        return "it has no closed loop: nothing to harden (joints of its tree are exact as they are)"
    made = copy.copy(model)
    mujoco.mj_setConst(made, mujoco.MjData(made))
    stock = inverse_weights(made, closures)
    there = stock > 0.0
    if not there.any():
        return "what its closures hold has no inverse weight: nothing to harden"
    share = float((inverse_weights(model, closures)[there] / stock[there]).max())
    return f"it is hardened already: its weights are {share:.1e} of what they were" if share < MAX_SCALED_SHARE else ""


def soft_on_purpose(model: mujoco.MjModel, closures: Sequence[Closure]) -> tuple[str, ...]:
    """Reasons to take closures for soft on purpose, in words."""
    given, softer = list[str](), list[str]()
    for one in closures:
        if model.eq_solref[one.index, 0] <= 0.0:
            given.append(one.name)
        elif softer_than_stock(model, one.index):
            softer.append(one.name)
    reasons = (
        (given, "stiffness and damping are given as such (solref <= 0)"),
        (softer, "softer than MuJoCo's stock setting"),
    )
    return tuple(f"{list_names(names)}: {why}, so meant to give way" for names, why in reasons if names)


def hardening_notes(model: mujoco.MjModel, closures: Sequence[Closure]) -> tuple[str, ...]:
    """Notes on closures that stay soft, or that hardening does not close."""
    curved, hardened = [one.name for one in closures if one.curved], {one.index for one in closures}
    dragged = [index for index in handle_indices(model) if index not in hardened]
    left = [index for index in range(model.neq) if index not in hardened and index not in dragged]
    others = [name_or_number(model, "equality", index) for index in left]
    notes = {
        "MuJoCo's acceleration of it lacks the part of the velocity: hardened or not, it opens with the square of its "
        "time constant, so that is kept; the reference has this error too, so the drift does not show it": curved,
        "not active at the start, or of a flex, so not hardened": others,
    }
    said = [f"{list_names(which)}: {what}" for what, which in notes.items() if which]
    return (*said, *([f"{handle_words(model, dragged)}; so not hardened"] if dragged and closures else []))
