"""What a MuJoCo model may carry that its minimal model lacks. Imports no engine."""

from __future__ import annotations

from conrod.engines.ingredient import Ingredient, Quantity
from conrod.engines.mujoco.dressing import NOSLIP_ITERATIONS, PASSIVE_ARMATURE, PASSIVE_DAMPING
from conrod.engines.mujoco.ingredients.ways import dressed, extra, fields_of, undressed, with_fields
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.mechanism import Mechanism

TORQUE, REACTIONS, IMPACT, WEAR = Quantity.DRIVE_TORQUE, Quantity.REACTIONS, Quantity.IMPACT, Quantity.WEAR
DEFAULT_ITERATIONS = 100
FINER = 4  # times the vertices of the minimal model's cam


def carried(mechanism: Mechanism, minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
    """In the order of a report: shapes, physics, constraints, what is read, the solver."""
    contact = bool(mechanism.cam_contacts)
    weight = _weight(minimal) if any(mechanism.gravity) else ()
    return (*_shapes(), *weight, *_passive(), *_constraints(), *_read(), *_solver(contact, minimal))


def _shapes() -> tuple[Ingredient[MuJoCoSettings], ...]:
    return (
        extra("visual-geoms", "visual geoms", "bars, pins and blocks to be seen, which cannot collide"),
        extra(
            "touching-geoms",
            "colliding geoms in one plane",
            "the same shapes, all in the plane of motion and able to collide: links overlap where pins join them",
            IMPACT,
            group="collision",
        ),
        extra(
            "colliding-geoms",
            "colliding geoms in layers",
            "the same shapes able to collide, each link in a layer of its own: looked at in each step, never touching",
            IMPACT,
            group="collision",
        ),
    )


def _weight(minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
    return (
        Ingredient(
            "gravity",
            "gravity",
            "the weight of all links",
            with_fields(gravity=True),
            with_fields(gravity=minimal.gravity),
            needed_by=(TORQUE, REACTIONS, WEAR),
        ),
    )


def _passive() -> tuple[Ingredient[MuJoCoSettings], ...]:
    return (
        extra(
            "passive-damping",
            "damping of passive joints",
            f"{PASSIVE_DAMPING:g} N m s/rad on every hinge, {PASSIVE_DAMPING:g} N s/m on every slide, but the crank",
            TORQUE,
            REACTIONS,
        ),
        extra(
            "passive-armature",
            "armature of passive joints",
            f"{PASSIVE_ARMATURE:g} kg m^2 on every hinge, {PASSIVE_ARMATURE:g} kg on every slide, but the crank",
            TORQUE,
            REACTIONS,
        ),
    )


def _constraints() -> tuple[Ingredient[MuJoCoSettings], ...]:
    return (
        extra(
            "free-bodies",
            "links as free bodies in space",
            "links that hang on a pin have six degrees of freedom, and every pin but the crank's is held by three "
            "connects along its axis; slides stay joints, for which MuJoCo has no equality",
            REACTIONS,
            WEAR,
        ),
        extra("redundant-closures", "redundant loop closures", "every connect a second time"),
        *(
            extra(
                f"condim-{dimension}",
                f"contact dimension {dimension}",
                f"friction of the roller on the cam: {friction}, with MuJoCo's coefficients",
                TORQUE,
                REACTIONS,
                WEAR,
                group="contact dimension",
            )
            for dimension, friction in ((3, "sliding"), (4, "sliding and spinning"), (6, "sliding, spinning, rolling"))
        ),
    )


def _read() -> tuple[Ingredient[MuJoCoSettings], ...]:
    return (
        *(
            extra(
                f"sensors-{count}",
                f"{count} sensor{'s' * (count > 1)}",
                "told of the motion of the observed points, and read by nobody",
                group="sensors",
            )
            for count in (1, 8, 64)
        ),
        extra("energy", "energy flag", "potential and kinetic energy are computed in each step"),
        extra("fwdinv", "fwdinv flag", "each step is checked against the inverse dynamics"),
    )


def _solver(contact: bool, minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
    found = [
        Ingredient(
            "iterations-100",
            "100 solver iterations",
            "MuJoCo's default, of which the solver takes what it likes",
            with_fields(iterations=DEFAULT_ITERATIONS),
            with_fields(**fields_of(minimal, "iterations")),
        ),
        extra("sparse-jacobian", "sparse Jacobian", "constraints kept for large models"),
        Ingredient(
            "islands",
            "constraint islands",
            "MuJoCo's default: groups of bodies that constraints join are found in each step and solved apart",
            undressed("no-islands"),
            dressed("no-islands"),
        ),
        extra("noslip", "noslip iterations", f"{NOSLIP_ITERATIONS} passes of the solver that mends friction", WEAR),
        Ingredient(
            "multiccd",
            "multiccd flag",
            "MuJoCo's default: several contact points for each pair of flat shapes",
            undressed("no-multiccd"),
            dressed("no-multiccd"),
        ),
    ]
    if contact:
        found += [
            Ingredient(
                "rk4",
                "RK4",
                "four evaluations a step instead of one",
                with_fields(integrator="RK4"),
                with_fields(**fields_of(minimal, "integrator")),
            ),
            Ingredient(
                "fine-cam",
                f"a cam of {FINER} times the vertices",
                f"{FINER * minimal.cam_vertices} vertices instead of {minimal.cam_vertices}",
                with_fields(cam_vertices=FINER * minimal.cam_vertices),
                with_fields(**fields_of(minimal, "cam_vertices")),
                needed_by=(IMPACT, WEAR),
            ),
        ]
    return tuple(found)
