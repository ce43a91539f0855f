"""Parts of a model beside what its motion needs: parts for the eye, and edits by name. Imports no engine."""

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
from conrod.engines.mujoco.loads import add, numbers, section, short
from conrod.engines.spanning_tree import SpanningTree
from conrod.errors import unknown_choice
from conrod.mechanism.mechanism import GROUND, Mechanism, Mesh, Prismatic, Revolute, Rolling, pins_of

# MuJoCo refuses a bar between two pins of one place, as a crank has whose arc is about its own axis.
LEAST_BAR = 1e-3  # of its width

SEEN_ONLY = {"contype": "0", "conaffinity": "0", "mass": "0", "group": "1"}


def _extent(tree: SpanningTree) -> tuple[float, float, float]:
    """Middle and size of the machine in its start pose, with room for the turning crank."""
    points = [tree.start_pose(body.name)[:2] for body in tree.mechanism.bodies]
    for branch in tree.branches:
        if isinstance(branch.joint, Revolute):
            points.append(np.array(branch.joint.point_a) if branch.joint.a == GROUND else np.zeros(2))
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    middle = 0.5 * (low + high)
    return float(middle[0]), float(middle[1]), float(max(np.max(high - low), 0.15))


def link_width(tree: SpanningTree) -> float:
    """Radius of the bars that links are drawn with [m]."""
    return 0.03 * _extent(tree)[2]


def add_looks(root: ET.Element, tree: SpanningTree) -> None:
    """Sky, lighting and the part of space that viewers start from."""
    x, y, size = _extent(tree)
    add(root, "statistic", center=numbers([x, y, 0.0]), extent=short(size))
    visual = add(root, "visual")
    add(visual, "global", offwidth="1280", offheight="960")
    add(visual, "headlight", ambient="0.45 0.45 0.45", diffuse="0.35 0.35 0.35", specular="0 0 0")
    asset = add(root, "asset")
    add(asset, "texture", type="skybox", builtin="gradient", rgb1="1 1 1", rgb2="0.8 0.85 0.9", width="64", height="64")


def add_camera(world: ET.Element, tree: SpanningTree) -> None:
    """A camera that sees the plane of motion, and a light."""
    x, y, size = _extent(tree)
    place = " ".join(short(v) for v in (x, y, 2.2 * size))
    add(world, "camera", name="front", pos=place)
    add(world, "light", pos=place, dir="0.3 -0.3 -1", directional="true", diffuse="0.4 0.4 0.4", castshadow="false")


def add_link_geoms(element: ET.Element, body: str, tree: SpanningTree) -> None:
    """A bar between the joints of a link, a disc at every pin, a block for a slider. None of them can collide."""
    width = link_width(tree)
    pins = pins_of(tree.mechanism, body)
    if body == GROUND:
        pins = []
    for first, second in pairwise(pins):
        if math.dist(first, second) < LEAST_BAR * width:
            continue
        ends = numbers([*first, 0.0, *second, 0.0])
        add(element, "geom", type="capsule", fromto=ends, size=short(width), rgba="0.35 0.5 0.65 1", **SEEN_ONLY)
    for joint in tree.mechanism.joints:
        if isinstance(joint, Prismatic) and joint.b == body:
            _add_slider_geom(element, joint, width, tree)
    for mesh in tree.mechanism.meshes:
        _add_wheel_geoms(element, body, mesh, width)
    for pin in pins:
        size = f"{short(1.3 * width)} {short(1.6 * width)}"
        place = numbers([*pin, 0.0])
        add(element, "geom", type="cylinder", pos=place, size=size, rgba="0.2 0.2 0.2 1", **SEEN_ONLY)


def _add_wheel_geoms(element: ET.Element, body: str, mesh: Mesh, width: float) -> None:
    """A disc for each wheel of a rolling pair, with a dot that shows its turn; a ring and a rack stay unseen."""
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
                sizes, at = f"{short(size)} {short(thickness)}", numbers([*place, 0.0])
                add(element, "geom", type="cylinder", pos=at, size=sizes, rgba="0.75 0.6 0.35 1", **SEEN_ONLY)


def _add_slider_geom(element: ET.Element, joint: Prismatic, width: float, tree: SpanningTree) -> None:
    """A block; for a follower a stem, away from the cam."""
    grey = "0.6 0.6 0.6 1"
    if not any(contact.b == joint.b for contact in tree.mechanism.cam_contacts):
        size = " ".join(short(v * width) for v in (3.0, 3.0, 1.0))
        add(element, "geom", type="box", size=size, rgba=grey, **SEEN_ONLY)
        return
    direction, reach = joint.direction - joint.angle, 10.0 * width
    tip = f"{short(reach * math.cos(direction))} {short(reach * math.sin(direction))} 0"
    add(element, "geom", type="capsule", fromto=f"0 0 0 {tip}", size=short(width), rgba=grey, **SEEN_ONLY)


# -- edits of the element tree -----------------------------------------------------------------------------------------


Edit: TypeAlias = Callable[[ET.Element, SpanningTree, MuJoCoSettings], None]


def body_element(root: ET.Element, name: str) -> ET.Element:
    """The element of a body, or of the ground."""
    found = root.find("worldbody") if name == GROUND else root.find(f".//body[@name='{name}']")
    if found is None:
        raise ValueError(f"the model has no body {name!r}")
    return found


