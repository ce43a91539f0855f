"""The grid of MuJoCo settings that a sweep varies. Imports no engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from itertools import product
from typing import Any

from conrod.engines.engine import Machine, as_preset, step_length
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT
from conrod.engines.mujoco.settings import PRESETS, STIFF_SOLIMP, STOCK_SOLIMP, STOCK_SOLREF, MuJoCoSettings
from conrod.engines.rule import Grid, Rule, texts_of

# Where a time constant stands: in seconds, in steps, or in shares of the period.
STOCK_CONSTANT = "0.02 s"
STEP_CONSTANTS = {"2 h": 2.0, "4 h": 4.0, "8 h": 8.0}
PERIOD_CONSTANTS = {"T/1000": 1e-3, "T/100": 1e-2, "T/30": 1.0 / 30.0, "T/10": 0.1, "T/3": 1.0 / 3.0}
# Impedances at no violation and at a large one, and the width in between.
CONTACT_IMPEDANCES = {
    "0.9 to 0.95": STOCK_SOLIMP,
    "0.9": (0.9, 0.9, 0.001, 0.5, 2.0),
    "0.99": (0.99, 0.99, 0.001, 0.5, 2.0),
}
STOCK_TOLERANCE = 1e-8


def time_constant(text: str, machine: Machine, steps_per_revolution: int) -> float:
    """Time constant [s] of a stabilisation such as '2 h' or 'T/10'."""
    if text in STEP_CONSTANTS:
        return STEP_CONSTANTS[text] * step_length(machine, steps_per_revolution)
    if text in PERIOD_CONSTANTS:
        return PERIOD_CONSTANTS[text] * step_length(machine, 1)
    return STOCK_SOLREF[0]


@dataclass(frozen=True)
class LoopKnobs:
    """Knobs of a machine whose loops are closed by joints."""

    integrator: str = "Euler"
    stabilisation: str = STOCK_CONSTANT  # time constant of the closure (solref)
    regularisation: str = "stock"  # impedance (solimp): stock, stiff; or hardened by a factor
    solver: str = "Newton"
    iterations: int = 100
    tolerance: float = 0.0
    rod: str = BODY


@dataclass(frozen=True)
class ContactKnobs:
    """Knobs of a machine with a cam that its follower is kept on by contact."""

    integrator: str = "Euler"
    stabilisation: str = "2 h"  # time constant of the contact
    impedance: str = "0.9"
    vertices: int = 4000
    solver: str = "Newton"
    iterations: int = 100
    tolerance: float = 0.0


Knobs = LoopKnobs | ContactKnobs


def rules(machine: Machine, grid: Grid) -> tuple[Rule, ...]:
    """All rules of a grid, without repetition."""
    knobs = _contact_grid(grid) if machine.kinematics.mechanism.cam_contacts else _loop_grid(grid)
    return tuple(
        Rule(_name(one), one.stabilisation in STEP_CONSTANTS, texts_of(one), partial(_settings, one))
        for one in dict.fromkeys(knobs)
    )


def _settings(knobs: Knobs, machine: Machine, steps_per_revolution: int) -> MuJoCoSettings:
    """Settings whose armature and all that is not a knob are those of the stock preset."""
    constant = (time_constant(knobs.stabilisation, machine, steps_per_revolution), 1.0)
    own: dict[str, Any]
    match knobs:
        case LoopKnobs():
            hardened = knobs.regularisation.startswith("hardened")
            own = {
                "solref": constant,
                "solimp": STOCK_SOLIMP if knobs.regularisation == "stock" else STIFF_SOLIMP,
                "hardening": float(knobs.regularisation.split()[1]) if hardened else None,
                "rod": knobs.rod,
            }
            unused = ("contact_solref", "contact_solimp")
        case ContactKnobs():
            own = {
                "contact_solref": constant,
                "contact_solimp": CONTACT_IMPEDANCES[knobs.impedance],
                "cam_vertices": knobs.vertices,
            }
            unused = ("solref", "solimp")
    made = replace(
        MuJoCoSettings.stock(machine, steps_per_revolution),
        preset="custom",
        integrator=knobs.integrator,
        solver=knobs.solver,
        iterations=knobs.iterations,
        tolerance=knobs.tolerance,
        **own,
    )
    return as_preset(made, PRESETS, machine, unused)


def _name(knobs: Knobs) -> str:
    """What the first three knobs are, and those others that are not where they usually are."""
    soft = _regularisation(knobs.regularisation) if isinstance(knobs, LoopKnobs) else f"impedance {knobs.impedance}"
    words = {
        "vertices": "{} vertices",
        "solver": "{}",
        "iterations": "{} iterations",
        "tolerance": "tolerance {:g}",
        "rod": "rod as {}",
    }
    usual = {field.name: field.default for field in fields(knobs)}
    said = [words[n].format(v) for n, v in vars(knobs).items() if n in words and v != usual[n]]
    return ", ".join([f"{knobs.integrator}, solref {knobs.stabilisation}, {soft}", *said])


# The presets: what the finer knobs are turned on.
STOCK = LoopKnobs()
TUNED = LoopKnobs("RK4", "8 h", "stiff")
HARDENED = LoopKnobs("RK4", "T/10", "hardened 1e-9")
IMPLICIT_FAST = LoopKnobs("implicitfast", "2 h", "stiff")


def _loop_grid(grid: Grid) -> Sequence[Knobs]:
    bases = (STOCK, IMPLICIT_FAST, TUNED, HARDENED)
    if grid == "coarse":
        return bases
    fine = grid == "fine"
    integrators = ("Euler", "implicitfast", "RK4")
    constants = [STOCK_CONSTANT, "2 h", "8 h", "T/100", "T/10", *(("4 h", "T/1000", "T/30", "T/3") if fine else ())]
    regularisations = [
        "stock",
        "stiff",
        "hardened 1e-9",
        *(("hardened 1e-3", "hardened 1e-6", "hardened 1e-12") if fine else ()),
    ]
    found = [*bases]
    found += [LoopKnobs(*knobs) for knobs in product(integrators, constants, regularisations)]
    counts = {"PGS": (10, 100), "CG": (10, 100), "Newton": (1, 3)}
    for base in bases:
        found += [replace(base, solver=s, iterations=k) for s, many in counts.items() for k in many]
        found += [replace(base, tolerance=STOCK_TOLERANCE), replace(base, rod=DISTANCE_JOINT)]
    for base in (IMPLICIT_FAST, HARDENED):
        found += [replace(base, integrator=i) for i in ("implicit", "discrete")]
    found += [replace(HARDENED, regularisation=f"hardened {factor}") for factor in ("1e-3", "1e-6", "1e-12")]
    return found


def _contact_grid(grid: Grid) -> Sequence[Knobs]:
    stock, tuned = ContactKnobs(stabilisation=STOCK_CONSTANT, impedance="0.9 to 0.95"), ContactKnobs()
    # A contact costs by the vertices of its cam, a step of few of them a third.
    presets = [stock, tuned, *(replace(tuned, vertices=n) for n in (250, 1000))]
    if grid == "coarse":
        return presets
    constants = (STOCK_CONSTANT, "2 h", "4 h", "T/1000") + (("8 h", "T/100") if grid == "fine" else ())
    found = [ContactKnobs(*knobs) for knobs in product(("Euler", "implicitfast", "RK4"), constants, CONTACT_IMPEDANCES)]
    found += [replace(tuned, solver=s, iterations=k) for s, k in (("PGS", 10), ("CG", 10), ("Newton", 1))]
    return [*presets, *found, replace(tuned, tolerance=STOCK_TOLERANCE)]


def _regularisation(text: str) -> str:
    return {"stock": "solimp stock", "stiff": "solimp 0.9999"}.get(text, text)
