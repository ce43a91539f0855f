"""The minimal pymunk model, its optional and required ingredients. Imports no engine."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

from conrod.engines.engine import Machine, with_fields
from conrod.engines.ingredients import Ingredient, Ingredients, Quantity, edited, unedited, valued
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT, form_refusal
from conrod.engines.pymunk import settings as names
from conrod.engines.pymunk.settings import STOCK_BIAS, PymunkSettings

TORQUE, REACTIONS, IMPACT, WEAR = Quantity.DRIVE_TORQUE, Quantity.REACTIONS, Quantity.IMPACT, Quantity.WEAR
AMOUNTS = (100, 1000)  # of iterations; ten, pymunk's default, is what the minimal model has
FINER = 4  # times the vertices of the minimal model's cam
STOCK_SLOP = 0.1  # [m]

Found: TypeAlias = tuple[Ingredient[PymunkSettings], ...]
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


def ingredients(machine: Machine, minimal: PymunkSettings) -> Found:
    """Ingredients of the minimal model; only those that apply to the machine.

    In the order of a report: shapes, physics, joints, the solver, contact; what closes the loop, what makes it exact.
    """
    mechanism, make = machine.kinematics.mechanism, Ingredients(minimal)
    contact = bool(mechanism.cam_contacts)
    return (
        *_shapes(make),
        *(_weight(make) if mechanism.gravity != (0.0, 0.0) else ()),
        make.edit("damping", "damping of the space", "a tenth of every velocity lost in a second", TORQUE, REACTIONS),
        make.edit("redundant-joints", "redundant joints", "every joint a second time"),
        *_amounts(_iterations(machine, minimal), contact),
        *(_rod(machine, minimal) if minimal.rod == DISTANCE_JOINT else ()),
        *_amounts(_substeps(make), contact),
        make.edit("sleeping", "sleeping", "bodies at rest for half a second are put to sleep"),
        _fine_cam(make) if contact else _stock_contact(make),
        *(_contact(make) if contact else _closure(make)),
        make.needed_fields(
            "iterations",
            "iterations of the solver",
            f"{minimal.iterations} of them; without them a single one",
            REACTIONS,
            iterations=1,
        ),
    )


# -- optional ---------------------------------------------------------------------------------------------------------


def _shapes(make: Ingredients[PymunkSettings]) -> Found:
    """The last is what the dressed model has: the way that pymunk's manual shows."""
    kinds = (
        (names.SHAPES_UNFILTERED, "shapes without a filter", "those of links that no joint holds together may collide"),
        (names.SHAPES_SENSOR, "shapes as sensors", "overlaps are found, and nothing follows"),
        (names.SHAPES_MASKED, "shapes that a mask filters", "a mask of no category: they collide with nothing"),
        (names.SHAPES_POLYGONS, "shapes of 200 vertices", "all in one group; the other kinds have four vertices"),
        (names.SHAPES_GROUPED, "shapes that a group filters", "in one group, whose shapes do not collide"),
    )
    return tuple(
        make.edit(name, title, f"a polygon on every link; {meaning}", IMPACT, group="shapes")
        for name, title, meaning in kinds
    )


def _weight(make: Ingredients[PymunkSettings]) -> Found:
    return (make.fields("gravity", "gravity", "the weight of all links", TORQUE, REACTIONS, WEAR, gravity=True),)


def enough(machine: Machine, minimal: PymunkSettings, settings: PymunkSettings) -> int:
    """Iterations that a form of the rods needs: as bodies those of the tuned preset, in proportion to their masses."""
    if settings.rod == minimal.rod:
        return minimal.iterations
    return PymunkSettings.tuned(machine, minimal.steps_per_revolution).iterations


def _amounts(found: Found, contact: bool) -> Found:
    """The last one is what the dressed model has: the most, or of a cam, whose turn takes more steps, the least."""
    return found[::-1] if contact else found


def _iterations(machine: Machine, minimal: PymunkSettings) -> Found:
    def without(settings: PymunkSettings) -> PymunkSettings:
        return with_fields(settings, iterations=enough(machine, minimal, settings))

    return tuple(
        Ingredient(
            f"iterations-{count}",
            f"{count} iterations",
            f"of the solver, instead of {minimal.iterations}",
            valued(iterations=count),
            without,
            group="iterations",
            needed_by=(REACTIONS,),
        )
        for count in AMOUNTS
        if count > minimal.iterations
    )


