"""Parts of a model that its motion does not need: geoms to look at, and named edits. Does not import the engine."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from functools import partial
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from conrod.engines.mujoco import MuJoCoSettings
from conrod.engines.mujoco.loads import add_element, format_numbers, format_short, get_section
from conrod.engines.spanning_tree import SpanningTree
from conrod.engines.variants import NO_CONTACT, NO_LOOPS
from conrod.errors import unknown_choice
from conrod.mechanism.loads import Turn
from conrod.mechanism.mechanism import GROUND, Mechanism, Mesh, Prismatic, Revolute, Rolling, pin_points

# MuJoCo refuses a bar between two pins that coincide, as on a crank whose arc is about its own axis.
MIN_BAR_LENGTH = 1e-3  # of its width

NOT_COLLIDING = {"contype": "0", "conaffinity": "0", "mass": "0", "group": "1"}


def _extent(tree: SpanningTree) -> tuple[float, float, float]:
    """Centre (x, y) and size [m] of the machine in its start pose, with room for the rotating crank."""
    points = [tree.start_pose(body.name)[:2] for body in tree.mechanism.bodies]
    for branch in tree.branches:
        if isinstance(branch.joint, Revolute):
            points.append(np.array(branch.joint.point_a) if branch.joint.a == GROUND else np.zeros(2))
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    middle = 0.5 * (low + high)
    return float(middle[0]), float(middle[1]), float(max(np.max(high - low), 0.15))


def link_width(tree: SpanningTree) -> float:
    """Radius [m] of the bars that represent links."""
    return 0.03 * _extent(tree)[2]


def add_viewer_settings(root: ET.Element, tree: SpanningTree) -> None:
    """Add sky, lighting and the region that viewers show first."""
    x, y, size = _extent(tree)
    add_element(root, "statistic", center=format_numbers([x, y, 0.0]), extent=format_short(size))
    visual = add_element(root, "visual")
    add_element(visual, "global", offwidth="1280", offheight="960")
    add_element(visual, "headlight", ambient="0.45 0.45 0.45", diffuse="0.35 0.35 0.35", specular="0 0 0")
    asset = add_element(root, "asset")
    add_element(
        asset, "texture", type="skybox", builtin="gradient", rgb1="1 1 1", rgb2="0.8 0.85 0.9", width="64", height="64"
    )


def add_camera(world: ET.Element, tree: SpanningTree) -> None:
    """Add a camera that looks at the plane of motion, and a light."""
    x, y, size = _extent(tree)
    place = " ".join(format_short(v) for v in (x, y, 2.2 * size))
    add_element(world, "camera", name="front", pos=place)
    add_element(
        world, "light", pos=place, dir="0.3 -0.3 -1", directional="true", diffuse="0.4 0.4 0.4", castshadow="false"
    )


def add_link_geoms(element: ET.Element, body: str, tree: SpanningTree) -> None:
    """Add geoms of a link that cannot collide: bars between joints, discs at pins, a block for a slider."""
    width = link_width(tree)
    pins = pin_points(tree.mechanism, body)
    if body == GROUND:
        pins = []
    for first, second in pairwise(pins):
        if math.dist(first, second) < MIN_BAR_LENGTH * width:
            continue
        ends = format_numbers([*first, 0.0, *second, 0.0])
        add_element(
            element,
            "geom",
            type="capsule",
            fromto=ends,
            size=format_short(width),
            rgba="0.35 0.5 0.65 1",
            **NOT_COLLIDING,
        )
    for joint in tree.mechanism.joints:
        if isinstance(joint, Prismatic) and joint.b == body:
            _add_slider_geom(element, joint, width, tree)
    for mesh in tree.mechanism.meshes:
        _add_wheel_geoms(element, body, mesh, width)
    for pin in pins:
        size = f"{format_short(1.3 * width)} {format_short(1.6 * width)}"
        place = format_numbers([*pin, 0.0])
        add_element(element, "geom", type="cylinder", pos=place, size=size, rgba="0.2 0.2 0.2 1", **NOT_COLLIDING)


def _add_wheel_geoms(element: ET.Element, body: str, mesh: Mesh, width: float) -> None:
    """Add a disc for each wheel of a rolling pair, with a dot that shows its rotation; no ring, no rack."""
    wheels = [(mesh.a, mesh.point_a, mesh.radius_a if isinstance(mesh, Rolling) else mesh.radius)]
    if isinstance(mesh, Rolling):
        wheels.append((mesh.b, mesh.point_b, mesh.radius_b))
    for wheel, centre, radius in wheels:
        if wheel == body and radius > 0.0 and wheel != GROUND:
            places = (
                (centre, radius, 0.5 * width),
                ((centre[0] + 0.8 * radius, centre[1]), 0.08 * radius, 0.6 * width),
            )
            for place, size, thickness in places:
                sizes, at = f"{format_short(size)} {format_short(thickness)}", format_numbers([*place, 0.0])
                add_element(
                    element, "geom", type="cylinder", pos=at, size=sizes, rgba="0.75 0.6 0.35 1", **NOT_COLLIDING
                )


def _add_slider_geom(element: ET.Element, joint: Prismatic, width: float, tree: SpanningTree) -> None:
    """Add a block for a slider; for a follower, a stem away from the cam."""
    grey = "0.6 0.6 0.6 1"
    if not any(contact.b == joint.b for contact in tree.mechanism.cam_contacts):
        size = " ".join(format_short(v * width) for v in (3.0, 3.0, 1.0))
        add_element(element, "geom", type="box", size=size, rgba=grey, **NOT_COLLIDING)
        return
    direction, reach = joint.direction - joint.angle, 10.0 * width
    tip = f"{format_short(reach * math.cos(direction))} {format_short(reach * math.sin(direction))} 0"
    add_element(
        element, "geom", type="capsule", fromto=f"0 0 0 {tip}", size=format_short(width), rgba=grey, **NOT_COLLIDING
    )


# -- edits of the element tree -----------------------------------------------------------------------------------------


Edit: TypeAlias = Callable[[ET.Element, SpanningTree, MuJoCoSettings], None]


def body_element(root: ET.Element, name: str) -> ET.Element:
    """The XML element of a body, or of the ground."""
    found = root.find("worldbody") if name == GROUND else root.find(f".//body[@name='{name}']")
    if found is None:
        raise ValueError(f"the model has no body {name!r}")
    return found


def open_loops(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Remove the closures of all loops."""
    equality = get_section(root, "equality")
    closures = [joint.name for joint in tree.cuts]
    closures += [mesh.name for mesh in tree.mechanism.meshes]
    for element in list(equality):
        if element.get("name", "").split("/")[0] in closures:
            equality.remove(element)


