"""What a pymunk model may carry that its minimal model lacks. Imports no engine."""

from __future__ import annotations

from dataclasses import replace

from conrod.engines.engine import Machine
from conrod.engines.ingredients import Ingredient, Quantity, Way, dressed, extra, of_fields, undressed, with_fields
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT
from conrod.engines.pymunk import settings as names
from conrod.engines.pymunk.settings import STOCK_BIAS, PymunkSettings

TORQUE, REACTIONS, IMPACT, WEAR = Quantity.DRIVE_TORQUE, Quantity.REACTIONS, Quantity.IMPACT, Quantity.WEAR
AMOUNTS = (100, 1000)  # of iterations; ten, pymunk's default, is what the minimal model has
FINER = 4  # times the vertices of the minimal model's cam
STOCK_SLOP = 0.1  # [m]

Found = tuple[Ingredient[PymunkSettings], ...]


def carried(machine: Machine, minimal: PymunkSettings) -> Found:
    """In the order of a report: shapes, physics, joints, the solver, contact."""
    mechanism = machine.kinematics.mechanism
    contact = bool(mechanism.cam_contacts)
    return (
        *_shapes(),
        *(_gravity(minimal) if mechanism.gravity != (0.0, 0.0) else ()),
        extra("damping", "damping of the space", "a tenth of every velocity lost in a second", TORQUE, REACTIONS),
        extra("redundant-joints", "redundant joints", "every joint a second time"),
        *_amounts(_iterations(machine, minimal), contact),
        *(_rod(machine, minimal) if minimal.rod == DISTANCE_JOINT else ()),
        *_amounts(_substeps(), contact),
        extra("sleeping", "sleeping", "bodies at rest for half a second are put to sleep"),
        *(_cam(minimal) if contact else _contact_of_none(minimal)),
    )


def _shapes() -> Found:
    """The last is what the dressed model has: the way that pymunk's manual shows."""
    kinds = (
        (names.SHAPES_UNFILTERED, "shapes without a filter", "those of links that no joint holds together may collide"),
        (names.SHAPES_SENSOR, "shapes as sensors", "overlaps are found, and nothing follows"),
        (names.SHAPES_MASKED, "shapes that a mask filters", "a mask of no category: they collide with nothing"),
        (names.SHAPES_POLYGONS, "shapes of 200 vertices", "all in one group; the other kinds have four vertices"),
        (names.SHAPES_GROUPED, "shapes that a group filters", "in one group, whose shapes do not collide"),
    )
    return tuple(
        extra(name, title, f"a polygon on every link; {meaning}", IMPACT, group="shapes")
        for name, title, meaning in kinds
    )


def _gravity(minimal: PymunkSettings) -> Found:
    return (
        of_fields("gravity", "gravity", "the weight of all links", minimal, {"gravity": True}, TORQUE, REACTIONS, WEAR),
    )


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
        return replace(settings, preset="custom", iterations=enough(machine, minimal, settings))

    return tuple(
        Ingredient(
            f"iterations-{count}",
            f"{count} iterations",
            f"of the solver, instead of {minimal.iterations}",
            with_fields(iterations=count),
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
        bodies = replace(settings, preset="custom", rod=BODY)
        return replace(bodies, iterations=max(settings.iterations, enough(machine, minimal, bodies)))

    def removed(settings: PymunkSettings) -> PymunkSettings:
        # More iterations than the bodies need are an ingredient of their own.
        kept = settings.iterations > enough(machine, minimal, settings)
        iterations = settings.iterations if kept else minimal.iterations
        return replace(settings, preset="custom", rod=minimal.rod, iterations=iterations)

    collide: Way[PymunkSettings] = dressed(names.SHAPES_COLLIDING)
    part: Way[PymunkSettings] = undressed(names.SHAPES_COLLIDING)
    bare: Way[PymunkSettings] = undressed(*names.SHAPES)
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


def _substeps() -> Found:
    return tuple(
        extra(name, f"{count} sub-steps", f"the space is stepped {count} times for each step", group="sub-steps")
        for name, count in names.SUBSTEPS.items()
    )


def _contact_of_none(minimal: PymunkSettings) -> Found:
    return (
        of_fields(
            "stock-contact",
            "slop and bias of contacts",
            f"pymunk's defaults, {STOCK_SLOP:g} m and 0.9^60, in a machine without contact",
            minimal,
            {"collision_slop": STOCK_SLOP, "collision_bias": STOCK_BIAS},
            IMPACT,
        ),
    )


def _cam(minimal: PymunkSettings) -> Found:
    return (
        of_fields(
            "fine-cam",
            f"a cam of {FINER} times the vertices",
            f"{FINER * minimal.cam_vertices} vertices instead of {minimal.cam_vertices}",
            minimal,
            {"cam_vertices": FINER * minimal.cam_vertices},
            IMPACT,
            WEAR,
        ),
    )
