"""MJCF elements of closures, forces and loads, and the formats of all numbers in MJCF. Does not import the engine.

A cut pin is an equality `connect` of two sites. A rolling pair is a fixed tendon, a linear combination of joint
coordinates, that an equality keeps at its length of the compiled pose: exact where the pair's equation is linear.

A load acts along the length of a tendon (the distance of two points, or a rotation, which is a sum of joint
coordinates) or along the displacement of a site. A spring or damper on a tendon is the tendon's own; every other law
that is linear in length and rate is an actuator without an input, with an affine bias. The bias of a nonlinear law
comes from a callback (`model.apply_load_laws`) at every evaluation of the forces, with RK4 four times per step.
"""

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
    Sampled,
    SpeedLine,
    Steady,
    StrokePulse,
    TimePulse,
    Turn,
    Viscous,
)
from conrod.mechanism.mechanism import GROUND, Mechanism, Point, Revolute


def add_element(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    """Add a last child to an element."""
    return ET.SubElement(parent, tag, attributes)


def get_section(root: ET.Element, tag: str) -> ET.Element:
    """Return a section of the model, added if it is missing."""
    found = root.find(tag)
    return add_element(root, tag) if found is None else found


def zero_if_rounding(value: float) -> float:
    """Return 0 for a value that is 0 except for rounding, else the value."""
    return 0.0 if abs(value) < 1e-15 else value


def format_number(value: float) -> str:
    """The shortest text that reads back as the same number."""
    value = zero_if_rounding(float(value))
    texts = (f"{value:.6g}", f"{value:.15g}", repr(value))
    return next(text for text in texts if float(text) == value)


def format_numbers(values: list[float] | tuple[float, ...]) -> str:
    """Numbers separated by blanks, each exact."""
    return " ".join(format_number(v) for v in values)


def format_short(value: float) -> str:
    """A number in four digits, for values that affect only the picture."""
    # Of the rounded value: a tie in the fifth digit is not left to the last digit of a double.
    return f"{float(f'{zero_if_rounding(value):.12g}'):.4g}"


def add_closures(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Add the equalities that close all loops, and the tendons that they hold."""
    meshes = tree.mechanism.meshes
    if not tree.cuts and not meshes:
        return
    if meshes:
        tendons = add_element(root, "tendon")
        for mesh in meshes:
            tendon = add_element(tendons, "fixed", name=mesh.name)
            for branch, coefficient in zip(tree.branches, rolling_coefficients(tree, mesh), strict=True):
                if coefficient != 0.0:
                    add_element(tendon, "joint", joint=joint_name(tree, branch), coef=format_number(coefficient))
    equality = add_element(root, "equality")
    stiffness = {"solref": format_numbers(settings.solref), "solimp": format_numbers(settings.solimp)}
    for joint in tree.cuts:
        first, second = _closure_sites(joint)
        add_element(equality, "connect", name=joint.name, site1=first, site2=second, **stiffness)
    for mesh in meshes:
        add_element(equality, "tendon", name=mesh.name, tendon1=mesh.name, **stiffness)


def joint_name(tree: SpanningTree, branch: Branch) -> str:
    """Name of a branch's joint in the model; "crank" for the driven one."""
    return "crank" if branch.joint.name == tree.mechanism.driver.joint else branch.joint.name


def closure_points(body: str, tree: SpanningTree) -> list[tuple[str, Point]]:
    """Names and positions of the sites on a body that closures hold."""
    points = []
    for joint in tree.cuts:
        ends = ((joint.a, joint.point_a), (joint.b, joint.point_b))
        points += [
            (site, point) for site, (holder, point) in zip(_closure_sites(joint), ends, strict=True) if holder == body
        ]
    return points


def _closure_sites(joint: Revolute) -> tuple[str, str]:
    """Names of the two sites that a closure holds together."""
    return f"{joint.name}.{joint.a}", f"{joint.name}.{joint.b}"


# -- loads -------------------------------------------------------------------------------------------------------------


CALLBACK_LAWS = (Friction, Sampled, StrokePulse, TimePulse)  # laws that MJCF cannot say


def callback_loads(mechanism: Mechanism) -> tuple[Load, ...]:
    """Loads whose laws MJCF cannot express."""
    return tuple(load for load in mechanism.loads if isinstance(load.law, CALLBACK_LAWS))


def coordinate_offset(load: Load, tree: SpanningTree) -> float:
    """A load's coordinate minus the length that the engine has for it [m or rad].

    Joint coordinates count from the start poses; distances and places are what they are.
    """
    if not isinstance(load.along, Turn):
        return 0.0
    return float(tree.start_pose(load.along.b)[2] - tree.start_pose(load.along.a)[2])


def does_no_work(load: Load, tree: SpanningTree) -> bool:
    """Return True for a torque on a body that slides keep from rotating: it changes only reactions."""
    return isinstance(load.along, Turn) and not _rotation_terms(load.along, tree)


# -- sites ------------------------------------------------------------------------------------------------------------


def load_points(body: str, tree: SpanningTree) -> list[tuple[str, Point]]:
    """Names and positions of the sites on a body that forces and loads need."""
    mechanism, points = tree.mechanism, dict[str, Point]()
    if body == GROUND and (mechanism.forces or any(isinstance(load.along, Displacement) for load in mechanism.loads)):
        points[GROUND] = (0.0, 0.0)
    if body in mechanism.constant_forces:
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
    # Differs from a joint's site if load and joint share a name.
    """Name of a load's site on a body."""
    return f"{load.name}.load.{body}"


# -- tendons ----------------------------------------------------------------------------------------------------------


def add_load_tendons(root: ET.Element, tree: SpanningTree) -> None:
    """Add a tendon for each load along a distance or a rotation, with its spring or damper."""
    every = tree.mechanism.loads
    loads = [load for load in every if not isinstance(load.along, Displacement) and not does_no_work(load, tree)]
    if not loads:
        return
    tendons = get_section(root, "tendon")
    for load in loads:
        along = load.along
        if isinstance(along, Distance):
            tendon = add_element(tendons, "spatial", name=load.name)
            for end in (along.a, along.b):
                add_element(tendon, "site", site=_site_name(load, end))
        else:
            assert isinstance(along, Turn)
            tendon = add_element(tendons, "fixed", name=load.name)
            for branch, coefficient in _rotation_terms(along, tree):
                add_element(tendon, "joint", joint=joint_name(tree, branch), coef=format_number(coefficient))
        tendon.attrib.update(_tendon_attributes(load, tree))


def _tendon_attributes(load: Load, tree: SpanningTree) -> dict[str, str]:
    """Spring or damper attributes of a load's tendon; none if an actuator gives the force."""
    match load.law:
        case _ if isinstance(load.along, Displacement):
            return {}
        case Viscous(damping):
            return {"damping": format_number(damping)}
        # In MJCF a length of -1 means the length in the compiled pose.
        case Elastic(stiffness, rest) if rest - coordinate_offset(load, tree) != -1.0:
            return {
                "stiffness": format_number(stiffness),
                "springlength": format_number(rest - coordinate_offset(load, tree)),
            }
        case _:
            return {}


def _rotation_terms(along: Turn, tree: SpanningTree) -> list[tuple[Branch, float]]:
    """Branches and the coefficients of their coordinates in a rotation from the start pose."""
    row = rotation_coefficients(tree, along.b) - rotation_coefficients(tree, along.a)
    return [(branch, float(share)) for branch, share in zip(tree.branches, row, strict=True) if share != 0.0]


# -- actuators --------------------------------------------------------------------------------------------------------


def add_forces(root: ET.Element, tree: SpanningTree, with_program: bool) -> None:
    """Add constant forces, and loads that are no springs or dampers of tendons, as actuators without input.

    Args:
        with_program: False for a model that nothing but MuJoCo runs: laws that MJCF cannot say are left out.
    """
    mechanism = tree.mechanism
    loads = [load for load in mechanism.loads if not does_no_work(load, tree) and not _tendon_attributes(load, tree)]
    if not with_program:
        loads = [load for load in loads if not isinstance(load.law, CALLBACK_LAWS)]
    if not mechanism.forces and not loads:
        return
    actuators = add_element(root, "actuator")
    for body, force in mechanism.constant_forces.items():
        push = add_element(actuators, "general", name=f"{body}.force", site=f"{body}.centre", refsite=GROUND)
        push.set("gear", format_numbers([*force, 0.0, 0.0, 0.0, 0.0]))
        _set_bias(push, (1.0, 0.0, 0.0))
    for load in loads:
        push = add_element(actuators, "general", name=load.name)
        if isinstance(load.along, Displacement):
            push.set("site", _site_name(load, load.along.body))
            push.set("refsite", GROUND)
            way = (math.cos(load.along.direction), math.sin(load.along.direction))
            push.set("gear", format_numbers([*way, 0.0, 0.0, 0.0, 0.0]))
        else:
            push.set("tendon", load.name)
        _set_bias(push, _affine_bias(load, coordinate_offset(load, tree)))


def _set_bias(actuator: ET.Element, affine: tuple[float, float, float] | None) -> None:
    """Set force = a + b x length + c x rate from (a, b, c); None for a callback."""
    actuator.set("gainprm", "0")
    actuator.set("biastype", "user" if affine is None else "affine")
    if affine is not None:
        actuator.set("biasprm", format_numbers(affine))


def _affine_bias(load: Load, origin: float) -> tuple[float, float, float] | None:
    """Coefficients (a, b, c) of a law that is linear in length and rate, or None."""
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
