"""MuJoCo settings that studies vary: a sweep's grid, single parameters, ingredients. Does not import the engine."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, TypeAlias

from conrod.engines.engine import Machine, recognise_preset, step_length, with_fields
from conrod.engines.mujoco import (
    CONTACT_SOLIMP,
    MIN_TIME_CONSTANT_STEPS,
    MUJOCO_PRESETS,
    STIFF_SOLIMP,
    STOCK_ITERATIONS,
    STOCK_SOLIMP,
    STOCK_SOLREF,
    STOCK_TOLERANCE,
    MuJoCoSettings,
)
from conrod.engines.mujoco.model_edits import (
    LINE_SEARCH_EVALUATIONS,
    NOSLIP_ITERATIONS,
    PASSIVE_ARMATURE,
    PASSIVE_DAMPING,
    edit_refusal,
)
from conrod.engines.variants import (
    NO_GRAVITY,
    Grid,
    Ingredient,
    Knobs,
    Quantity,
    SettingsRule,
    field_ingredient,
    knob_combinations,
    knob_rules,
    model_edit_ingredient,
)

# Names of time constants: in seconds, in steps, or in fractions of the period.
STOCK_CONSTANT = "0.02 s"
STEP_CONSTANTS = {"2 h": 2.0, "4 h": 4.0, "8 h": 8.0}
PERIOD_CONSTANTS = {"T/1000": 1e-3, "T/100": 1e-2, "T/10": 0.1}
# Impedance without violation and at a large one, width and shape of the transition between them.
CONTACT_IMPEDANCES = {
    "0.9 to 0.95": STOCK_SOLIMP,
    "0.9": CONTACT_SOLIMP,
    "0.99": (0.99, 0.99, 0.001, 0.5, 2.0),
}

SOLVER_KNOBS: Knobs = {"solver": "Newton", "iterations": 100, "tolerance": 0.0}
# Usual values of the knobs of a machine whose loops are closed by joints, and of one with a cam. Stabilisation is the
# time constant of closures or contact; regularisation is the impedance, stock or stiff, or a hardening factor.
LOOP_KNOBS: Knobs = {"integrator": "Euler", "stabilisation": STOCK_CONSTANT, "regularisation": "stock", **SOLVER_KNOBS}
CONTACT_KNOBS: Knobs = {
    "integrator": "Euler",
    "stabilisation": "2 h",
    "impedance": "0.9",
    "vertices": 4000,
    **SOLVER_KNOBS,
}

# Values that differ from the usual ones in the presets, and in settings as good as a preset.
IMPLICIT_FAST_KNOBS: Knobs = {"integrator": "implicitfast", "stabilisation": "2 h", "regularisation": "stiff"}
HARDENED_KNOBS: Knobs = {"integrator": "RK4", "stabilisation": "T/10", "regularisation": "hardened 1e-9"}
LOOP_BASES: tuple[Knobs, ...] = (
    {},
    IMPLICIT_FAST_KNOBS,
    {"integrator": "RK4", "stabilisation": "8 h", "regularisation": "stiff"},
    HARDENED_KNOBS,
)


def loop_grid() -> Iterator[Knobs]:
    """Knobs that a full sweep adds to the presets, for a machine whose loops are closed by joints."""
    yield from knob_combinations(
        integrator=("Euler", "implicitfast", "RK4"),
        stabilisation=(STOCK_CONSTANT, "2 h", "8 h", "T/100", "T/10"),
        regularisation=("stock", "stiff", "hardened 1e-9"),
    )
    solvers: list[Knobs] = [{"solver": s, "iterations": k} for s in ("PGS", "CG") for k in (10, 100)]
    solvers += [{"solver": "Newton", "iterations": k} for k in (1, 3)]
    yield from ({**base, **one} for base in LOOP_BASES for one in (*solvers, {"tolerance": STOCK_TOLERANCE}))
    yield from (
        {**base, "integrator": other}
        for base in (IMPLICIT_FAST_KNOBS, HARDENED_KNOBS)
        for other in ("implicit", "discrete")
    )
    yield from ({**HARDENED_KNOBS, "regularisation": f"hardened {factor}"} for factor in ("1e-3", "1e-6", "1e-12"))


# The cost of contact grows with the vertices of its cam: with few of them a step takes a third of the time.
CONTACT_BASES: tuple[Knobs, ...] = (
    {"stabilisation": STOCK_CONSTANT, "impedance": "0.9 to 0.95"},
    {},
    {"vertices": 250},
    {"vertices": 1000},
)


def contact_grid() -> Iterator[Knobs]:
    """Knobs that a full sweep adds to the presets, for a machine with a cam."""
    yield from knob_combinations(
        integrator=("Euler", "implicitfast", "RK4"),
        stabilisation=(STOCK_CONSTANT, "2 h", "4 h", "T/1000"),
        impedance=CONTACT_IMPEDANCES,
    )
    yield from ({"solver": s, "iterations": k} for s, k in (("PGS", 10), ("CG", 10), ("Newton", 1)))
    yield {"tolerance": STOCK_TOLERANCE}


def rules(machine: Machine, grid: Grid) -> tuple[SettingsRule, ...]:
    """All rules of a grid for a machine, without duplicates."""
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    usual, bases, others = (
        (CONTACT_KNOBS, CONTACT_BASES, contact_grid) if contact else (LOOP_KNOBS, LOOP_BASES, loop_grid)
    )
    return knob_rules(usual, bases if grid == "coarse" else (*bases, *others()), _rule_name, _settings_from_knobs)


def _settings_from_knobs(knobs: Knobs, machine: Machine, steps_per_revolution: int) -> MuJoCoSettings:
    """Settings of given knobs, with the armature and all other fields of the stock preset."""
    stock, text = MuJoCoSettings.stock(machine, steps_per_revolution), knobs["stabilisation"]
    constant = STOCK_SOLREF[0]
    if text in STEP_CONSTANTS:
        constant = STEP_CONSTANTS[text] * step_length(machine, steps_per_revolution)
    elif text in PERIOD_CONSTANTS:
        constant = PERIOD_CONSTANTS[text] * step_length(machine, 1)
    own = {name: knobs[name] for name in ("integrator", *SOLVER_KNOBS)}
    if "impedance" in knobs:
        unused = "solref", "solimp"
        own |= {"contact_solref": (constant, 1.0), "contact_solimp": CONTACT_IMPEDANCES[knobs["impedance"]]}
        own["cam_vertices"] = knobs["vertices"]
    else:
        unused = "contact_solref", "contact_solimp"
        kind, *factor = knobs["regularisation"].split()
        own |= {"solref": (constant, 1.0), "solimp": STOCK_SOLIMP if kind == "stock" else STIFF_SOLIMP}
        own["hardening"] = float(factor[0]) if factor else None
    return recognise_preset(with_fields(stock, **own), MUJOCO_PRESETS, machine, unused)


KNOB_TEXTS = {"vertices": "{} vertices", "solver": "{}", "iterations": "{} iterations", "tolerance": "tolerance {:g}"}


def _rule_name(knobs: Knobs, usual: Knobs) -> str:
    """Name a rule by its first three knobs, and by others that are not at their usual values."""
    regularisation: str = knobs.get("regularisation", "")
    soft = {"stock": "solimp stock", "stiff": "solimp 0.9999", "": f"impedance {knobs.get('impedance')}"}
    said = [
        KNOB_TEXTS[name].format(value) for name, value in knobs.items() if name in KNOB_TEXTS and value != usual[name]
    ]
    first = (knobs["integrator"], f"solref {knobs['stabilisation']}", soft.get(regularisation, regularisation))
    return ", ".join([*first, *said])


# -- one thing at a time -----------------------------------------------------------------------------------------------


def with_time_constant(machine: Machine, settings: MuJoCoSettings, steps: float) -> MuJoCoSettings:
    """Set the time constant of loops or contact to a number of steps; the damping ratio stays.

    Below two steps MuJoCo's guard `refsafe`, which would raise the time constant, is switched off.
    """
    field = "contact_solref" if machine.kinematics.mechanism.cam_contacts else "solref"
    solref = (steps * settings.timestep, getattr(settings, field)[1])
    return with_fields(settings, refsafe=settings.refsafe and steps >= MIN_TIME_CONSTANT_STEPS, **{field: solref})


def with_regularisation(machine: Machine, settings: MuJoCoSettings, share: float) -> MuJoCoSettings:
    """Set the share of regularisation that is left: loops by hardening, contacts by a constant impedance."""
    if machine.kinematics.mechanism.cam_contacts:
        impedance = (1.0 - share, 1.0 - share, *settings.contact_solimp[2:])
        return with_fields(settings, contact_solimp=impedance)
    return with_fields(settings, hardening=share)


# -- ingredients of the minimal model ----------------------------------------------------------------------------------


TORQUE, REACTIONS, IMPACT, WEAR = Quantity.DRIVE_TORQUE, Quantity.REACTIONS, Quantity.IMPACT, Quantity.WEAR
FINE_CAM_FACTOR = 4  # on the vertices of the minimal model's cam

Ingredients: TypeAlias = tuple[Ingredient[MuJoCoSettings], ...]


def minimal_settings(machine: Machine, steps_per_revolution: int) -> MuJoCoSettings:
    """The cheapest settings with the right observed motion.

    The best preset without what the motion does not need: no gravity, one iteration of Newton's method and a short line
    search, which are exact as long as the set of active constraints stays, and none of MuJoCo's defaults for models of
    many bodies and shapes.
    """
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    preset = MuJoCoSettings.tuned if contact else MuJoCoSettings.hardened
    return replace(
        preset(machine, steps_per_revolution),
        preset="custom",
        gravity=False,
        iterations=1,
        dressing=("no-islands", "no-multiccd", "short-line-search"),
    )


def ingredients(machine: Machine, minimal: MuJoCoSettings) -> Ingredients:
    """Return the ingredients to add to a machine's minimal model, then those to remove."""
    mechanism = machine.kinematics.mechanism
    contact = bool(mechanism.cam_contacts)
    found = (*_optional_ingredients(minimal, contact, any(mechanism.gravity)), *_minimal_ingredients(minimal, contact))

    def refusal(one: Ingredient[MuJoCoSettings]) -> str:
        # An optional ingredient must apply when added; one of the minimal model, when removed.
        refused = edit_refusal(mechanism, (one.removed if one.minimal else one.added)(minimal)) or ""
        return one.refusal or refused.partition(": ")[2]

    return tuple(replace(one, refusal=refusal(one)) for one in found)


