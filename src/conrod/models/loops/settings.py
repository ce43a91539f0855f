"""Settings of MuJoCo for a model's closed loops: the edits that make them, and the lines to paste.

Closures alone are changed: what the file says of contacts and limits stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.engine import PASTED_DIGITS
from conrod.engines.mujoco import INTEGRATORS, SOLVERS, compat
from conrod.engines.mujoco.driven_joints import SOLVER_TOLERANCE, preset_settings
from conrod.errors import InvalidInput
from conrod.mjcf.document import Document
from conrod.mjcf.edits import Edit, Recipe
from conrod.mjcf.hardenable import active_closures, weight_edits
from conrod.mjcf.loading import name_or_number
from conrod.mjcf.loop_results import OWN_SETTINGS

# Preset of the closures and integrator (the preset's own where none is named) of all settings that are searched, those
# that most often are the cheapest first. Under RK4 alone stiff servos and dampers fail at large steps.
SEARCHED = {
    "hardened": ("hardened", ""),
    "tuned": ("tuned", ""),
    OWN_SETTINGS: (OWN_SETTINGS, ""),
    "tuned with implicitfast": ("tuned", "implicitfast"),
    "tuned with Euler": ("tuned", "Euler"),
    "tuned with implicit": ("tuned", "implicit"),
}
# Time constant of closures, in steps, for integrators of order 1: the least that MuJoCo admits closes loops best.
FIRST_ORDER_TIME_CONSTANT = 2.0
AGAIN = "# again, after mj_setConst has computed these anew:"


def settings_edits(model: mujoco.MjModel, name: str, step: float, period: float, *, idle: bool) -> Recipe:
    """Return the edits that give a compiled model the settings of a name of `SEARCHED`, and a step [s].

    Args:
        period: time [s] that the slowest drive takes for its law.
        idle: as in `conrod.mjcf.driven_runs.with_settings`.
    """
    preset, integrator = SEARCHED[name]
    step, tolerance = _round_to_paste(step), Edit("tolerance", SOLVER_TOLERANCE)
    if preset == OWN_SETTINGS:
        return Edit("timestep", step), tolerance
    settings = preset_settings(preset, step, period, idle)
    if integrator:
        settings = replace(settings, integrator=integrator, solref=(FIRST_ORDER_TIME_CONSTANT * step, 1.0))
    edits = [
        Edit("timestep", step),
        Edit("integrator", getattr(mujoco.mjtIntegrator, f"mjINT_{settings.integrator.upper()}")),
        Edit("solver", getattr(mujoco.mjtSolver, f"mjSOL_{settings.solver.upper()}")),
        Edit("iterations", settings.iterations),
        tolerance,
    ]
    if not (closures := active_closures(model)):
        return tuple(edits)
    rows, names = [one.index for one in closures], [one.name for one in closures]
    edits += [
        Edit("eq_solref", tuple(map(_round_to_paste, settings.solref)), rows, names),
        Edit("eq_solimp", settings.solimp, rows, names),
    ]
    if settings.hardening is not None:
        edits += weight_edits(model, closures, settings.hardening)
        flags = int(model.opt.enableflags) & ~compat.enable_bit("DIAGEXACT")  # with it MuJoCo takes no weights
        if flags != model.opt.enableflags:
            edits.append(Edit("enableflags", flags))
    return tuple(edits)


def _round_to_paste(value: float) -> float:
    return float(f"{value:.{PASTED_DIGITS}g}")


# -- lines to paste ----------------------------------------------------------------------------------------------------


def python_lines(recipe: Recipe) -> str:
    """Return the lines of Python that make all edits on a compiled `model`."""
    return "\n".join([*(edit.line for edit in recipe if not edit.scales), *after_compiling(recipe, every=False)])


def after_compiling(recipe: Recipe, *, every: bool = True) -> tuple[str, ...]:
    """Return the lines of Python for what MJCF cannot express.

    Args:
        every: whether options that MJCF can express otherwise are among them.
    """
    scaled = [edit.line for edit in recipe if edit.scales]
    flags = [edit.line for edit in recipe if every and edit.array == "enableflags"]
    return (*flags, *([AGAIN] if scaled else []), *scaled)


def mjcf_lines(path: Path, model: mujoco.MjModel, recipe: Recipe) -> str:
    """Return MJCF sections, for the end of a model's file, of all edits but edits of the compiled model.

    A default is pasted where it changes these closures alone; closures that have settings of their own, which stand
    before a default, are named with what to write there. The text is compiled to see which these are.

    Returns:
        An empty text for a file that is no MJCF.
    """
    options = " ".join(f'{edit.array}="{_attribute(edit)}"' for edit in recipe if not edit.rows and _in_mjcf(edit))
    option = f"<option {options}/>"
    closures = [edit for edit in recipe if edit.array.startswith("eq_")]
    if path.suffix.lower() != ".xml":
        return ""
    if not closures:
        return option
    attributes = " ".join(f'{edit.array.removeprefix("eq_")}="{_attribute(edit)}"' for edit in closures)
    default = f"<default><equality {attributes}/></default>"
    try:
        pasted = Document(path).compile_with([option, default])
    except (InvalidInput, ValueError):
        return ""
    rows = closures[0].rows
    others = [row for row in range(model.neq) if row not in rows]
    if not all(_same_rows(getattr(pasted, e.array), getattr(model, e.array), others) for e in closures):
        return f"{option}\n{_own_words(model, rows, attributes)}"
    own = [row for row in rows if any(tuple(getattr(pasted, e.array)[row]) != e.value for e in closures)]
    if len(own) == len(rows):
        return f"{option}\n{_own_words(model, own, attributes)}"
    return "\n".join([option, default, *([_own_words(model, own, attributes)] if own else [])])


def _same_rows(one: np.typing.NDArray[np.float64], other: np.typing.NDArray[np.float64], rows: Sequence[int]) -> bool:
    """True if two arrays agree in some rows."""
    return bool(np.array_equal(one[list(rows)], other[list(rows)]))


def _own_words(model: mujoco.MjModel, rows: Sequence[int], attributes: str) -> str:
    """Name the equalities whose attributes are written into their own elements."""
    names = ", ".join(name_or_number(model, "equality", row) for row in rows)
    return f"<!-- in <equality>, into {names.replace('--', '- -')}: {attributes} -->"


def _in_mjcf(edit: Edit) -> bool:
    return edit.array != "enableflags"


def _attribute(edit: Edit) -> str:
    """The value of an edit as text of MJCF."""
    if isinstance(edit.value, tuple):
        return " ".join(f"{value:.{PASTED_DIGITS}g}" for value in edit.value)
    if edit.array in ("integrator", "solver"):
        short = edit.value.name.split("_")[-1]
        return next(name for name in (*INTEGRATORS, *SOLVERS) if name.upper() == short)
    return f"{edit.value:.{PASTED_DIGITS}g}" if isinstance(edit.value, float) else f"{edit.value}"
