"""What a MuJoCo model may carry that its minimal model lacks. Imports no engine."""

from __future__ import annotations

from conrod.engines.ingredients import Ingredient, Quantity, by_default, extra, of_fields
from conrod.engines.mujoco.model_edits import LINE_SEARCH, NOSLIP_ITERATIONS, PASSIVE_ARMATURE, PASSIVE_DAMPING
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.mechanism.mechanism import Mechanism

TORQUE, REACTIONS, IMPACT, WEAR = Quantity.DRIVE_TORQUE, Quantity.REACTIONS, Quantity.IMPACT, Quantity.WEAR
DEFAULT_ITERATIONS = 100
FINER = 4  # times the vertices of the minimal model's cam


def carried(mechanism: Mechanism, minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
    """In the order of a report: shapes, physics, constraints, what is read, the solver."""
    weight = _weight(minimal) if any(mechanism.gravity) else ()
    contact = _of_contact(minimal) if mechanism.cam_contacts else ()
    return (*_shapes(), *weight, *_passive(), *_constraints(), *_read(), *_solver(minimal), *contact)


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
        of_fields("gravity", "gravity", "the weight of all links", minimal, {"gravity": True}, TORQUE, REACTIONS, WEAR),
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


def _solver(minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
    return (
        of_fields(
            "iterations-100",
            "100 solver iterations",
            "MuJoCo's default, of which the solver takes what it likes",
            minimal,
            {"iterations": DEFAULT_ITERATIONS},
        ),
        by_default(
            "line-search",
            "a long line search",
            f"MuJoCo's default: up to 50 evaluations along a direction of the solver instead of {LINE_SEARCH}; a "
            "tolerance of 0 takes them all",
            "short-line-search",
        ),
        extra("sparse-jacobian", "sparse Jacobian", "constraints kept for large models"),
        by_default(
            "islands",
            "constraint islands",
            "MuJoCo's default in 4.0: groups of bodies that constraints join are found in each step and solved apart",
            "no-islands",
        ),
        extra(
            "noslip",
            "noslip iterations",
            f"{NOSLIP_ITERATIONS} passes of the solver that mends friction; it tells all accelerations anew from the "
            "forces, of which hard closures have lost digits",
            WEAR,
        ),
        by_default(
            "multiccd",
            "multiccd flag",
            "MuJoCo's default in 4.0: several contact points for each pair of flat shapes",
            "no-multiccd",
        ),
    )


def _of_contact(minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
    vertices = FINER * minimal.cam_vertices
    return (
        of_fields("rk4", "RK4", "four evaluations a step instead of one", minimal, {"integrator": "RK4"}),
        of_fields(
            "fine-cam",
            f"a cam of {FINER} times the vertices",
            f"{vertices} vertices instead of {minimal.cam_vertices}",
            minimal,
            {"cam_vertices": vertices},
            IMPACT,
            WEAR,
        ),
    )
