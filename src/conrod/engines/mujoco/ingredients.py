"""The minimal MuJoCo model, its optional and required ingredients. Imports no engine."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, TypeAlias

from conrod.engines.engine import Machine
from conrod.engines.mujoco.model_edits import (
    LINE_SEARCH,
    NOSLIP_ITERATIONS,
    PASSIVE_ARMATURE,
    PASSIVE_DAMPING,
    edit_refusal,
)
from conrod.engines.mujoco.settings import (
    STOCK_ITERATIONS,
    STOCK_SOLIMP,
    STOCK_SOLREF,
    STOCK_TOLERANCE,
    MuJoCoSettings,
)
from conrod.engines.variants import Ingredient, Quantity, edit, fields

TORQUE, REACTIONS, IMPACT, WEAR = Quantity.DRIVE_TORQUE, Quantity.REACTIONS, Quantity.IMPACT, Quantity.WEAR
FINER = 4  # times the vertices of the minimal model's cam

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
    contact = bool(mechanism.cam_contacts)
    found = (*_optional(minimal, contact, any(mechanism.gravity)), *_required(minimal, contact))
    # What is added is what must apply; of what the model consists of, it is what is missing then.
    return tuple(
        one for one in found if not edit_refusal(mechanism, (one.removed if one.minimal else one.added)(minimal))
    )


def _optional(minimal: MuJoCoSettings, contact: bool, heavy: bool) -> Iterator[Ingredient[MuJoCoSettings]]:
    """What the machine could carry, what could be read of it, and what the solver could do."""
    yield edit("visual-geoms", "bars, pins and blocks to be seen, which cannot collide")
    overlap = "bars, pins and blocks able to collide, all in the plane of motion: links overlap where pins join them"
    yield edit("touching-geoms", overlap, IMPACT)
    layers = "the same shapes able to collide, each link in a layer of its own: looked at in each step, never touching"
    yield edit("colliding-geoms", layers, IMPACT)
    if heavy:
        yield fields(minimal, "gravity", "the weight of all links", TORQUE, REACTIONS, WEAR, gravity=True)
    damping = f"{PASSIVE_DAMPING:g} N m s/rad on every hinge, {PASSIVE_DAMPING:g} N s/m on every slide, but the crank"
    yield edit("passive-damping", damping, TORQUE, REACTIONS)
    armature = f"{PASSIVE_ARMATURE:g} kg m² on every hinge, {PASSIVE_ARMATURE:g} kg on every slide, but the crank"
    yield edit("passive-armature", armature, TORQUE, REACTIONS)
    yield edit("redundant-closures", "every connect a second time")
    yield edit(
        "condim-3", "sliding friction of the roller on the cam, with MuJoCo's coefficients", TORQUE, REACTIONS, WEAR
    )
    yield edit("sensors-64", "of the motion of the observed points, read by nobody")
    yield edit("energy", "potential and kinetic energy are computed in each step")
    yield edit("fwdinv", "each step is checked against the inverse dynamics")
    iterations = "iterations of the solver, MuJoCo's default, of which it takes what it likes"
    yield fields(minimal, "iterations-100", iterations, iterations=STOCK_ITERATIONS)
    search = (
        f"MuJoCo's default: up to 50 evaluations along a direction of the solver instead of {LINE_SEARCH}; a tolerance "
        "of 0 takes them all"
    )
    yield edit("line-search", search, absence="short-line-search")
    yield edit("sparse-jacobian", "constraints kept for large models")
    islands = "MuJoCo's default in 4.0: groups of bodies that constraints join are found in each step and solved apart"
    yield edit("islands", islands, absence="no-islands")
    passes = (
        f"{NOSLIP_ITERATIONS} passes of the solver that mends friction; it computes all accelerations anew from the "
        "forces, of which hard closures have lost digits"
    )
    yield edit("noslip", passes, WEAR)
    several = "MuJoCo's default in 4.0: several contact points for each pair of flat shapes"
    yield edit("multiccd", several, absence="no-multiccd")
    if contact:
        yield fields(minimal, "rk4", "four evaluations a step instead of one", integrator="RK4")
        vertices = FINER * minimal.cam_vertices
        meaning = f"a cam of {vertices} vertices instead of {minimal.cam_vertices}"
        yield fields(minimal, "fine-cam", meaning, IMPACT, WEAR, cam_vertices=vertices)


def _required(minimal: MuJoCoSettings, contact: bool) -> Iterator[Ingredient[MuJoCoSettings]]:
    """What the minimal model consists of: the closure first, then what makes it exact, the drive, the solver."""
    if contact:
        pair = "the pair of cam and roller; without it the roller falls through"
        yield edit("contact", pair, TORQUE, REACTIONS, minimal=True, absence="no-contact")
        stiff = "a time constant of two steps and an impedance of 0.9; without it MuJoCo's defaults"
        soft: dict[str, Any] = {"contact_solref": STOCK_SOLREF, "contact_solimp": STOCK_SOLIMP}
        yield fields(minimal, "stiff-contact", stiff, IMPACT, **soft, minimal=True)
    else:
        connects = "a connect for each loop; without it the links swing freely"
        yield edit("closure", connects, TORQUE, REACTIONS, minimal=True, absence="open-loops")
        hard = "the regularisation of constraints taken away after compiling; without it, as MJCF can say it"
        yield fields(minimal, "hardening", hard, TORQUE, REACTIONS, hardening=None, minimal=True)
        slow = f"a time constant of a tenth of the period; without it MuJoCo's default, {STOCK_SOLREF[0]:g} s"
        yield fields(minimal, "slow-closure", slow, solref=STOCK_SOLREF, minimal=True)
        yield fields(minimal, "rk4", "four evaluations a step; without it Euler", integrator="Euler", minimal=True)
    armature = "an armature that keeps the crank at its speed; without it the crank is only set in motion"
    yield fields(minimal, "flywheel", armature, TORQUE, armature=0.0, minimal=True)
    yield fields(minimal, "iteration", "one iteration of Newton's method; without it none", iterations=0, minimal=True)
    tolerance = (
        f"a tolerance of 0 of the solver; without it MuJoCo's default, {STOCK_TOLERANCE:g}, scaled by a mean inertia "
        "that has the flywheel in it"
    )
    yield fields(minimal, "tolerance-0", tolerance, tolerance=STOCK_TOLERANCE, minimal=True)