def open_loops(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Without what closes the loops."""
    equality = section(root, "equality")
    closures = [joint.name for joint in tree.cuts]
    closures += [mesh.name for mesh in tree.mechanism.meshes]
    for element in list(equality):
        if element.get("name", "").split("/")[0] in closures:
            equality.remove(element)


def redundant_closures(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Every closure once more, of the same sites."""
    equality = section(root, "equality")
    for element in list(equality):
        again = copy.deepcopy(element)
        again.set("name", f"{element.get('name')}/again")
        equality.append(again)


def attribute(place: str, name: str, value: str, root: ET.Element, *_: object) -> None:
    """An attribute of all elements at a place of the model but the driven joint; options and flags are always there."""
    for element in root.iterfind(place):
        if element.get("name") != "crank":
            element.set(name, value)


# Of the layers that links lie in, in widths of a link: more than the pins' length of 3.2.
LAYER = 4.0


def visual_geoms(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Bars, pins and blocks as the exported files have them; they cannot collide."""
    for link in tree.mechanism.bodies:
        add_link_geoms(body_element(root, link.name), link.name, tree)


def colliding(layer: float, root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """The same shapes, able to collide, each link in a layer of its own, so many widths of a link from the next."""
    # Linkages are run with collisions off.
    section(section(root, "option"), "flag").attrib.pop("contact", None)
    for i, link in enumerate(tree.mechanism.bodies):
        shapes = ET.Element("body")
        add_link_geoms(shapes, link.name, tree)
        for shape in shapes:
            shape.attrib |= {"contype": "1", "conaffinity": "1"}
            _lift(shape, i * (layer * link_width(tree)))
        body_element(root, link.name).extend(shapes)


def _lift(shape: ET.Element, height: float) -> None:
    """Raise a shape out of the plane of motion by so much [m]."""
    for attribute in ("pos", "fromto"):
        if attribute in shape.attrib or (attribute == "pos" and "fromto" not in shape.attrib):
            values = [float(text) for text in shape.get(attribute, "0 0 0").split()]
            shape.set(attribute, numbers([v + height * (i % 3 == 2) for i, v in enumerate(values)]))


SENSORS = 64
# In turn, at every observed point in turn.
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


def sensors(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Sensors that nobody reads, of all kinds that tell a site's motion."""
    points = tree.mechanism.observed
    for i in range(SENSORS):
        kind, point = SENSOR_KINDS[i % len(SENSOR_KINDS)], points[i // len(SENSOR_KINDS) % len(points)]
        # The two kinds of real sensors are bolted to a site, the others are of any object.
        of = {"objtype": "site", "objname": point.name} if kind.startswith("frame") else {"site": point.name}
        add(section(root, "sensor"), kind, name=f"unread-{i + 1}", **of)


def no_contact(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Cam and roller pass through each other."""
    contacts = section(root, "contact")
    for pair in list(contacts.iter("pair")):
        contacts.remove(pair)


PASSIVE_JOINTS = ".//body/joint"  # a tendon that ties wheels has elements of the same name
PASSIVE_DAMPING, PASSIVE_ARMATURE = 0.1, 0.01
NOSLIP_ITERATIONS = 5
# Evaluations; two are exact along a direction of Newton's method, as long as the set of acting constraints stays.
LINE_SEARCH = 5

# Applied from the first to the last: what takes a closure away comes before what adds to it.
EDITS: Mapping[str, Edit] = {
    "open-loops": open_loops,
    "redundant-closures": redundant_closures,
    "no-contact": no_contact,
    "visual-geoms": visual_geoms,
    "touching-geoms": partial(colliding, 0.0),
    "colliding-geoms": partial(colliding, LAYER),
    "sensors-64": sensors,
    "energy": partial(attribute, "option/flag", "energy", "enable"),
    "fwdinv": partial(attribute, "option/flag", "fwdinv", "enable"),
    "sparse-jacobian": partial(attribute, "option", "jacobian", "sparse"),
    # MuJoCo has these two on by itself (4.0), so that it is their absence that must be said.
    "no-islands": partial(attribute, "option/flag", "island", "disable"),
    "no-multiccd": partial(attribute, "option/flag", "multiccd", "disable"),
    "short-line-search": partial(attribute, "option", "ls_iterations", str(LINE_SEARCH)),
    "noslip": partial(attribute, "option", "noslip_iterations", str(NOSLIP_ITERATIONS)),
    "condim-3": partial(attribute, "contact/pair", "condim", "3"),
    "passive-damping": partial(attribute, PASSIVE_JOINTS, "damping", str(PASSIVE_DAMPING)),
    "passive-armature": partial(attribute, PASSIVE_JOINTS, "armature", str(PASSIVE_ARMATURE)),
}
# MuJoCo lets a body through its parent: of the links in one plane only those overlap for it that a closure joins.
OF_LOOPS = ("open-loops", "redundant-closures", "touching-geoms")
OF_CONTACT = ("no-contact", "condim-3")


def dress_up(root: ET.Element, tree: SpanningTree, settings: MuJoCoSettings) -> None:
    """Edit a complete model as its settings say.

    Raises:
        InvalidInput: a name is none of `EDITS`, or does not apply to the machine, see `edit_refusal`.
    """
    for name in settings.dressing:
        if name not in EDITS:
            raise unknown_choice("dressing", name, EDITS)
    for name, edit in EDITS.items():
        if name in settings.dressing:
            edit(root, tree, settings)


def edit_refusal(mechanism: Mechanism, settings: MuJoCoSettings) -> str | None:
    """None, or the reason why a model of a mechanism cannot be dressed like this."""
    for name in settings.dressing:
        if name in OF_CONTACT and not mechanism.cam_contacts:
            return f"{name} is of a cam's contact, and there is none"
        if name in OF_LOOPS and mechanism.cam_contacts:
            return f"{name} is of loops that joints close, and there are none"
    return None
