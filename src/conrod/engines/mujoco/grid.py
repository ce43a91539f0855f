"""Settings of MuJoCo that studies vary: the grid of a sweep, and one thing at a time. Imports no engine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import product
from typing import Any, TypeAlias

from conrod.engines.engine import Machine, as_preset, step_length, with_fields
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT
from conrod.engines.mujoco.settings import (
    LEAST_STEPS,
    PRESETS,
    STIFF_SOLIMP,
    STOCK_SOLIMP,
    STOCK_SOLREF,
    STOCK_TOLERANCE,
    MuJoCoSettings,
)
from conrod.engines.variants import Grid, Rule

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

Knobs: TypeAlias = Mapping[str, Any]
SOLVER: Knobs = {"solver": "Newton", "iterations": 100, "tolerance": 0.0}
# Knobs of a machine whose loops are closed by joints, and of one with a cam, where they usually stand. Stabilisation is
# the time constant of what holds, regularisation the impedance: stock, stiff; or hardened by a factor.
LOOP: Knobs = {"integrator": "Euler", "stabilisation": STOCK_CONSTANT, "regularisation": "stock", **SOLVER, "rod": BODY}
CONTACT: Knobs = {"integrator": "Euler", "stabilisation": "2 h", "impedance": "0.9", "vertices": 4000, **SOLVER}


def rules(machine: Machine, grid: Grid) -> tuple[Rule, ...]:
    """All rules of a grid, without repetition."""
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    usual, turned = (CONTACT, _contact_grid(grid)) if contact else (LOOP, _loop_grid(grid))
    found = {tuple(knobs.items()): knobs for knobs in ({**usual, **some} for some in turned)}
    return tuple(Rule(_name(one, usual), partial(_settings, one)) for one in found.values())


def time_constant(text: str, machine: Machine, steps_per_revolution: int) -> float:
    """Time constant [s] of a stabilisation such as '2 h' or 'T/10'."""
    if text in STEP_CONSTANTS:
        return STEP_CONSTANTS[text] * step_length(machine, steps_per_revolution)
    if text in PERIOD_CONSTANTS:
        return PERIOD_CONSTANTS[text] * step_length(machine, 1)
    return STOCK_SOLREF[0]


def _settings(knobs: Knobs, machine: Machine, steps_per_revolution: int) -> MuJoCoSettings:
    """Settings whose armature and all that is not a knob are those of the stock preset."""
    solref = (time_constant(knobs["stabilisation"], machine, steps_per_revolution), 1.0)
    own, unused = {name: knobs[name] for name in ("integrator", *SOLVER)}, ("contact_solref", "contact_solimp")
    if "impedance" in knobs:
        own |= {"contact_solref": solref, "contact_solimp": CONTACT_IMPEDANCES[knobs["impedance"]]}
        own["cam_vertices"], unused = knobs["vertices"], ("solref", "solimp")
    else:
        kind, *factor = knobs["regularisation"].split()
        own |= {"solref": solref, "solimp": STOCK_SOLIMP if kind == "stock" else STIFF_SOLIMP, "rod": knobs["rod"]}
        own["hardening"] = float(factor[0]) if factor else None
    stock = MuJoCoSettings.stock(machine, steps_per_revolution)
    return as_preset(with_fields(stock, **own), PRESETS, machine, unused)


WORDS = {
    "vertices": "{} vertices",
    "solver": "{}",
    "iterations": "{} iterations",
    "tolerance": "tolerance {:g}",
    "rod": "rod as {}",
}


def _name(knobs: Knobs, usual: Knobs) -> str:
    """What the first three knobs are, and those others that are not where they usually are."""
    regularisation: str = knobs.get("regularisation", "")
    soft = {"stock": "solimp stock", "stiff": "solimp 0.9999", "": f"impedance {knobs.get('impedance')}"}
    said = [WORDS[name].format(value) for name, value in knobs.items() if name in WORDS and value != usual[name]]
    first = (knobs["integrator"], f"solref {knobs['stabilisation']}", soft.get(regularisation, regularisation))
    return ", ".join([*first, *said])


# The presets, and what the finer knobs are turned on.
SOFTNESS = ("integrator", "stabilisation", "regularisation")
STOCK, TUNED, HARDENED, IMPLICIT_FAST = (
    dict(zip(SOFTNESS, knobs, strict=True))
    for knobs in (
        ("Euler", STOCK_CONSTANT, "stock"),
        ("RK4", "8 h", "stiff"),
        ("RK4", "T/10", "hardened 1e-9"),
        ("implicitfast", "2 h", "stiff"),
    )
)


def _loop_grid(grid: Grid) -> Sequence[Knobs]:
    bases = (STOCK, IMPLICIT_FAST, TUNED, HARDENED)
    if grid == "coarse":
        return bases
    integrators = ("Euler", "implicitfast", "RK4")
    constants: list[str] = [STOCK_CONSTANT, "2 h", "8 h", "T/100", "T/10"]
    hardened = ["hardened 1e-3", "hardened 1e-6", "hardened 1e-12"]
    every = product(integrators, constants, ["stock", "stiff", "hardened 1e-9"])
    found: list[Knobs] = [*bases, *(dict(zip(SOFTNESS, knobs, strict=True)) for knobs in every)]
    counts = {"PGS": (10, 100), "CG": (10, 100), "Newton": (1, 3)}
    for base in bases:
        found += [{**base, "solver": s, "iterations": k} for s, many in counts.items() for k in many]
        found += [{**base, "tolerance": STOCK_TOLERANCE}, {**base, "rod": DISTANCE_JOINT}]
    for base in (IMPLICIT_FAST, HARDENED):
        found += [{**base, "integrator": i} for i in ("implicit", "discrete")]
    return [*found, *({**HARDENED, "regularisation": factor} for factor in hardened)]


def _contact_grid(grid: Grid) -> Sequence[Knobs]:
    # A contact costs by the vertices of its cam, a step of few of them a third.
    presets: list[Knobs] = [
        {"stabilisation": STOCK_CONSTANT, "impedance": "0.9 to 0.95"},
        {},
        {"vertices": 250},
        {"vertices": 1000},
    ]
    if grid == "coarse":
        return presets
    constants = (STOCK_CONSTANT, "2 h", "4 h", "T/1000")
    every = product(("Euler", "implicitfast", "RK4"), constants, CONTACT_IMPEDANCES)
    found = [dict(zip(("integrator", "stabilisation", "impedance"), knobs, strict=True)) for knobs in every]
    solvers: list[Knobs] = [{"solver": s, "iterations": k} for s, k in (("PGS", 10), ("CG", 10), ("Newton", 1))]
    return [*presets, *found, *solvers, {"tolerance": STOCK_TOLERANCE}]


# -- one thing at a time -----------------------------------------------------------------------------------------------


def stabilised(machine: Machine, settings: MuJoCoSettings, steps: float) -> MuJoCoSettings:
    """The damping ratio stays. Below two steps MuJoCo's guard (refsafe) would raise the time constant."""
    field = "contact_solref" if machine.kinematics.mechanism.cam_contacts else "solref"
    solref = (steps * settings.timestep, getattr(settings, field)[1])
    return with_fields(settings, refsafe=settings.refsafe and steps >= LEAST_STEPS, **{field: solref})


def regularised(machine: Machine, settings: MuJoCoSettings, share: float) -> MuJoCoSettings:
    """Loops by hardening; contacts, which it is not for, by an impedance that does not change with the overlap."""
    if machine.kinematics.mechanism.cam_contacts:
        impedance = (1.0 - share, 1.0 - share, *settings.contact_solimp[2:])
        return with_fields(settings, contact_solimp=impedance)
    return with_fields(settings, hardening=share)
