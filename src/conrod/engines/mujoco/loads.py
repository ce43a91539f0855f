"""Constant forces and loads of a mechanism, as MJCF. Imports no engine.

A load acts along the length of a tendon (the distance of two points; a turn, which is a sum of joint coordinates) or
along the way of a site. A spring or damper on a tendon is the tendon's own; every other law that is linear in the way
and its rate is an actuator without an input, whose bias is affine in both. A law that is not linear is an actuator
whose bias a program gives (`load_laws`), at every evaluation of the forces: with RK4 four times a step.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

from conrod.engines.mujoco.closures import add, joint_name, number, numbers, section
from conrod.engines.tree import Branch, Tree, turn_row
from conrod.mechanism.loads import (
    Displacement,
    Distance,
    Elastic,
    Friction,
    Load,
    SpeedLine,
    Steady,
    StrokePulse,
    TimePulse,
    Turn,
    Viscous,
)
from conrod.mechanism.mechanism import GROUND, Mechanism, Point

BY_PROGRAM = (Friction, StrokePulse, TimePulse)  # laws that MJCF cannot say


def by_program(mechanism: Mechanism) -> tuple[Load, ...]:
    """The loads whose laws MJCF cannot say."""
    return tuple(load for load in mechanism.loads if isinstance(load.law, BY_PROGRAM))


def origin_of(load: Load, tree: Tree) -> float:
    """Difference between a load's coordinate and the length that the engine has of it [m or rad].

    Joint coordinates count from the start poses; distances and places are what they are.
    """
    if not isinstance(load.along, Turn):
        return 0.0
    return float(tree.start_pose(load.along.b)[2] - tree.start_pose(load.along.a)[2])


def moves_nothing(load: Load, tree: Tree) -> bool:
    """True for a torque on a body that slides hold: it does no work, and changes reactions alone."""
    return isinstance(load.along, Turn) and not _turn_row(load.along, tree)


# -- sites ------------------------------------------------------------------------------------------------------------


def load_points(body: str, tree: Tree) -> list[tuple[str, Point]]:
    """Names and places of the sites of a body that forces and loads need."""
    mechanism, points = tree.mechanism, dict[str, Point]()
    if body == GROUND and (mechanism.forces or any(isinstance(load.along, Displacement) for load in mechanism.loads)):
        points[GROUND] = (0.0, 0.0)
    if body in mechanism.pushes:
        points[f"{body}.centre"] = mechanism.body(body).centre_of_gravity
    for load in mechanism.loads:
        match load.along:
            case Distance() as along:
                ends = ((along.a, along.point_a), (along.b, along.point_b))
                points |= {_site_name(load, end): point for end, point in ends if end == body}
            case Displacement() as along if along.body == body:
                points[_site_name(load, body)] = along.point
    return list(points.items())


def _site_name(load: Load, body: str) -> str:
    # Not that of a joint's site, should the two have one name.
    return f"{load.name}.load.{body}"


# -- tendons ----------------------------------------------------------------------------------------------------------


def add_load_tendons(root: ET.Element, tree: Tree) -> None:
    """A tendon for each load along a distance or a turn, with its spring or damper."""
    every = tree.mechanism.loads
    loads = [load for load in every if not isinstance(load.along, Displacement) and not moves_nothing(load, tree)]
    if not loads:
        return
    tendons = section(root, "tendon")
    for load in loads:
        along = load.along
        if isinstance(along, Distance):
            tendon = add(tendons, "spatial", name=load.name)
            for end in (along.a, along.b):
                add(tendon, "site", site=_site_name(load, end))
        else:
            assert isinstance(along, Turn)
            tendon = add(tendons, "fixed", name=load.name)
            for branch, coefficient in _turn_row(along, tree):
                add(tendon, "joint", joint=joint_name(tree, branch), coef=number(coefficient))
        tendon.attrib.update(_tendons_own(load, tree))


def _tendons_own(load: Load, tree: Tree) -> dict[str, str]:
    """Spring or damper of a load's tendon; none where an actuator has to give the force."""
    match load.law:
        case _ if isinstance(load.along, Displacement):
            return {}
        case Viscous(damping):
            return {"damping": number(damping)}
        # A length of -1 stands in MJCF for the one of the compiled pose.
        case Elastic(stiffness, rest) if rest - origin_of(load, tree) != -1.0:
            return {"stiffness": number(stiffness), "springlength": number(rest - origin_of(load, tree))}
        case _:
            return {}


def _turn_row(along: Turn, tree: Tree) -> list[tuple[Branch, float]]:
    """Joints whose coordinates, times these numbers, give the turn from the start poses on."""
    row = turn_row(tree, along.b) - turn_row(tree, along.a)
    return [(branch, float(share)) for branch, share in zip(tree.branches, row, strict=True) if share != 0.0]


# -- actuators --------------------------------------------------------------------------------------------------------


def add_forces(root: ET.Element, tree: Tree, with_program: bool) -> None:
    """Constant forces, and the loads that are no springs or dampers of tendons, as actuators without an input.

    Args:
        with_program: False for a model that nothing but MuJoCo runs: laws that MJCF cannot say are left out.
    """
    mechanism = tree.mechanism
    loads = [load for load in mechanism.loads if not moves_nothing(load, tree) and not _tendons_own(load, tree)]
    if not with_program:
        loads = [load for load in loads if not isinstance(load.law, BY_PROGRAM)]
    if not mechanism.forces and not loads:
        return
    actuators = add(root, "actuator")
    for body, force in mechanism.pushes.items():
        push = add(actuators, "general", name=f"{body}.force", site=f"{body}.centre", refsite=GROUND)
        push.set("gear", numbers([*force, 0.0, 0.0, 0.0, 0.0]))
        _set_bias(push, (1.0, 0.0, 0.0))
    for load in loads:
        push = add(actuators, "general", name=load.name)
        if isinstance(load.along, Displacement):
            push.set("site", _site_name(load, load.along.body))
            push.set("refsite", GROUND)
            way = (math.cos(load.along.direction), math.sin(load.along.direction))
            push.set("gear", numbers([*way, 0.0, 0.0, 0.0, 0.0]))
        else:
            push.set("tendon", load.name)
        _set_bias(push, _affine(load, origin_of(load, tree)))


def _set_bias(actuator: ET.Element, affine: tuple[float, float, float] | None) -> None:
    """Force = first + second x length + third x rate of the length; None where a program gives it."""
    actuator.set("gainprm", "0")
    actuator.set("biastype", "user" if affine is None else "affine")
    if affine is not None:
        actuator.set("biasprm", numbers(affine))


def _affine(load: Load, origin: float) -> tuple[float, float, float] | None:
    match load.law:
        case Elastic(stiffness, rest):
            return stiffness * (rest - origin), -stiffness, 0.0
        case Viscous(damping):
            return 0.0, 0.0, -damping
        case Steady(size):
            return size, 0.0, 0.0
        case SpeedLine(size, idle):
            return size, 0.0, -size / idle
        case _:
            return None
