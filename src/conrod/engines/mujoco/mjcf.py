"""Mechanism -> MJCF text. Imports no engine.

The plane of motion is x-y and gravity lies in it, so the document's frame is the model's. A spanning tree of hinges
and slides carries the bodies; a pin that closes a loop becomes an equality `connect` between two sites.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from conrod.engines.cam_polygon import cam_polygon
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import Branch, Tree
from conrod.mechanism import GROUND, CamContact, Mechanism, Point, Prismatic, Revolute


@dataclass(frozen=True)
class Dress:
    """What a model carries for people, and a run does not: header, geoms, camera, keyframe."""

    header: str
    start_rates: tuple[float, ...]  # joint rates at crank angle 0, one for each branch of the tree


def mjcf(tree: Tree, settings: MuJoCoSettings, model_name: str, dress: Dress | None = None) -> str:
    """MJCF text of a mechanism.

    Args:
        dress: None for the minimal model that is run; else the model to reuse and to look at.
    """
    root = ET.Element("mujoco", model=model_name)
    if dress:
        root.append(ET.Comment(f"\n{dress.header}\n"))
    _child(root, "compiler", angle="radian", autolimits="true")
    _add_option(root, tree.mechanism, settings)
    if dress:
        _add_looks(root, tree)
    for contact in tree.mechanism.cam_contacts:
        _add_cam_mesh(root, contact, settings)
    world = _child(root, "worldbody")
    if dress:
        _add_camera(world, tree)
    _add_children(world, GROUND, tree, settings, dress is not None)
    _add_closures(root, tree, settings)
    for contact in tree.mechanism.cam_contacts:
        _add_contact(root, contact, settings)
    _add_forces(root, tree.mechanism)
    _add_sensors(root, tree.mechanism, bodies=dress is None)
    if dress:
        keyframe = _child(root, "keyframe")
        zero = _numbers([0.0] * len(tree.branches))
        rates = [dress.start_rates[tree.branches.index(branch)] for branch in _depth_first(tree, GROUND)]
        _child(keyframe, "key", name="start", qpos=zero, qvel=_numbers(rates))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def closure_sites(joint: Revolute) -> tuple[str, str]:
    """Names of the two sites that a closing pin holds together."""
    return f"{joint.name}.{joint.a}", f"{joint.name}.{joint.b}"


# -- engine options --------------------------------------------------------------------------------------------------


def _add_option(root: ET.Element, mechanism: Mechanism, settings: MuJoCoSettings) -> None:
    gravity = mechanism.gravity if settings.gravity else (0.0, 0.0)
    option = _child(
        root,
        "option",
        timestep=_number(settings.timestep),
        integrator=settings.integrator,
        solver=settings.solver,
        iterations=str(settings.iterations),
        tolerance=_number(settings.tolerance),
        gravity=_numbers([*gravity, 0.0]),
    )
    flags = {} if settings.autoreset else {"autoreset": "disable"}
    if not mechanism.cam_contacts:
        flags["contact"] = "disable"
    _child(option, "flag", **flags)


def _depth_first(tree: Tree, body: str) -> list[Branch]:
    """Branches in the order of MuJoCo's joints: that of the text."""
    branches = []
    for branch in tree.branches:
        if branch.parent == body:
            branches += [branch, *_depth_first(tree, branch.child)]
    return branches


# -- bodies and joints -----------------------------------------------------------------------------------------------


def _add_children(element: ET.Element, body: str, tree: Tree, settings: MuJoCoSettings, dressed: bool) -> None:
    """Sites and looks of a body, then its children."""
    _add_sites(element, body, tree)
    if dressed:
        _add_link_geoms(element, body, tree)
    _add_contact_geoms(element, body, tree, dressed)
    for branch in tree.branches:
        if branch.parent == body:
            child = _add_body(element, branch, tree, settings)
            _add_children(child, branch.child, tree, settings, dressed)


def _add_body(element: ET.Element, branch: Branch, tree: Tree, settings: MuJoCoSettings) -> ET.Element:
    parent, child = tree.start_pose(branch.parent), tree.start_pose(branch.child)
    c, s = math.cos(parent[2]), math.sin(parent[2])
    dx, dy = child[0] - parent[0], child[1] - parent[1]
    attributes = {"name": branch.child, "pos": _numbers([c * dx + s * dy, c * dy - s * dx, 0.0])}
    if abs(child[2] - parent[2]) > 1e-15:
        attributes["euler"] = _numbers([0.0, 0.0, child[2] - parent[2]])
    body = _child(element, "body", **attributes)
    _add_joint(body, branch, tree, settings)
    link = tree.mechanism.body(branch.child)
    _child(
        body,
        "inertial",
        pos=_numbers([*link.centre_of_gravity, 0.0]),
        mass=_number(link.mass),
        diaginertia=_numbers([link.inertia] * 3),
    )
    return body


