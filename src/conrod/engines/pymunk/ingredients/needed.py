"""What the minimal pymunk model consists of, each to be taken away alone. Imports no engine."""

from __future__ import annotations

from dataclasses import replace

from conrod.engines.engine import Machine
from conrod.engines.ingredient import Ingredient, Quantity
from conrod.engines.left_out_rod import DISTANCE_JOINT
from conrod.engines.pymunk import dressing_names as names
from conrod.engines.pymunk.ingredients.carried import STOCK_SLOP
from conrod.engines.pymunk.settings import STOCK_BIAS, PymunkSettings
from conrod.engines.ways import dressed, fields_of, part, undressed, with_fields
from conrod.equivalent_linkage import CONTACT, EQUIVALENT_LINKAGE, linkage_refusal

TORQUE, REACTIONS, IMPACT, WEAR = Quantity.DRIVE_TORQUE, Quantity.REACTIONS, Quantity.IMPACT, Quantity.WEAR
# At a switch the solver starts without impulses to begin from: with ten iterations the acceleration just after one is
# wrong by 3 % at any step, with twenty it is not.
LINKAGE_ITERATIONS = 20

Found = tuple[Ingredient[PymunkSettings], ...]


def needed(machine: Machine, minimal: PymunkSettings) -> Found:
    """What closes the loop first, then what makes it exact, then the solver."""
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    return (
        *(_of_contact(machine, minimal) if contact else _of_loops(minimal)),
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


def _of_contact(machine: Machine, minimal: PymunkSettings) -> Found:
    found: Found = (
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
    if linkage_refusal(machine.kinematics.mechanism):
        return found
    return (*found, equivalent(minimal))


def equivalent(minimal: PymunkSettings) -> Ingredient[PymunkSettings]:
    """The cam by contact: without it by its equivalent linkage."""

    def without(settings: PymunkSettings) -> PymunkSettings:
        iterations = max(settings.iterations, LINKAGE_ITERATIONS)
        return replace(
            settings, preset="custom", cam=EQUIVALENT_LINKAGE, rod=DISTANCE_JOINT, error_bias=0.0, iterations=iterations
        )

    return part(
        "cam-by-contact",
        "the cam by contact, not by its equivalent linkage",
        "cam and roller collide; without it the cam is a crank to the centre of the arc that is touched, with a rod to "
        "the roller's centre, switched at the joints of the arcs: no float, no loss of contact, no contact force",
        with_fields(cam=CONTACT, **fields_of(minimal, "rod", "error_bias", "iterations")),
        without,
        REACTIONS,
        IMPACT,
        WEAR,
    )
