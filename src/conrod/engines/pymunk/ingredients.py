"""The minimal pymunk model, its optional and required ingredients. Imports no engine."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, TypeAlias

from conrod.engines.engine import Machine, with_fields
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT, form_refusal
from conrod.engines.pymunk.settings import SHAPES, STOCK_BIAS, SUBSTEPS, PymunkSettings
from conrod.engines.variants import (
    Ingredient,
    Quantity,
    edit,
    edited,
    fields,
    unedited,
    valued,
)

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
    """Ingredients of the minimal model, optional ones first; only those that apply to the machine."""
    mechanism = machine.kinematics.mechanism
    return (
        *_optional(machine, minimal, mechanism.gravity != (0.0, 0.0)),
        *_required(minimal, bool(mechanism.cam_contacts)),
    )


def _optional(machine: Machine, minimal: PymunkSettings, heavy: bool) -> Iterator[Ingredient[PymunkSettings]]:
    """Shapes, physics, joints, the solver, contact."""
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    # The last is what the dressed model has: the way that pymunk's manual shows.
    shapes = {
        "unfiltered": "those of links that no joint holds together may collide",
        "sensor": "overlaps are found, and nothing follows",
        "masked": "a mask of no category: they collide with nothing",
        "polygons": "of 200 vertices, all in one group; the other kinds have four vertices",
        "grouped": "in one group, whose shapes do not collide",
    }
    for kind, meaning in shapes.items():
        yield edit(f"shapes-{kind}", f"a polygon on every link; {meaning}", IMPACT, group="shapes")
    if heavy:
        yield fields(minimal, "gravity", "the weight of all links", TORQUE, REACTIONS, WEAR, gravity=True)
    yield edit("damping", "a tenth of every velocity lost in a second", TORQUE, REACTIONS)
    yield edit("redundant-joints", "every joint a second time")
    # Of amounts the dressed model has the most, or of a cam, whose turn takes more steps, the least.
    order = -1 if contact else 1
    yield from list(_iterations(machine, minimal))[::order]
    if minimal.rod == DISTANCE_JOINT:
        yield from _rod(machine, minimal)
    for name, count in list(SUBSTEPS.items())[::order]:
        yield edit(name, f"the space is stepped {count} times for each step", group="sub-steps")
    yield edit("sleeping", "bodies at rest for half a second are put to sleep")
    if contact:
        vertices = FINER * minimal.cam_vertices
        meaning = f"a cam of {vertices} vertices instead of {minimal.cam_vertices}"
        yield fields(minimal, "fine-cam", meaning, IMPACT, WEAR, cam_vertices=vertices)
    else:
        meaning = f"slop and bias of contacts, pymunk's {STOCK_SLOP:g} m and 0.9^60, in a machine without contact"
        stock: dict[str, Any] = {"collision_slop": STOCK_SLOP, "collision_bias": STOCK_BIAS}
        yield fields(minimal, "stock-contact", meaning, IMPACT, **stock)


def _iterations(machine: Machine, minimal: PymunkSettings) -> Iterator[Ingredient[PymunkSettings]]:
    def without(settings: PymunkSettings) -> PymunkSettings:
        return with_fields(settings, iterations=enough(machine, minimal, settings))

    for count in (count for count in AMOUNTS if count > minimal.iterations):
        meaning, more = f"of the solver, instead of {minimal.iterations}", valued(iterations=count)
        yield Ingredient(f"iterations-{count}", meaning, more, without, (REACTIONS,), group="iterations")


def enough(machine: Machine, minimal: PymunkSettings, settings: PymunkSettings) -> int:
    """Iterations that a form of the rods needs: as bodies those of the tuned preset."""
    if settings.rod == minimal.rod:
        return minimal.iterations
    return PymunkSettings.tuned(machine, minimal.steps_per_revolution).iterations


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

    collide, part, bare = edited("shapes-colliding"), unedited("shapes-colliding"), unedited(*SHAPES)
    colliding = (
        "the rod as a body, with a polygon on every link, and those of links that a joint holds together collide: as "
        "pymunk has it by default"
    )
    body = "with its mass and two pivots instead of one distance joint, and the iterations that this takes"
    needed_by = (TORQUE, REACTIONS, WEAR)
    return (
        Ingredient(
            "rod-body-colliding",
            colliding,
            lambda settings: collide(bare(added(settings))),
            lambda settings: removed(part(settings)),
            (*needed_by, IMPACT),
            group="rod",
        ),
        Ingredient("rod-body", body, added, removed, needed_by, group="rod"),
    )


def _required(minimal: PymunkSettings, contact: bool) -> Iterator[Ingredient[PymunkSettings]]:
    """What the minimal model consists of: what closes the loop, what makes it exact, the solver."""
    default = "without it pymunk's default, 0.9^60 left after a second"
    if contact:
        shapes = "the shapes of cam and roller; without them the roller falls through"
        yield edit("contact", shapes, TORQUE, REACTIONS, minimal=True, absence="open-loop")
        slop = f"half the way that the follower falls in a step; without it pymunk's default, {STOCK_SLOP:g} m"
        yield fields(minimal, "small-slop", slop, IMPACT, collision_slop=STOCK_SLOP, minimal=True)
        mended = f"collision_bias = 0, an overlap mended whole at every step; {default}"
        yield fields(minimal, "full-contact-correction", mended, IMPACT, collision_bias=STOCK_BIAS, minimal=True)
    else:
        joint = "a distance joint in place of the rod, or its last pivot; without it the links swing freely"
        yield edit("closure", joint, TORQUE, REACTIONS, minimal=True, absence="open-loop")
        mended = f"error_bias = 0, joints mended whole at every step; {default}"
        yield fields(minimal, "full-correction", mended, error_bias=STOCK_BIAS, minimal=True)
    several = f"{minimal.iterations} of the solver; without them a single one"
    yield fields(minimal, "iterations", several, REACTIONS, iterations=1, minimal=True)
