"""Translate a mechanism with settings to MJCF text. Does not import the engine.

The plane of motion is x-y and gravity lies in it, so the document's frame is the model's. A spanning tree of hinges
and slides carries the bodies; a pin that closes a loop becomes an equality `connect` between two sites.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass

from conrod.engines.cam_polygon import cam_polygon
from conrod.engines.mujoco import MuJoCoSettings
from conrod.engines.mujoco.loads import (
    add_closures,
    add_element,
    add_forces,
    add_load_tendons,
    closure_points,
    format_number,
    format_numbers,
    get_section,
    joint_name,
    load_points,
)
from conrod.engines.mujoco.model_edits import add_camera, add_link_geoms, add_viewer_settings, apply_edits
from conrod.engines.spanning_tree import Branch, SpanningTree
from conrod.mechanism.mechanism import GROUND, CamContact, Mechanism, Prismatic, Revolute


@dataclass(frozen=True)
class Presentation:
    """Parts of an exported model that are for people: header, geoms, camera, keyframe."""

    header: str
    start_rates: tuple[float, ...]  # joint rates at crank angle 0, one for each branch of the tree
    motor: bool = False  # whether the crank has a motor, whose torque is set


def mjcf_text(
    tree: SpanningTree,
    settings: MuJoCoSettings,
    model_name: str,
    dress: Presentation | None = None,
    sensors: bool = True,
) -> str:
    """MJCF text of a mechanism with settings.

    Args:
        dress: visual parts of an exported model; None for the minimal model that is run.
        sensors: False for a model that is only timed.
    """
    root = ET.Element("mujoco", model=model_name)
    if dress:
        root.append(ET.Comment(f"\n{dress.header}\n"))
    add_element(root, "compiler", angle="radian", autolimits="true")
    _add_option(root, tree.mechanism, settings)
    if dress:
        add_viewer_settings(root, tree)
    for contact in tree.mechanism.cam_contacts:
        _add_cam_mesh(root, contact, settings)
    world = add_element(root, "worldbody")
    if dress:
        add_camera(world, tree)
    _add_children(world, GROUND, tree, settings, dress is not None)
    add_closures(root, tree, settings)
    for contact in tree.mechanism.cam_contacts:
        _add_contact(root, contact, settings)
    add_load_tendons(root, tree)
    add_forces(root, tree, with_program=dress is None)
    if sensors:
        _add_sensors(root, tree.mechanism, bodies=dress is None)
    apply_edits(root, tree, settings)
    if dress and dress.motor:
        add_element(get_section(root, "actuator"), "motor", name="motor", joint="crank")
    if dress:
        keyframe = add_element(root, "keyframe")
        zero = format_numbers([0.0] * len(tree.branches))
        rates = [dress.start_rates[tree.branches.index(branch)] for branch in _branches_depth_first(tree, GROUND)]
        add_element(keyframe, "key", name="start", qpos=zero, qvel=format_numbers(rates))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


# -- engine options --------------------------------------------------------------------------------------------------


def _add_option(root: ET.Element, mechanism: Mechanism, settings: MuJoCoSettings) -> None:
    """Add the `option` element: step, integrator, solver, gravity, flags."""
    gravity = mechanism.gravity if settings.gravity else (0.0, 0.0)
    option = add_element(
        root,
        "option",
        timestep=format_number(settings.timestep),
        integrator=settings.integrator,
        solver=settings.solver,
        iterations=str(settings.iterations),
        tolerance=format_number(settings.tolerance),
        gravity=format_numbers([*gravity, 0.0]),
    )
    kept = {"autoreset": settings.autoreset, "refsafe": settings.refsafe, "contact": bool(mechanism.cam_contacts)}
    add_element(option, "flag", **{name: "disable" for name, on in kept.items() if not on})


def _branches_depth_first(tree: SpanningTree, body: str) -> list[Branch]:
    """Branches of the spanning tree below a body, depth first as MuJoCo orders joints."""
    branches = []
    for branch in tree.branches:
        if branch.parent == body:
            branches += [branch, *_branches_depth_first(tree, branch.child)]
    return branches


# -- bodies and joints -----------------------------------------------------------------------------------------------


def _add_children(element: ET.Element, body: str, tree: SpanningTree, settings: MuJoCoSettings, dressed: bool) -> None:
    """Add sites and geoms of a body, then its child bodies."""
    sites = [(observed.name, observed.point) for observed in tree.mechanism.observed if observed.body == body]
    for name, point in (*sites, *load_points(body, tree), *closure_points(body, tree)):
        add_element(element, "site", name=name, pos=format_numbers([*point, 0.0]))
    if dressed:
        add_link_geoms(element, body, tree)
    _add_contact_geoms(element, body, tree, dressed)
    for branch in tree.branches:
        if branch.parent == body:
            child = _add_body(element, branch, tree, settings)
            _add_children(child, branch.child, tree, settings, dressed)


def _add_body(element: ET.Element, branch: Branch, tree: SpanningTree, settings: MuJoCoSettings) -> ET.Element:
    """Add the body of a branch, with joint and inertia."""
    parent, child = tree.start_pose(branch.parent), tree.start_pose(branch.child)
    c, s = math.cos(parent[2]), math.sin(parent[2])
    dx, dy = child[0] - parent[0], child[1] - parent[1]
    attributes = {"name": branch.child, "pos": format_numbers([c * dx + s * dy, c * dy - s * dx, 0.0])}
    if abs(child[2] - parent[2]) > 1e-15:
        attributes["euler"] = format_numbers([0.0, 0.0, child[2] - parent[2]])
    body = add_element(element, "body", **attributes)
    _add_joint(body, branch, tree, settings)
    link = tree.mechanism.body(branch.child)
    add_element(
        body,
        "inertial",
        pos=format_numbers([*link.centre_of_gravity, 0.0]),
        mass=format_number(link.mass),
        diaginertia=format_numbers([link.inertia] * 3),
    )
    return body


def _add_joint(body: ET.Element, branch: Branch, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Add the hinge or slide of a branch; the crank's hinge has the flywheel as armature."""
    match branch.joint:
        case Revolute():
            driven = branch.joint.name == tree.mechanism.driver.joint
            joint = add_element(body, "joint", name=joint_name(tree, branch), type="hinge")
            joint.set("axis", format_numbers([0.0, 0.0, float(branch.sense)]))
            if (on_child := tree.pin_points(branch)[1]) != (0.0, 0.0):
                joint.set("pos", format_numbers([*on_child, 0.0]))
            if driven:
                joint.set("armature", format_number(settings.armature))
        case Prismatic():
            joint = add_element(body, "joint", name=branch.joint.name, type="slide")
            # MuJoCo takes the axis in the child's frame.
            turn = tree.start_pose(branch.parent)[2] - tree.start_pose(branch.child)[2]
            angle = tree.slide_direction(branch) + turn
            joint.set("axis", format_numbers([math.cos(angle), math.sin(angle), 0.0]))