def _rod(machine: Machine, minimal: PymunkSettings) -> Found:
    """The last is what the dressed model has."""

    def added(settings: PymunkSettings) -> PymunkSettings:
        bodies = with_fields(settings, rod=BODY)
        return replace(bodies, iterations=max(settings.iterations, enough(machine, minimal, bodies)))

    def removed(settings: PymunkSettings) -> PymunkSettings:
        # More iterations than the bodies need are an ingredient of their own.
        kept = settings.iterations > enough(machine, minimal, settings)
        iterations = settings.iterations if kept else minimal.iterations
        return with_fields(settings, rod=minimal.rod, iterations=iterations)

    collide, part, bare = edited(names.SHAPES_COLLIDING), unedited(names.SHAPES_COLLIDING), unedited(*names.SHAPES)
    needed_by = (TORQUE, REACTIONS, WEAR)
    return (
        Ingredient(
            "rod-body-colliding",
            "the rod as a body, shapes colliding",
            "with a polygon on every link, and those of links that a joint holds together collide: as pymunk has it "
            "unless it is told otherwise",
            lambda settings: collide(bare(added(settings))),
            lambda settings: removed(part(settings)),
            group="rod",
            needed_by=(*needed_by, IMPACT),
        ),
        Ingredient(
            "rod-body",
            "the rod as a body",
            "with its mass and two pivots instead of one distance joint, and the iterations that this takes",
            added,
            removed,
            group="rod",
            needed_by=needed_by,
        ),
    )


def _substeps(make: Ingredients[PymunkSettings]) -> Found:
    return tuple(
        make.edit(name, f"{count} sub-steps", f"the space is stepped {count} times for each step", group="sub-steps")
        for name, count in names.SUBSTEPS.items()
    )


def _stock_contact(make: Ingredients[PymunkSettings]) -> Ingredient[PymunkSettings]:
    return make.fields(
        "stock-contact",
        "slop and bias of contacts",
        f"pymunk's defaults, {STOCK_SLOP:g} m and 0.9^60, in a machine without contact",
        IMPACT,
        collision_slop=STOCK_SLOP,
        collision_bias=STOCK_BIAS,
    )


def _fine_cam(make: Ingredients[PymunkSettings]) -> Ingredient[PymunkSettings]:
    before, vertices = make.model.cam_vertices, FINER * make.model.cam_vertices
    title, meaning = f"a cam of {FINER} times the vertices", f"{vertices} vertices instead of {before}"
    return make.fields("fine-cam", title, meaning, IMPACT, WEAR, cam_vertices=vertices)


# -- required: each taken away alone ----------------------------------------------------------------------------------


def _closure(make: Ingredients[PymunkSettings]) -> Found:
    return (
        make.needed_edit(
            "closure",
            "the joint that closes the loop",
            "a distance joint in place of the rod, or its last pivot; without it the links swing freely",
            TORQUE,
            REACTIONS,
            absence=names.OPEN_LOOP,
        ),
        make.needed_fields(
            "full-correction",
            "error_bias = 0",
            "joints mended whole at every step; without it pymunk's default, 0.9^60 left after a second",
            error_bias=STOCK_BIAS,
        ),
    )


def _contact(make: Ingredients[PymunkSettings]) -> Found:
    return (
        make.needed_edit(
            "contact",
            "the contact",
            "the shapes of cam and roller; without them the roller falls through",
            TORQUE,
            REACTIONS,
            absence=names.OPEN_LOOP,
        ),
        make.needed_fields(
            "small-slop",
            "a small slop",
            f"half the way that the follower falls in a step; without it pymunk's default, {STOCK_SLOP:g} m",
            IMPACT,
            collision_slop=STOCK_SLOP,
        ),
        make.needed_fields(
            "full-contact-correction",
            "collision_bias = 0",
            "an overlap mended whole at every step; without it pymunk's default, 0.9^60 left after a second",
            IMPACT,
            collision_bias=STOCK_BIAS,
        ),
    )