def _optional_ingredients(minimal: MuJoCoSettings, contact: bool, heavy: bool) -> Iterator[Ingredient[MuJoCoSettings]]:
    """Optional ingredients: parts the model can contain, sensors, work the solver can do."""
    yield model_edit_ingredient("visual-geoms", "bars, pins and blocks to be seen, which cannot collide")
    overlap = "bars, pins and blocks able to collide, all in the plane of motion: links overlap where pins join them"
    yield model_edit_ingredient("touching-geoms", overlap, IMPACT)
    layers = "the same shapes able to collide, each link in a layer of its own: looked at in each step, never touching"
    yield model_edit_ingredient("colliding-geoms", layers, IMPACT)
    weight, no_weight = "the weight of all links", "" if heavy else NO_GRAVITY
    yield field_ingredient(minimal, "gravity", weight, TORQUE, REACTIONS, WEAR, refusal=no_weight, gravity=True)
    damping = f"{PASSIVE_DAMPING:g} N m s/rad on every hinge, {PASSIVE_DAMPING:g} N s/m on every slide, but the crank"
    yield model_edit_ingredient("passive-damping", damping, TORQUE, REACTIONS)
    armature = f"{PASSIVE_ARMATURE:g} kg m² on every hinge, {PASSIVE_ARMATURE:g} kg on every slide, but the crank"
    yield model_edit_ingredient("passive-armature", armature, TORQUE, REACTIONS)
    free = (
        "every link that hangs on a pin has six degrees of freedom, and every pin but the crank's is held by three "
        "connects along its axis, as where each link is translated by itself; slides stay joints, for which MuJoCo has "
        "no equality"
    )
    yield model_edit_ingredient("free-bodies", free, REACTIONS, WEAR)
    yield model_edit_ingredient("redundant-closures", "every connect a second time")
    yield model_edit_ingredient(
        "condim-3", "sliding friction of the roller on the cam, with MuJoCo's coefficients", TORQUE, REACTIONS, WEAR
    )
    yield model_edit_ingredient("sensors-64", "of the motion of the observed points, read by nobody")
    yield model_edit_ingredient("energy", "potential and kinetic energy are computed in each step")
    yield model_edit_ingredient("fwdinv", "each step is checked against the inverse dynamics")
    iterations = "iterations of the solver, MuJoCo's default, of which it takes what it likes"
    yield field_ingredient(minimal, "iterations-100", iterations, iterations=STOCK_ITERATIONS)
    search = (
        "MuJoCo's default: up to 50 evaluations along a direction of the solver instead of "
        f"{LINE_SEARCH_EVALUATIONS}; a tolerance of 0 takes them all"
    )
    yield model_edit_ingredient("line-search", search, absence="short-line-search")
    yield model_edit_ingredient("sparse-jacobian", "constraints kept for large models")
    islands = "MuJoCo's default in 4.0: groups of bodies that constraints join are found in each step and solved apart"
    yield model_edit_ingredient("islands", islands, absence="no-islands")
    passes = (
        f"{NOSLIP_ITERATIONS} passes of the solver that mends friction; it computes all accelerations anew from the "
        "forces, of which hard closures have lost digits"
    )
    yield model_edit_ingredient("noslip", passes, WEAR)
    several = "MuJoCo's default in 4.0: several contact points for each pair of flat shapes"
    yield model_edit_ingredient("multiccd", several, absence="no-multiccd")
    if contact:
        yield field_ingredient(minimal, "rk4", "four evaluations a step instead of one", integrator="RK4")
        vertices = FINE_CAM_FACTOR * minimal.cam_vertices
        meaning = f"a cam of {vertices} vertices instead of {minimal.cam_vertices}"
        yield field_ingredient(minimal, "fine-cam", meaning, IMPACT, WEAR, cam_vertices=vertices)


