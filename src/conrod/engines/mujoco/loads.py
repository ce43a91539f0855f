"""Closures, forces and loads of a tree as MJCF, with the elements and numbers that all of it is written with.

Imports no engine.
A cut pin is an equality `connect` of two sites. A rolling pair is a fixed tendon, a linear combination of joint
coordinates, that an equality keeps at its length of the compiled pose, which is exact: where a pair's equation is
linear the engine has it exactly.

A load acts along the length of a tendon (the distance of two points; a turn, which is a sum of joint coordinates) or
along the way of a site. A spring or damper on a tendon is the tendon's own; every other law that is linear in the way
and its rate is an actuator without an input, whose bias is affine in both. A law that is not linear is an actuator
whose bias a program gives (`load_laws`), at every evaluation of the forces: with RK4 four times a step."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

from conrod.engines.mujoco import MuJoCoSettings
from conrod.engines.spanning_tree import Branch, SpanningTree, rolling_coefficients, rotation_coefficients
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
from conrod.mechanism.mechanism import GROUND, Mechanism, Point, Revolute


def add(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    """A new last child of an element."""
    return ET.SubElement(parent, tag, attributes)


def section(root: ET.Element, tag: str) -> ET.Element:
    """A section of the model, made where it is missing."""
    found = root.find(tag)
    return add(root, tag) if found is None else found


def clean(value: float) -> float:
    """Zero for what is zero but for rounding."""
    return 0.0 if abs(value) < 1e-15 else value


def number(value: float) -> str:
    """The shortest text that reads back as the same number."""
    value = clean(float(value))
    texts = (f"{value:.6g}", f"{value:.15g}", repr(value))
    return next(text for text in texts if float(text) == value)


def numbers(values: list[float] | tuple[float, ...]) -> str:
    """Numbers separated by blanks, each exact."""
    return " ".join(number(v) for v in values)


def short(value: float) -> str:
    """Four digits: enough for what is only looked at."""
    return f"{clean(value):.4g}"


def add_closures(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Equalities of all loops, with the tendons that they hold."""
    meshes = tree.mechanism.meshes
    if not tree.cuts and not meshes:
        return
    if meshes:
        tendons = add(root, "tendon")
        for mesh in meshes:
            tendon = add(tendons, "fixed", name=mesh.name)
            for branch, coefficient in zip(tree.branches, rolling_coefficients(tree, mesh), strict=True):
                if coefficient != 0.0:
                    add(tendon, "joint", joint=joint_name(tree, branch), coef=number(coefficient))
    equality = add(root, "equality")
    stiffness = {"solref": numbers(settings.solref), "solimp": numbers(settings.solimp)}
    for joint in tree.cuts:
        first, second = _sites(joint)
        add(equality, "connect", name=joint.name, site1=first, site2=second, **stiffness)
    for mesh in meshes:
        add(equality, "tendon", name=mesh.name, tendon1=mesh.name, **stiffness)


def joint_name(tree: SpanningTree, branch: Branch) -> str:
    """Name of a branch's joint in the model: the driven one is the crank."""
    return "crank" if branch.joint.name == tree.mechanism.driver.joint else branch.joint.name


def closure_points(body: str, tree: SpanningTree) -> list[tuple[str, Point]]:
    """Names and places of the sites of a body that closures hold."""
    points = []
    for joint in tree.cuts:
        ends = ((joint.a, joint.point_a), (joint.b, joint.point_b))
        points += [(site, point) for site, (holder, point) in zip(_sites(joint), ends, strict=True) if holder == body]
    return points


def _sites(joint: Revolute) -> tuple[str, str]:
    """Names of the two sites that a closure holds."""
    return f"{joint.name}.{joint.a}", f"{joint.name}.{joint.b}"


# -- loads -------------------------------------------------------------------------------------------------------------


BY_PROGRAM = (Friction, StrokePulse, TimePulse)  # laws that MJCF cannot say


def by_program(mechanism: Mechanism) -> tuple[Load, ...]:
    """The loads whose laws MJCF cannot say."""
    return tuple(load for load in mechanism.loads if isinstance(load.law, BY_PROGRAM))


def origin_of(load: Load, tree: SpanningTree) -> float:
    """Difference between a load's coordinate and the length that the engine has of it [m or rad].

    Joint coordinates count from the start poses; distances and places are what they are.
    """
    if not isinstance(load.along, Turn):
        return 0.0
    return float(tree.start_pose(load.along.b)[2] - tree.start_pose(load.along.a)[2])


def moves_nothing(load: Load, tree: SpanningTree) -> bool:
    """True for a torque on a body that slides hold: it does no work, and changes reactions alone."""
    return isinstance(load.along, Turn) and not _turn_row(load.along, tree)


# -- sites ------------------------------------------------------------------------------------------------------------


def load_points(body: str, tree: SpanningTree) -> list[tuple[str, Point]]:
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


def add_load_tendons(root: ET.Element, tree: SpanningTree) -> None:
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


def _tendons_own(load: Load, tree: SpanningTree) -> dict[str, str]:
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


def _turn_row(along: Turn, tree: SpanningTree) -> list[tuple[Branch, float]]:
    """Joints whose coordinates, times these numbers, give the turn from the start poses on."""
    row = rotation_coefficients(tree, along.b) - rotation_coefficients(tree, along.a)
    return [(branch, float(share)) for branch, share in zip(tree.branches, row, strict=True) if share != 0.0]


# -- actuators --------------------------------------------------------------------------------------------------------


def add_forces(root: ET.Element, tree: SpanningTree, with_program: bool) -> None:
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