def _add_joint(body: ET.Element, branch: Branch, tree: Tree, settings: MuJoCoSettings) -> None:
    match branch.joint:
        case Revolute():
            driven = branch.joint.name == tree.mechanism.driver.joint
            joint = _child(body, "joint", name="crank" if driven else branch.joint.name, type="hinge")
            joint.set("axis", _numbers([0.0, 0.0, float(branch.sense)]))
            if (on_child := tree.pin_points(branch)[1]) != (0.0, 0.0):
                joint.set("pos", _numbers([*on_child, 0.0]))
            if driven:
                joint.set("armature", _number(settings.armature))
        case Prismatic():
            joint = _child(body, "joint", name=branch.joint.name, type="slide")
            # MuJoCo wants the axis in the child's frame.
            turn = tree.start_pose(branch.parent)[2] - tree.start_pose(branch.child)[2]
            angle = tree.slide_direction(branch) + turn
            joint.set("axis", _numbers([_clean(math.cos(angle)), _clean(math.sin(angle)), 0.0]))


def _add_sites(element: ET.Element, body: str, tree: Tree) -> None:
    for observed in tree.mechanism.observed:
        if observed.body == body:
            _add_site(element, observed.name, observed.point)
    for force in tree.mechanism.forces:
        if body == GROUND and element.find(f"site[@name='{GROUND}']") is None:
            _add_site(element, GROUND, (0.0, 0.0))
        if body == force.body:
            _add_site(element, f"{body}.centre", tree.mechanism.body(body).centre_of_gravity)
    for joint in tree.cuts:
        for name, holder, point in zip(
            closure_sites(joint), (joint.a, joint.b), (joint.point_a, joint.point_b), strict=True
        ):
            if holder == body:
                _add_site(element, name, point)


def _add_site(element: ET.Element, name: str, point: Point) -> None:
    _child(element, "site", name=name, pos=_numbers([*point, 0.0]))


# -- closures and contact --------------------------------------------------------------------------------------------


