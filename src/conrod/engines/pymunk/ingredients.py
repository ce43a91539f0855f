"""The minimal pymunk model, and the ingredients to add to it or remove. Does not import the engine."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, TypeAlias

from conrod.engines.engine import Machine, with_fields
from conrod.engines.pymunk import (
    DISTANCE_RODS,
    LIGHT_RODS,
    MIN_ITERATIONS,
    STOCK_BIAS,
    STOCK_SLOP,
    PymunkSettings,
    iterations_needed,
)
from conrod.engines.pymunk.distance_rods import LIGHT_SHARE, NO_ROD, find_rods
from conrod.engines.variants import (
    NO_CONTACT,
    NO_GRAVITY,
    NO_LOOPS,
    Ingredient,
    Quantity,
    field_ingredient,
    model_edit_ingredient,
)

TORQUE, REACTIONS, IMPACT, WEAR = Quantity.DRIVE_TORQUE, Quantity.REACTIONS, Quantity.IMPACT, Quantity.WEAR
MANY_ITERATIONS = 1000
FINE_CAM_FACTOR = 4  # on the vertices of the minimal model's cam

PymunkIngredient: TypeAlias = Ingredient[PymunkSettings]


def minimal_settings(machine: Machine, steps_per_revolution: int) -> PymunkSettings:
    """The cheapest settings with the right observed motion.

    The preset `tuned` without gravity, with rods as distance joints where there are any, and with no more iterations
    than these take.
    """
    kinematics = machine.kinematics
    tuned = replace(PymunkSettings.tuned(machine, steps_per_revolution), preset="custom", gravity=False)
    if kinematics.mechanism.cam_contacts:
        # A follower on a cam has two equations alone, which are solved in one iteration.
        alone = len(kinematics.mechanism.bodies) == 2
        return replace(tuned, iterations=MIN_ITERATIONS) if alone else tuned
    rods = find_rods(kinematics.mechanism)
    if not rods:
        return tuned
    enough = iterations_needed(kinematics, machine.speed, rods)
    return replace(tuned, dressing=(DISTANCE_RODS,), iterations=min(enough, tuned.iterations))


def ingredients(machine: Machine, minimal: PymunkSettings) -> tuple[PymunkIngredient, ...]:
    """Return the ingredients to add to a machine's minimal model, then those to remove."""
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    return (*_optional_ingredients(machine, minimal, contact), *_minimal_ingredients(minimal, contact))


def _optional_ingredients(machine: Machine, minimal: PymunkSettings, contact: bool) -> Iterator[PymunkIngredient]:
    """Optional ingredients: shapes, gravity, bodies of rods, iterations, joints, a finer cam."""
    mechanism = machine.kinematics.mechanism
    loops, rods = NO_LOOPS if contact else "", "" if find_rods(mechanism) else NO_ROD
    tuned = PymunkSettings.tuned(machine, minimal.steps_per_revolution).iterations
    filtered = "a rectangle on every link that a filter keeps from colliding: looked at in each step, never touching"
    yield model_edit_ingredient("filtered-shapes", filtered, IMPACT)
    yield _touching_shapes(minimal, tuned, loops)
    weight = "the weight of all links"
    heavy = "" if any(mechanism.gravity) else NO_GRAVITY
    yield field_ingredient(minimal, "gravity", weight, TORQUE, REACTIONS, WEAR, refusal=heavy, gravity=True)
    body = (
        "every rod as a body with its mass and two pivots, and the iterations that this takes, not as a distance joint"
    )
    yield _rod_bodies("rod-body", body, minimal, tuned, rods)
    light = f"the same with {LIGHT_SHARE:g} of the mass, as a link without mass is modelled where every link is a body"
    yield _rod_bodies("light-rod-body", light, minimal, tuned, rods, LIGHT_RODS)
    yield _many_iterations(minimal, tuned)
    yield model_edit_ingredient("redundant-joints", "every joint a second time")
    vertices = FINE_CAM_FACTOR * minimal.cam_vertices
    finer = f"a cam of {vertices} vertices instead of {minimal.cam_vertices}"
    no_cam = "" if contact else NO_CONTACT
    yield field_ingredient(minimal, "fine-cam", finer, IMPACT, WEAR, refusal=no_cam, cam_vertices=vertices)