# -- contact ----------------------------------------------------------------------------------------------------------


def _add_cam_mesh(root: ET.Element, contact: CamContact, settings: MuJoCoSettings) -> None:
    """Add the cam as a convex disc with a sharp rim in the plane of motion: half the vertices of a prism."""
    rim = cam_polygon(contact.profile, settings.cam_vertices).vertices
    middle = rim.mean(axis=0)
    apexes = [(*middle, side * 2.0 * contact.roller_radius) for side in (-1.0, 1.0)]
    # Nine digits are all of the single precision in which MuJoCo keeps a mesh.
    lines = [" ".join(f"{v:.9g}" for v in vertex) for vertex in [*((x, y, 0.0) for x, y in rim), *apexes]]
    add_element(get_section(root, "asset"), "mesh", name=contact.a, vertex="  ".join(lines))


def _add_contact_geoms(element: ET.Element, body: str, tree: SpanningTree, dressed: bool) -> None:
    """Add the geoms of cam and roller, which collide only with each other."""
    for contact in tree.mechanism.cam_contacts:
        looks = {"rgba": "0.75 0.6 0.35 1"} if dressed else {}
        never = {"contype": "0", "conaffinity": "0", "mass": "0"}
        if contact.a == body:
            add_element(element, "geom", name=f"{body}.profile", type="mesh", mesh=contact.a, **never, **looks)
        if contact.b == body:
            add_element(
                element,
                "geom",
                name=f"{body}.roller",
                type="sphere",
                size=format_number(contact.roller_radius),
                pos=format_numbers([*contact.roller_centre, 0.0]),
                **never,
                **looks,
            )


def _add_contact(root: ET.Element, contact: CamContact, settings: MuJoCoSettings) -> None:
    """Add the contact pair of cam and roller."""
    add_element(
        get_section(root, "contact"),
        "pair",
        name=contact.name,
        geom1=f"{contact.a}.profile",
        geom2=f"{contact.b}.roller",
        condim="1",
        solref=format_numbers(settings.contact_solref),
        solimp=format_numbers(settings.contact_solimp),
    )


# -- sensors ---------------------------------------------------------------------------------------------------------


def _add_sensors(root: ET.Element, mechanism: Mechanism, bodies: bool) -> None:
    """Add sensors of the observed points, and of the bodies' accelerations for a run."""
    sensors = add_element(root, "sensor")
    for observed in mechanism.observed:
        for kind, quantity in (("framepos", "position"), ("framelinvel", "velocity"), ("framelinacc", "acceleration")):
            name = f"{observed.name}.{quantity}"
            add_element(sensors, kind, name=name, objtype="site", objname=observed.name)
    if bodies:
        for body in mechanism.bodies:
            for kind, quantity in (("framelinacc", "acceleration"), ("frameangacc", "angular_acceleration")):
                name = f"{body.name}.{quantity}"
                add_element(sensors, kind, name=name, objtype="xbody", objname=body.name)
