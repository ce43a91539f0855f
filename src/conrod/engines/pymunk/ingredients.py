"""What the minimal pymunk model consists of, each to be taken away alone. Imports no engine.

What a pymunk model may carry, and the minimal model that it is added to. Imports no engine.
"""

from __future__ import annotations

from dataclasses import replace

from conrod.engines.engine import Machine
from conrod.engines.ingredients import Ingredient, Quantity, dressed, fields_of, part, undressed, with_fields
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT, form_refusal
from conrod.engines.pymunk import settings as names
from conrod.engines.pymunk.optional_ingredients import STOCK_SLOP, carried
from conrod.engines.pymunk.settings import STOCK_BIAS, PymunkSettings

TORQUE, REACTIONS, IMPACT = Quantity.DRIVE_TORQUE, Quantity.REACTIONS, Quantity.IMPACT

Found = tuple[Ingredient[PymunkSettings], ...]


def needed(machine: Machine, minimal: PymunkSettings) -> Found:
    """What closes the loop first, then what makes it exact, then the solver."""
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    return (
        *(_of_contact(minimal) if contact else _of_loops(minimal)),
        part(
            "iterations",
            "iterations of the solver",
            f"{minimal.iterations} of them; without them a single one",
            with_fields(**fields_of(minimal, "iterations")),
            with_fields(iterations=1),
            REACTIONS,
        ),
    )


def _of_loops(minimal: PymunkSettings) -> Found:
    return (
        part(
            "closure",
            "the joint that closes the loop",
            "a distance joint in place of the rod, or its last pivot; without it the links swing freely",
            undressed(names.OPEN_LOOP),
            dressed(names.OPEN_LOOP),
            TORQUE,
            REACTIONS,
        ),
        part(
            "full-correction",
            "error_bias = 0",
            "joints mended whole at every step; without it pymunk's default, 0.9^60 left after a second",
            with_fields(**fields_of(minimal, "error_bias")),
            with_fields(error_bias=STOCK_BIAS),
        ),
    )


def _of_contact(minimal: PymunkSettings) -> Found:
    return (
        part(
            "contact",
            "the contact",
            "the shapes of cam and roller; without them the roller falls through",
            undressed(names.OPEN_LOOP),
            dressed(names.OPEN_LOOP),
            TORQUE,
            REACTIONS,
        ),
        part(
            "small-slop",
            "a small slop",
            f"half the way that the follower falls in a step; without it pymunk's default, {STOCK_SLOP:g} m",
            with_fields(**fields_of(minimal, "collision_slop")),
            with_fields(collision_slop=STOCK_SLOP),
            IMPACT,
        ),
        part(
            "full-contact-correction",
            "collision_bias = 0",
            "an overlap mended whole at every step; without it pymunk's default, 0.9^60 left after a second",
            with_fields(**fields_of(minimal, "collision_bias")),
            with_fields(collision_bias=STOCK_BIAS),
            IMPACT,
        ),
    )


# pymunk's default. With rods as distance joints the velocity and the acceleration are then within 3 % of what ten
# thousand give on the press and the saw (1000 steps a turn), and within a third where the transmission angle falls to
# ten degrees; with one iteration the saw's acceleration is wrong by a tenth of its size.
ENOUGH = 10


def minimal(machine: Machine, steps_per_revolution: int) -> PymunkSettings:
    """The cheapest settings that have the observed motion right.

    Joints mended whole at every step, rods as distance joints, and no gravity: with the crank prescribed the motion
    depends on no mass. Rods as bodies have the same motion, and need iterations in proportion to the ratio of masses:
    at ten of them the press is off in acceleration by 0.19 of omega^2 L, at a hundred it is as accurate as this one, at
    several times its cost (1000 steps a turn).
    """
    mechanism = machine.kinematics.mechanism
    tuned = replace(PymunkSettings.tuned(machine, steps_per_revolution), preset="custom", gravity=False)
    if mechanism.cam_contacts:
        return replace(tuned, iterations=ENOUGH)
    if form_refusal(mechanism, DISTANCE_JOINT):
        return replace(tuned, rod=BODY)
    return replace(tuned, rod=DISTANCE_JOINT, iterations=ENOUGH)


def ingredients(machine: Machine, minimal: PymunkSettings) -> tuple[Ingredient[PymunkSettings], ...]:
    """What may be added to the minimal model, and what may be taken from it; only what applies to the machine."""
    return (*carried(machine, minimal), *needed(machine, minimal))
