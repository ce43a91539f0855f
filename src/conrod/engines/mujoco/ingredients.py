"""What the minimal MuJoCo model consists of, each to be taken away alone. Imports no engine.

What a MuJoCo model may carry, and the minimal model that it is added to. Imports no engine.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from conrod.engines.engine import Machine
from conrod.engines.ingredients import Ingredient, Quantity, Way, dressed, fields_of, part, undressed, with_fields
from conrod.engines.mujoco.model_edits import edit_refusal
from conrod.engines.mujoco.optional_ingredients import carried
from conrod.engines.mujoco.settings import STOCK_SOLIMP, STOCK_SOLREF, MuJoCoSettings

TORQUE, REACTIONS = Quantity.DRIVE_TORQUE, Quantity.REACTIONS
DEFAULT_TOLERANCE = 1e-8
GUARDED_STEPS = 2.0  # MuJoCo raises a time constant below so many steps to them


def needed(contact: bool, minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
    """The closure first, then what makes it exact, the drive, the solver."""
    return (*(_of_contact(minimal) if contact else _of_loops(minimal)), *_of_all(contact, minimal))


def _changed(minimal: MuJoCoSettings, **without: Any) -> tuple[Way[MuJoCoSettings], Way[MuJoCoSettings]]:
    """Fields as the minimal model has them, and as they are without the ingredient."""
    return with_fields(**fields_of(minimal, *without)), with_fields(**without)


def _of_loops(minimal: MuJoCoSettings) -> list[Ingredient[MuJoCoSettings]]:
    return [
        part(
            "closure",
            "the loop closure",
            "a connect for each loop; without it the links swing freely",
            undressed("open-loops"),
            dressed("open-loops"),
            TORQUE,
            REACTIONS,
        ),
        part(
            "hardening",
            "hardening",
            "the regularisation of constraints taken away after compiling; without it, as MJCF can say it",
            *_changed(minimal, hardening=None),
            TORQUE,
            REACTIONS,
        ),
        part(
            "slow-closure",
            "a slow closure",
            f"a time constant of a tenth of the period; without it MuJoCo's default, {STOCK_SOLREF[0]:g} s",
            *_changed(minimal, solref=STOCK_SOLREF),
        ),
        part("rk4", "RK4", "four evaluations a step; without it Euler", *_changed(minimal, integrator="Euler")),
    ]


def _of_contact(minimal: MuJoCoSettings) -> list[Ingredient[MuJoCoSettings]]:
    return [
        part(
            "contact",
            "the contact",
            "the pair of cam and roller; without it the roller falls through",
            undressed("no-contact"),
            dressed("no-contact"),
            TORQUE,
            REACTIONS,
        ),
        part(
            "stiff-contact",
            "a stiff contact",
            "a time constant of two steps and an impedance of 0.9; without it MuJoCo's defaults",
            *_changed(minimal, contact_solref=STOCK_SOLREF, contact_solimp=STOCK_SOLIMP),
            Quantity.IMPACT,
        ),
    ]


def _of_all(contact: bool, minimal: MuJoCoSettings) -> list[Ingredient[MuJoCoSettings]]:
    found = [
        part(
            "flywheel",
            "the armature of the drive",
            "a flywheel that keeps the crank at its speed; without it the crank is only set in motion",
            *_changed(minimal, armature=0.0),
            TORQUE,
        ),
        part(
            "iteration",
            "an iteration of the solver",
            "one iteration of Newton's method; without it none",
            *_changed(minimal, iterations=0),
        ),
        part(
            "tolerance-0",
            "a solver tolerance of 0",
            f"without it MuJoCo's default, {DEFAULT_TOLERANCE:g}, scaled by a mean inertia that has the flywheel in it",
            *_changed(minimal, tolerance=DEFAULT_TOLERANCE),
        ),
    ]
    if minimal.refsafe and 0.0 < minimal.time_constant(contact) < GUARDED_STEPS * minimal.timestep:
        found.append(
            part(
                "refsafe",
                "the guard of short time constants",
                "time constants below two steps raised to them; without it as they are said",
                *_changed(minimal, refsafe=False),
            )
        )
    return found


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


def ingredients(machine: Machine, minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
    """What may be added to the minimal model, and what may be taken from it; only what applies to the machine."""
    mechanism = machine.kinematics.mechanism
    contact = bool(mechanism.cam_contacts)
    found = (*carried(mechanism, minimal), *needed(contact, minimal))
    # What is added is what must apply; of what the model consists of, it is what is missing then.
    return tuple(
        one for one in found if not edit_refusal(mechanism, (one.removed if one.minimal else one.added)(minimal))
    )
