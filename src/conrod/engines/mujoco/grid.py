"""Settings of MuJoCo that studies vary: the grid of a sweep, and one thing at a time. Imports no engine."""

from __future__ import annotations

from conrod.engines.engine import Machine, as_preset, step_length, with_fields
from conrod.engines.mujoco.settings import (
    CONTACT_SOLIMP,
    LEAST_STEPS,
    PRESETS,
    STIFF_SOLIMP,
    STOCK_SOLIMP,
    STOCK_SOLREF,
    STOCK_TOLERANCE,
    MuJoCoSettings,
)
from conrod.engines.variants import Grid, Knobs, Rule, all_of, knob_rules

# Where a time constant stands: in seconds, in steps, or in shares of the period.
STOCK_CONSTANT = "0.02 s"
STEP_CONSTANTS = {"2 h": 2.0, "4 h": 4.0, "8 h": 8.0}
PERIOD_CONSTANTS = {"T/1000": 1e-3, "T/100": 1e-2, "T/10": 0.1}
# Impedances at no violation and at a large one, and the width in between.
CONTACT_IMPEDANCES = {
    "0.9 to 0.95": STOCK_SOLIMP,
    "0.9": CONTACT_SOLIMP,
    "0.99": (0.99, 0.99, 0.001, 0.5, 2.0),
}

SOLVER: Knobs = {"solver": "Newton", "iterations": 100, "tolerance": 0.0}
# Knobs of a machine whose loops are closed by joints, and of one with a cam, where they usually stand. Stabilisation is
# the time constant of what holds, regularisation the impedance: stock, stiff; or hardened by a factor.
LOOP: Knobs = {"integrator": "Euler", "stabilisation": STOCK_CONSTANT, "regularisation": "stock", **SOLVER}
CONTACT: Knobs = {"integrator": "Euler", "stabilisation": "2 h", "impedance": "0.9", "vertices": 4000, **SOLVER}

# What is turned away from there: the presets, with what is as good as one, first.
IMPLICIT_FAST: Knobs = {"integrator": "implicitfast", "stabilisation": "2 h", "regularisation": "stiff"}
HARDENED: Knobs = {"integrator": "RK4", "stabilisation": "T/10", "regularisation": "hardened 1e-9"}
LOOP_BASES: tuple[Knobs, ...] = (
    {},
    IMPLICIT_FAST,
    {"integrator": "RK4", "stabilisation": "8 h", "regularisation": "stiff"},
    HARDENED,
)
SOLVERS: list[Knobs] = [{"solver": s, "iterations": k} for s in ("PGS", "CG") for k in (10, 100)]
SOLVERS += [{"solver": "Newton", "iterations": k} for k in (1, 3)]
LOOP_GRID: tuple[Knobs, ...] = (
    *all_of(
        integrator=("Euler", "implicitfast", "RK4"),
        stabilisation=(STOCK_CONSTANT, "2 h", "8 h", "T/100", "T/10"),
        regularisation=("stock", "stiff", "hardened 1e-9"),
    ),
    *({**base, **one} for base in LOOP_BASES for one in (*SOLVERS, {"tolerance": STOCK_TOLERANCE})),
    *({**base, "integrator": other} for base in (IMPLICIT_FAST, HARDENED) for other in ("implicit", "discrete")),
    *({**HARDENED, "regularisation": f"hardened {factor}"} for factor in ("1e-3", "1e-6", "1e-12")),
)
# A contact costs by the vertices of its cam, a step of few of them a third.
CONTACT_BASES: tuple[Knobs, ...] = (
    {"stabilisation": STOCK_CONSTANT, "impedance": "0.9 to 0.95"},
    {},
    {"vertices": 250},
    {"vertices": 1000},
)
CONTACT_GRID: tuple[Knobs, ...] = (
    *all_of(
        integrator=("Euler", "implicitfast", "RK4"),
        stabilisation=(STOCK_CONSTANT, "2 h", "4 h", "T/1000"),
        impedance=CONTACT_IMPEDANCES,
    ),
    *({"solver": s, "iterations": k} for s, k in (("PGS", 10), ("CG", 10), ("Newton", 1))),
    {"tolerance": STOCK_TOLERANCE},
)


def rules(machine: Machine, grid: Grid) -> tuple[Rule, ...]:
    """All rules of a grid, without repetition."""
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    usual, bases, others = (CONTACT, CONTACT_BASES, CONTACT_GRID) if contact else (LOOP, LOOP_BASES, LOOP_GRID)
    return knob_rules(usual, bases if grid == "coarse" else (*bases, *others), _name, _settings)


def _settings(knobs: Knobs, machine: Machine, steps_per_revolution: int) -> MuJoCoSettings:
    """Settings whose armature and all that is not a knob are those of the stock preset."""
    stock, text = MuJoCoSettings.stock(machine, steps_per_revolution), knobs["stabilisation"]
    constant = STOCK_SOLREF[0]
    if text in STEP_CONSTANTS:
        constant = STEP_CONSTANTS[text] * step_length(machine, steps_per_revolution)
    elif text in PERIOD_CONSTANTS:
        constant = PERIOD_CONSTANTS[text] * step_length(machine, 1)
    own = {name: knobs[name] for name in ("integrator", *SOLVER)}
    if "impedance" in knobs:
        unused = "solref", "solimp"
        own |= {"contact_solref": (constant, 1.0), "contact_solimp": CONTACT_IMPEDANCES[knobs["impedance"]]}
        own["cam_vertices"] = knobs["vertices"]
    else:
        unused = "contact_solref", "contact_solimp"
        kind, *factor = knobs["regularisation"].split()
        own |= {"solref": (constant, 1.0), "solimp": STOCK_SOLIMP if kind == "stock" else STIFF_SOLIMP}
        own["hardening"] = float(factor[0]) if factor else None
    return as_preset(with_fields(stock, **own), PRESETS, machine, unused)


WORDS = {"vertices": "{} vertices", "solver": "{}", "iterations": "{} iterations", "tolerance": "tolerance {:g}"}


def _name(knobs: Knobs, usual: Knobs) -> str:
    """What the first three knobs are, and those others that are not where they usually are."""
    regularisation: str = knobs.get("regularisation", "")
    soft = {"stock": "solimp stock", "stiff": "solimp 0.9999", "": f"impedance {knobs.get('impedance')}"}
    said = [WORDS[name].format(value) for name, value in knobs.items() if name in WORDS and value != usual[name]]
    first = (knobs["integrator"], f"solref {knobs['stabilisation']}", soft.get(regularisation, regularisation))
    return ", ".join([*first, *said])


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