def duplicate_closures(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Add a second closure to every one, between the same sites."""
    equality = get_section(root, "equality")
    for element in list(equality):
        again = copy.deepcopy(element)
        again.set("name", f"{element.get('name')}/again")
        equality.append(again)


# Where a pin of free bodies is held, along its axis in link widths: bodies in space need a line, and not a point.
PIN_PLACES = {"": 0.0, "/above": 1.5, "/below": -1.5}


def free_pins(mechanism: Mechanism) -> list[Revolute]:
    """Pins that free bodies are held by: all but the driven one, whose hinge has the flywheel."""
    return [one for one in mechanism.joints if isinstance(one, Revolute) and one.name != mechanism.driver.joint]


def free_bodies(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Free every link that hangs on a pin, and hold all pins but the driven one by three connects along their axis.

    Slides stay joints, because MuJoCo has no equality that is one.
    """
    parents = {child: parent for parent in root.iter() for child in parent}
    world, pins = get_section(root, "worldbody"), free_pins(tree.mechanism)
    for branch in tree.branches:
        if branch.joint in pins:
            element = body_element(root, branch.child)
            parents[element].remove(element)
            world.append(element)
            x, y, turn = (float(value) for value in tree.start_pose(branch.child))
            element.attrib |= {"pos": format_numbers([x, y, 0.0]), "euler": format_numbers([0.0, 0.0, turn])}
            hinge = next(iter(element.iterfind("joint")))
            element.remove(hinge)
            element.insert(0, ET.Element("freejoint", name=hinge.get("name", "")))
            if branch.parent != GROUND:
                # MuJoCo lets no body collide with its parent: what may touch is the same with this edit and without it.
                contact = get_section(root, "contact")
                add_element(contact, "exclude", body1=branch.parent, body2=branch.child)
    for pin in pins:
        _hold_pin(root, pin, settings, link_width(tree))


def _hold_pin(root: ET.Element, pin: Revolute, settings: MuJoCoSettings, width: float) -> None:
    """Add the missing connects of a pin, and their sites."""
    stiffness = {"solref": format_numbers(settings.solref), "solimp": format_numbers(settings.solimp)}
    equality = get_section(root, "equality")
    for suffix, height in PIN_PLACES.items():
        sites = []
        for body, point in ((pin.a, pin.point_a), (pin.b, pin.point_b)):
            sites.append(f"{pin.name}.{body}{suffix}")
            if root.find(f".//site[@name='{sites[-1]}']") is None:
                place = format_numbers([*point, height * width])
                add_element(body_element(root, body), "site", name=sites[-1], pos=place)
        if equality.find(f"connect[@name='{pin.name}{suffix}']") is None:
            add_element(equality, "connect", name=pin.name + suffix, site1=sites[0], site2=sites[1], **stiffness)


def set_attribute(place: str, name: str, value: str, root: ET.Element, *_: object) -> None:
    """Set an attribute of all elements at an XPath, except the driven joint."""
    for element in root.iterfind(place):
        if element.get("name") != "crank":
            element.set(name, value)


# Distance of neighbouring layers of links, in link widths: more than the pins' length of 3.2.
LAYER_WIDTHS = 4.0


def add_visual_geoms(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Add the bars, pins and blocks of exported files, which cannot collide."""
    for link in tree.mechanism.bodies:
        add_link_geoms(body_element(root, link.name), link.name, tree)


def add_colliding_geoms(layer: float, root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Add the same geoms, able to collide, with each link raised `layer` link widths above the one before."""
    # Linkages are run with collisions off.
    get_section(get_section(root, "option"), "flag").attrib.pop("contact", None)
    for i, link in enumerate(tree.mechanism.bodies):
        shapes = ET.Element("body")
        add_link_geoms(shapes, link.name, tree)
        for shape in shapes:
            shape.attrib |= {"contype": "1", "conaffinity": "1"}
            _raise_geom(shape, i * (layer * link_width(tree)))
        body_element(root, link.name).extend(shapes)


def _raise_geom(shape: ET.Element, height: float) -> None:
    """Raise a geom out of the plane of motion by a height [m]."""
    for attribute in ("pos", "fromto"):
        if attribute in shape.attrib or (attribute == "pos" and "fromto" not in shape.attrib):
            values = [float(text) for text in shape.get(attribute, "0 0 0").split()]
            shape.set(attribute, format_numbers([v + height * (i % 3 == 2) for i, v in enumerate(values)]))


UNREAD_SENSORS = 64
# One after the other, at one observed point after the other.
SENSOR_KINDS = (
    "framepos",
    "framelinvel",
    "framelinacc",
    "framequat",
    "frameangvel",
    "frameangacc",
    "accelerometer",
    "gyro",
)


def add_unread_sensors(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Add 64 sensors that nobody reads, of all kinds that measure a site's motion."""
    points = tree.mechanism.observed
    for i in range(UNREAD_SENSORS):
        kind, point = SENSOR_KINDS[i % len(SENSOR_KINDS)], points[i // len(SENSOR_KINDS) % len(points)]
        # Accelerometer and gyro belong to a site, the other kinds to any object.
        of = {"objtype": "site", "objname": point.name} if kind.startswith("frame") else {"site": point.name}
        add_element(get_section(root, "sensor"), kind, name=f"unread-{i + 1}", **of)


def remove_contact(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Remove the contact pair, so that cam and roller pass through each other."""
    contacts = get_section(root, "contact")
    for pair in list(contacts.iter("pair")):
        contacts.remove(pair)


PASSIVE_JOINTS = ".//body/joint"  # tendons of rolling pairs have elements `joint` too
PASSIVE_DAMPING, PASSIVE_ARMATURE = 0.1, 0.01
NOSLIP_ITERATIONS = 5
# Evaluations; two are exact along a direction of Newton's method, as long as the set of acting constraints stays.
LINE_SEARCH_EVALUATIONS = 5

# Applied in this order: what moves a body comes first, and edits that remove a closure come before those that add one.
MODEL_EDITS: Mapping[str, Edit] = {
    "free-bodies": free_bodies,
    "open-loops": open_loops,
    "redundant-closures": duplicate_closures,
    "no-contact": remove_contact,
    "visual-geoms": add_visual_geoms,
    "touching-geoms": partial(add_colliding_geoms, 0.0),
    "colliding-geoms": partial(add_colliding_geoms, LAYER_WIDTHS),
    "sensors-64": add_unread_sensors,
    "energy": partial(set_attribute, "option/flag", "energy", "enable"),
    "fwdinv": partial(set_attribute, "option/flag", "fwdinv", "enable"),
    "sparse-jacobian": partial(set_attribute, "option", "jacobian", "sparse"),
    # MuJoCo 4.0 has these two on by default, so the edit switches them off.
    "no-islands": partial(set_attribute, "option/flag", "island", "disable"),
    "no-multiccd": partial(set_attribute, "option/flag", "multiccd", "disable"),
    "short-line-search": partial(set_attribute, "option", "ls_iterations", str(LINE_SEARCH_EVALUATIONS)),
    "noslip": partial(set_attribute, "option", "noslip_iterations", str(NOSLIP_ITERATIONS)),
    "condim-3": partial(set_attribute, "contact/pair", "condim", "3"),
    "passive-damping": partial(set_attribute, PASSIVE_JOINTS, "damping", str(PASSIVE_DAMPING)),
    "passive-armature": partial(set_attribute, PASSIVE_JOINTS, "armature", str(PASSIVE_ARMATURE)),
}
# MuJoCo does not collide a body with its parent: of links in one plane it collides only those that a closure joins.
LOOP_EDITS = ("free-bodies", "open-loops", "redundant-closures", "touching-geoms")
CONTACT_EDITS = ("no-contact", "condim-3")


def apply_edits(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Apply the edits that the settings name to a complete model.

    Raises:
        InvalidInput: a name is none of `MODEL_EDITS`, or does not apply to the machine, see `edit_refusal`.
    """
    for name in settings.dressing:
        if name not in MODEL_EDITS:
            raise unknown_choice("dressing", name, MODEL_EDITS)
    for name, edit in MODEL_EDITS.items():
        if name in settings.dressing:
            edit(root, tree, settings)


def edit_refusal(mechanism: Mechanism, settings: MuJoCoSettings) -> str | None:
    """Return which edit of the settings does not apply to the mechanism, and why, or None."""
    refused = ((name, _reason_against(name, mechanism)) for name in settings.dressing)
    return next((f"{name}: {reason}" for name, reason in refused if reason), None)


def _reason_against(edit: str, mechanism: Mechanism) -> str:
    """Reason why an edit does not apply to a mechanism; empty if it does."""
    if edit in CONTACT_EDITS and not mechanism.cam_contacts:
        return NO_CONTACT
    if edit in LOOP_EDITS and mechanism.cam_contacts:
        return NO_LOOPS
    if edit == "free-bodies":
        if mechanism.meshes:
            return "a rolling pair ties the joints of its wheels, which free bodies do not have"
        if any(isinstance(load.along, Turn) for load in mechanism.loads):
            return "a load acts on the angle of a joint, which free bodies do not have"
        return "" if free_pins(mechanism) else "no link but the crank hangs on a pin"
    return ""