def _with_rod_bodies(settings: PymunkSettings, tuned: int, *edits: str) -> PymunkSettings:
    """Settings with a body for every rod, with at least the iterations of the preset `tuned`, and with more edits."""
    others = tuple(name for name in settings.dressing if name not in (DISTANCE_RODS, LIGHT_RODS))
    return with_fields(settings, dressing=(*others, *edits), iterations=max(settings.iterations, tuned))


def _rod_bodies(
    name: str, meaning: str, minimal: PymunkSettings, tuned: int, refusal: str, *edits: str
) -> PymunkIngredient:
    """Ingredient that models rods as bodies, where the minimal model has distance joints."""

    def remove_bodies(settings: PymunkSettings) -> PymunkSettings:
        others = tuple(one for one in settings.dressing if one not in edits)
        # More iterations than the bodies take are an ingredient of their own.
        count = settings.iterations if settings.iterations > tuned else minimal.iterations
        return with_fields(settings, dressing=(*others, DISTANCE_RODS), iterations=count)

    needed_by = (TORQUE, REACTIONS, WEAR)
    return Ingredient(
        name, meaning, lambda s: _with_rod_bodies(s, tuned, *edits), remove_bodies, needed_by, refusal=refusal
    )


def _touching_shapes(minimal: PymunkSettings, tuned: int, refusal: str) -> PymunkIngredient:
    """Ingredient of shapes that collide where pins join links; it makes a body of each link, too."""
    name = "touching-shapes"
    meaning = (
        "a rectangle on every link, each of which is a body, and links that a joint holds together collide, as pymunk "
        "has it by default: they overlap where pins join them"
    )

    def remove_shapes(settings: PymunkSettings) -> PymunkSettings:
        return with_fields(settings, dressing=tuple(one for one in settings.dressing if one != name))

    return Ingredient(
        name, meaning, lambda s: _with_rod_bodies(s, tuned, name), remove_shapes, (IMPACT,), refusal=refusal
    )


def _many_iterations(minimal: PymunkSettings, tuned: int) -> PymunkIngredient:
    """Ingredient of more solver iterations than the minimal model takes."""

    def remove_iterations(settings: PymunkSettings) -> PymunkSettings:
        enough = minimal.iterations if DISTANCE_RODS in settings.dressing or not minimal.dressing else tuned
        return with_fields(settings, iterations=enough)

    return Ingredient(
        f"iterations-{MANY_ITERATIONS}",
        f"iterations of the solver, instead of {minimal.iterations}",
        lambda settings: with_fields(settings, iterations=max(settings.iterations, MANY_ITERATIONS)),
        remove_iterations,
        (REACTIONS,),
        refusal=f"the model takes {minimal.iterations}" if minimal.iterations >= MANY_ITERATIONS else "",
    )


def _minimal_ingredients(minimal: PymunkSettings, contact: bool) -> Iterator[PymunkIngredient]:
    """Ingredients of the minimal model: what closes it, correction of joints or contact, iterations."""
    default = "without it pymunk's default, 0.9^60 of an error left after a second"
    if contact:
        shapes = "the shapes of cam and roller; without them the roller falls through"
        yield model_edit_ingredient("contact", shapes, TORQUE, REACTIONS, minimal=True, absence="no-contact")
        slop = f"half the way that the follower falls in a step; without it pymunk's default, {STOCK_SLOP:g} m"
        yield field_ingredient(minimal, "small-slop", slop, IMPACT, minimal=True, collision_slop=STOCK_SLOP)
        corrected: dict[str, Any] = {"collision_bias": STOCK_BIAS}
        meaning = f"collision_bias = 0, an overlap corrected whole at every step; {default}"
        yield field_ingredient(minimal, "full-contact-correction", meaning, IMPACT, minimal=True, **corrected)
    else:
        joint = (
            "the joint that closes the loop: a rod's distance joint, or the last pivot; without it links swing freely"
        )
        yield model_edit_ingredient("closure", joint, TORQUE, REACTIONS, minimal=True, absence="open-loop")
        meaning = f"error_bias = 0, joints corrected whole at every step; {default}"
        yield field_ingredient(minimal, "full-correction", meaning, minimal=True, error_bias=STOCK_BIAS)
    several = f"{minimal.iterations} iterations of the solver; without them a single one"
    yield field_ingredient(minimal, "iterations", several, REACTIONS, minimal=True, iterations=1)
