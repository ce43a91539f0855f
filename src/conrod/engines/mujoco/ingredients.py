"""The minimal MuJoCo model, its optional and required ingredients. Imports no engine."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

from conrod.engines.engine import Machine
from conrod.engines.ingredients import Ingredient, Ingredients, Quantity
from conrod.engines.mujoco.model_edits import (
    LINE_SEARCH,
    NOSLIP_ITERATIONS,
    PASSIVE_ARMATURE,
    PASSIVE_DAMPING,
    edit_refusal,
)
from conrod.engines.mujoco.settings import STOCK_SOLIMP, STOCK_SOLREF, MuJoCoSettings

TORQUE, REACTIONS, IMPACT, WEAR = Quantity.DRIVE_TORQUE, Quantity.REACTIONS, Quantity.IMPACT, Quantity.WEAR
DEFAULT_ITERATIONS, DEFAULT_TOLERANCE = 100, 1e-8
FINER = 4  # times the vertices of the minimal model's cam
GUARDED_STEPS = 2.0  # MuJoCo raises a time constant below so many steps to them
FRICTIONS = {3: "sliding", 4: "sliding and spinning", 6: "sliding, spinning, rolling"}

Found: TypeAlias = tuple[Ingredient[MuJoCoSettings], ...]


def minimal(machine: Machine, steps_per_revolution: int) -> MuJoCoSettings:
    """The cheapest settings that have the observed motion right.

    Those of the best preset without what the motion does not need: no gravity, a single iteration of Newton's method
    and a short line search, which are exact as long as the set of acting constraints stays, and none of what MuJoCo
    does unasked for models of many bodies and shapes.
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


def ingredients(machine: Machine, minimal: MuJoCoSettings) -> Found:
    """Ingredients of the minimal model, optional ones first; only those that apply to the machine."""
    mechanism = machine.kinematics.mechanism
    contact, make = bool(mechanism.cam_contacts), Ingredients(minimal)
    found = (
        *_shapes(make),
        *(_weight(make) if any(mechanism.gravity) else ()),
        *_physics(make),
        *_read(make),
        *_solver(make),
        *(_of_a_cam(make) if contact else ()),
        *(_contact(make) if contact else _closure(make)),
        *_drive(make),
        *(_guard(make) if _is_guarded(minimal, contact) else ()),
    )
    # What is added is what must apply; of what the model consists of, it is what is missing then.
    return tuple(
        one for one in found if not edit_refusal(mechanism, (one.removed if one.minimal else one.added)(minimal))
    )


# -- optional ---------------------------------------------------------------------------------------------------------


def _shapes(make: Ingredients[MuJoCoSettings]) -> Found:
    return (
        make.edit("visual-geoms", "visual geoms", "bars, pins and blocks to be seen, which cannot collide"),
        make.edit(
            "touching-geoms",
            "colliding geoms in one plane",
            "the same shapes, all in the plane of motion and able to collide: links overlap where pins join them",
            IMPACT,
            group="collision",
        ),
        make.edit(
            "colliding-geoms",
            "colliding geoms in layers",
            "the same shapes able to collide, each link in a layer of its own: looked at in each step, never touching",
            IMPACT,
            group="collision",
        ),
    )


def _weight(make: Ingredients[MuJoCoSettings]) -> Found:
    return (make.fields("gravity", "gravity", "the weight of all links", TORQUE, REACTIONS, WEAR, gravity=True),)


def _physics(make: Ingredients[MuJoCoSettings]) -> Found:
    damping, armature = f"{PASSIVE_DAMPING:g}", f"{PASSIVE_ARMATURE:g}"
    return (
        make.edit(
            "passive-damping",
            "damping of passive joints",
            f"{damping} N m s/rad on every hinge, {damping} N s/m on every slide, but the crank",
            TORQUE,
            REACTIONS,
        ),
        make.edit(
            "passive-armature",
            "armature of passive joints",
            f"{armature} kg m^2 on every hinge, {armature} kg on every slide, but the crank",
            TORQUE,
            REACTIONS,
        ),
        make.edit(
            "free-bodies",
            "links as free bodies in space",
            "links that hang on a pin have six degrees of freedom, and every pin but the crank's is held by three "
            "connects along its axis; slides stay joints, for which MuJoCo has no equality",
            REACTIONS,
            WEAR,
        ),
        make.edit("redundant-closures", "redundant loop closures", "every connect a second time"),
        *(
            make.edit(
                f"condim-{dimension}",
                f"contact dimension {dimension}",
                f"friction of the roller on the cam: {friction}, with MuJoCo's coefficients",
                TORQUE,
                REACTIONS,
                WEAR,
                group="contact dimension",
            )
            for dimension, friction in FRICTIONS.items()
        ),
    )