def _add_closures(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    if not tree.cuts:
        return
    equality = _child(root, "equality")
    for joint in tree.cuts:
        first, second = closure_sites(joint)
        _child(
            equality,
            "connect",
            name=joint.name,
            site1=first,
            site2=second,
            solref=_numbers(settings.solref),
            solimp=_numbers(settings.solimp),
        )


def _add_cam_mesh(root: ET.Element, contact: CamContact, settings: MuJoCoSettings) -> None:
    """The cam as a convex disc with a sharp rim in the plane of motion: as exact as a prism, with half the vertices."""
    asset = root.find("asset")
    asset = _child(root, "asset") if asset is None else asset
    rim = cam_polygon(contact.profile, settings.cam_vertices).vertices
    middle = rim.mean(axis=0)
    apexes = [(*middle, side * 2.0 * contact.roller_radius) for side in (-1.0, 1.0)]
    # Nine digits are all of the single precision in which MuJoCo keeps a mesh.
    lines = [" ".join(f"{v:.9g}" for v in vertex) for vertex in [*((x, y, 0.0) for x, y in rim), *apexes]]
    _child(asset, "mesh", name=contact.a, vertex="  ".join(lines))


def _add_contact_geoms(element: ET.Element, body: str, tree: Tree, dressed: bool) -> None:
    """Cam and roller, the only shapes that collide, and with each other alone."""
    for contact in tree.mechanism.cam_contacts:
        looks = {"rgba": "0.75 0.6 0.35 1"} if dressed else {}
        never = {"contype": "0", "conaffinity": "0", "mass": "0"}
        if contact.a == body:
            _child(element, "geom", name=f"{body}.profile", type="mesh", mesh=contact.a, **never, **looks)
        if contact.b == body:
            _child(
                element,
                "geom",
                name=f"{body}.roller",
                type="sphere",
                size=_number(contact.roller_radius),
                pos=_numbers([*contact.roller_centre, 0.0]),
                **never,
                **looks,
            )


def _add_contact(root: ET.Element, contact: CamContact, settings: MuJoCoSettings) -> None:
    contacts = root.find("contact")
    contacts = _child(root, "contact") if contacts is None else contacts
    _child(
        contacts,
        "pair",
        name=contact.name,
        geom1=f"{contact.a}.profile",
        geom2=f"{contact.b}.roller",
        condim="1",
        solref=_numbers(settings.contact_solref),
        solimp=_numbers(settings.contact_solimp),
    )


def _add_forces(root: ET.Element, mechanism: Mechanism) -> None:
    """Constant forces as actuators without an input: a site is pushed along directions of a site of the ground."""
    if not mechanism.forces:
        return
    actuators = _child(root, "actuator")
    for force in mechanism.forces:
        _child(
            actuators,
            "general",
            name=f"{force.body}.force",
            site=f"{force.body}.centre",
            refsite=GROUND,
            gear=_numbers([*force.force, 0.0, 0.0, 0.0, 0.0]),
            gainprm="0",
            biastype="affine",
            biasprm="1 0 0",
        )


# -- sensors ---------------------------------------------------------------------------------------------------------


def _add_sensors(root: ET.Element, mechanism: Mechanism, bodies: bool) -> None:
    """Motion of the observed points; for a run also the accelerations of the bodies."""
    sensors = _child(root, "sensor")
    for observed in mechanism.observed:
        for kind, quantity in (("framepos", "position"), ("framelinvel", "velocity"), ("framelinacc", "acceleration")):
            name = f"{observed.name}.{quantity}"
            _child(sensors, kind, name=name, objtype="site", objname=observed.name)
    if bodies:
        for body in mechanism.bodies:
            for kind, quantity in (("framelinacc", "acceleration"), ("frameangacc", "angular_acceleration")):
                name = f"{body.name}.{quantity}"
                _child(sensors, kind, name=name, objtype="xbody", objname=body.name)


# -- looks -----------------------------------------------------------------------------------------------------------

SEEN_ONLY = {"contype": "0", "conaffinity": "0", "mass": "0", "group": "1"}


def _extent(tree: Tree) -> tuple[float, float, float]:
    """Middle and size of the machine in its start pose, with room for the turning crank."""
    points = [tree.start_pose(body.name)[:2] for body in tree.mechanism.bodies]
    for branch in tree.branches:
        if isinstance(branch.joint, Revolute):
            points.append(np.array(branch.joint.point_a) if branch.joint.a == GROUND else np.zeros(2))
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    middle = 0.5 * (low + high)
    return float(middle[0]), float(middle[1]), float(max(np.max(high - low), 0.15))


def _add_looks(root: ET.Element, tree: Tree) -> None:
    x, y, size = _extent(tree)
    _child(root, "statistic", center=_numbers([x, y, 0.0]), extent=_short(size))
    visual = _child(root, "visual")
    _child(visual, "global", offwidth="1280", offheight="960")
    _child(visual, "headlight", ambient="0.45 0.45 0.45", diffuse="0.35 0.35 0.35", specular="0 0 0")
    asset = _child(root, "asset")
    _child(
        asset, "texture", type="skybox", builtin="gradient", rgb1="1 1 1", rgb2="0.8 0.85 0.9", width="64", height="64"
    )


def _add_camera(world: ET.Element, tree: Tree) -> None:
    x, y, size = _extent(tree)
    place = " ".join(_short(v) for v in (x, y, 2.2 * size))
    _child(world, "camera", name="front", pos=place)
    _child(world, "light", pos=place, dir="0.3 -0.3 -1", directional="true", diffuse="0.4 0.4 0.4", castshadow="false")


def _add_link_geoms(element: ET.Element, body: str, tree: Tree) -> None:
    """A bar between the joints of a link, a disc at every pin, a block for a slider. None of them can collide."""
    width = 0.03 * _extent(tree)[2]
    pins = _pins(body, tree.mechanism)
    if body == GROUND:
        pins = []
    for first, second in pairwise(pins):
        ends = _numbers([*first, 0.0, *second, 0.0])
        _child(element, "geom", type="capsule", fromto=ends, size=_short(width), rgba="0.35 0.5 0.65 1", **SEEN_ONLY)
    for joint in tree.mechanism.joints:
        if isinstance(joint, Prismatic) and joint.b == body:
            _add_slider_geom(element, joint, width, tree)
    for pin in pins:
        size = f"{_short(1.3 * width)} {_short(1.6 * width)}"
        place = _numbers([*pin, 0.0])
        _child(element, "geom", type="cylinder", pos=place, size=size, rgba="0.2 0.2 0.2 1", **SEEN_ONLY)


def _add_slider_geom(element: ET.Element, joint: Prismatic, width: float, tree: Tree) -> None:
    """A block; for a follower a stem, away from the cam."""
    grey = "0.6 0.6 0.6 1"
    if not any(contact.b == joint.b for contact in tree.mechanism.cam_contacts):
        size = " ".join(_short(v * width) for v in (3.0, 3.0, 1.0))
        _child(element, "geom", type="box", size=size, rgba=grey, **SEEN_ONLY)
        return
    direction, reach = joint.direction - joint.angle, 10.0 * width
    tip = f"{_short(reach * math.cos(direction))} {_short(reach * math.sin(direction))} 0"
    _child(element, "geom", type="capsule", fromto=f"0 0 0 {tip}", size=_short(width), rgba=grey, **SEEN_ONLY)


def _pins(body: str, mechanism: Mechanism) -> list[Point]:
    """Places of the pins on a body, in its own frame."""
    pins = []
    for joint in mechanism.joints:
        if isinstance(joint, Revolute):
            pins += [p for holder, p in ((joint.a, joint.point_a), (joint.b, joint.point_b)) if holder == body]
    return pins


def _child(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    """`SubElement`, for attributes that are put together."""
    return ET.SubElement(parent, tag, attributes)


# -- numbers ---------------------------------------------------------------------------------------------------------


def _clean(value: float) -> float:
    """Zero for what is zero but for rounding."""
    return 0.0 if abs(value) < 1e-15 else value


def _number(value: float) -> str:
    """The shortest text that reads back as the same number."""
    value = _clean(float(value))
    short = f"{value:.15g}"
    return short if float(short) == value else repr(value)


def _numbers(values: list[float] | tuple[float, ...]) -> str:
    return " ".join(_number(v) for v in values)


def _short(value: float) -> str:
    return f"{_clean(value):.4g}"