def _minimal_ingredients(minimal: MuJoCoSettings, contact: bool) -> Iterator[Ingredient[MuJoCoSettings]]:
    """Ingredients of the minimal model: closure, what makes it exact, drive, solver."""
    if contact:
        pair = "the pair of cam and roller; without it the roller falls through"
        yield model_edit_ingredient("contact", pair, TORQUE, REACTIONS, minimal=True, absence="no-contact")
        stiff = "a time constant of two steps and an impedance of 0.9; without it MuJoCo's defaults"
        soft: dict[str, Any] = {"contact_solref": STOCK_SOLREF, "contact_solimp": STOCK_SOLIMP}
        yield field_ingredient(minimal, "stiff-contact", stiff, IMPACT, **soft, minimal=True)
    else:
        connects = "a connect for each loop; without it the links swing freely"
        yield model_edit_ingredient("closure", connects, TORQUE, REACTIONS, minimal=True, absence="open-loops")
        hard = "the regularisation of constraints taken away after compiling; without it, as MJCF can say it"
        yield field_ingredient(minimal, "hardening", hard, TORQUE, REACTIONS, hardening=None, minimal=True)
        slow = f"a time constant of a tenth of the period; without it MuJoCo's default, {STOCK_SOLREF[0]:g} s"
        yield field_ingredient(minimal, "slow-closure", slow, solref=STOCK_SOLREF, minimal=True)
        yield field_ingredient(
            minimal, "rk4", "four evaluations a step; without it Euler", integrator="Euler", minimal=True
        )
    armature = "an armature that keeps the crank at its speed; without it the crank is only set in motion"
    yield field_ingredient(minimal, "flywheel", armature, TORQUE, armature=0.0, minimal=True)
    yield field_ingredient(
        minimal, "iteration", "one iteration of Newton's method; without it none", iterations=0, minimal=True
    )
    tolerance = (
        f"a tolerance of 0 of the solver; without it MuJoCo's default, {STOCK_TOLERANCE:g}, scaled by a mean inertia "
        "that has the flywheel in it"
    )
    yield field_ingredient(minimal, "tolerance-0", tolerance, tolerance=STOCK_TOLERANCE, minimal=True)