def _read(make: Ingredients[MuJoCoSettings]) -> Found:
    unread = "told of the motion of the observed points, and read by nobody"
    return (
        make.edit("sensors-1", "1 sensor", unread, group="sensors"),
        make.edit("sensors-8", "8 sensors", unread, group="sensors"),
        make.edit("sensors-64", "64 sensors", unread, group="sensors"),
        make.edit("energy", "energy flag", "potential and kinetic energy are computed in each step"),
        make.edit("fwdinv", "fwdinv flag", "each step is checked against the inverse dynamics"),
    )


def _solver(make: Ingredients[MuJoCoSettings]) -> Found:
    return (
        make.fields(
            "iterations-100",
            "100 solver iterations",
            "MuJoCo's default, of which the solver takes what it likes",
            iterations=DEFAULT_ITERATIONS,
        ),
        make.default(
            "line-search",
            "a long line search",
            f"MuJoCo's default: up to 50 evaluations along a direction of the solver instead of {LINE_SEARCH}; a "
            "tolerance of 0 takes them all",
            absence="short-line-search",
        ),
        make.edit("sparse-jacobian", "sparse Jacobian", "constraints kept for large models"),
        make.default(
            "islands",
            "constraint islands",
            "MuJoCo's default in 4.0: groups of bodies that constraints join are found in each step and solved apart",
            absence="no-islands",
        ),
        make.edit(
            "noslip",
            "noslip iterations",
            f"{NOSLIP_ITERATIONS} passes of the solver that mends friction; it tells all accelerations anew from the "
            "forces, of which hard closures have lost digits",
            WEAR,
        ),
        make.default(
            "multiccd",
            "multiccd flag",
            "MuJoCo's default in 4.0: several contact points for each pair of flat shapes",
            absence="no-multiccd",
        ),
    )


def _of_a_cam(make: Ingredients[MuJoCoSettings]) -> Found:
    before, vertices = make.model.cam_vertices, FINER * make.model.cam_vertices
    title, meaning = f"a cam of {FINER} times the vertices", f"{vertices} vertices instead of {before}"
    return (
        make.fields("rk4", "RK4", "four evaluations a step instead of one", integrator="RK4"),
        make.fields("fine-cam", title, meaning, IMPACT, WEAR, cam_vertices=vertices),
    )


# -- required: each taken away alone; the closure first, then what makes it exact, the drive, the solver --------------


def _closure(make: Ingredients[MuJoCoSettings]) -> Found:
    return (
        make.needed_edit(
            "closure",
            "the loop closure",
            "a connect for each loop; without it the links swing freely",
            TORQUE,
            REACTIONS,
            absence="open-loops",
        ),
        make.needed_fields(
            "hardening",
            "hardening",
            "the regularisation of constraints taken away after compiling; without it, as MJCF can say it",
            TORQUE,
            REACTIONS,
            hardening=None,
        ),
        make.needed_fields(
            "slow-closure",
            "a slow closure",
            f"a time constant of a tenth of the period; without it MuJoCo's default, {STOCK_SOLREF[0]:g} s",
            solref=STOCK_SOLREF,
        ),
        make.needed_fields("rk4", "RK4", "four evaluations a step; without it Euler", integrator="Euler"),
    )


def _contact(make: Ingredients[MuJoCoSettings]) -> Found:
    return (
        make.needed_edit(
            "contact",
            "the contact",
            "the pair of cam and roller; without it the roller falls through",
            TORQUE,
            REACTIONS,
            absence="no-contact",
        ),
        make.needed_fields(
            "stiff-contact",
            "a stiff contact",
            "a time constant of two steps and an impedance of 0.9; without it MuJoCo's defaults",
            IMPACT,
            contact_solref=STOCK_SOLREF,
            contact_solimp=STOCK_SOLIMP,
        ),
    )


def _drive(make: Ingredients[MuJoCoSettings]) -> Found:
    return (
        make.needed_fields(
            "flywheel",
            "the armature of the drive",
            "a flywheel that keeps the crank at its speed; without it the crank is only set in motion",
            TORQUE,
            armature=0.0,
        ),
        make.needed_fields(
            "iteration",
            "an iteration of the solver",
            "one iteration of Newton's method; without it none",
            iterations=0,
        ),
        make.needed_fields(
            "tolerance-0",
            "a solver tolerance of 0",
            f"without it MuJoCo's default, {DEFAULT_TOLERANCE:g}, scaled by a mean inertia that has the flywheel in it",
            tolerance=DEFAULT_TOLERANCE,
        ),
    )


def _is_guarded(minimal: MuJoCoSettings, contact: bool) -> bool:
    return minimal.refsafe and 0.0 < minimal.time_constant(contact) < GUARDED_STEPS * minimal.timestep


def _guard(make: Ingredients[MuJoCoSettings]) -> Found:
    meaning = "time constants below two steps raised to them; without it as they are said"
    return (make.needed_fields("refsafe", "the guard of short time constants", meaning, refsafe=False),)
