"""Edits of a model beside what its motion needs, by name: of the MJCF element tree. Imports no engine."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from typing import TypeAlias

from conrod.engines.mujoco.closures import add, number, numbers, section
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.mujoco.visual_geometry import add_link_geoms, link_width
from conrod.engines.tree import Tree
from conrod.errors import unknown_choice
from conrod.mechanism.mechanism import GROUND, Mechanism

Edit: TypeAlias = Callable[[ET.Element, Tree, MuJoCoSettings], None]


def body_element(root: ET.Element, name: str) -> ET.Element:
    """The element of a body, or of the ground."""
    found = root.find("worldbody") if name == GROUND else root.find(f".//body[@name='{name}']")
    if found is None:
        raise ValueError(f"the model has no body {name!r}")
    return found


def open_loops(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Without what closes the loops."""
    equality = section(root, "equality")
    closures = [joint.name for joint in tree.cuts]
    closures += [mesh.name for mesh in tree.mechanism.meshes]
    for element in list(equality):
        if element.get("name", "").split("/")[0] in closures:
            equality.remove(element)


def redundant_closures(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Every closure once more, of the same sites."""
    equality = section(root, "equality")
    for element in list(equality):
        again = copy.deepcopy(element)
        again.set("name", f"{element.get('name')}/again")
        equality.append(again)


def attribute(place: str, name: str, value: str | float) -> Edit:
    """An attribute of all elements at a place of the model but the driven joint; options and flags are always there."""
    text = value if isinstance(value, str) else number(value)

    def edit(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
        for element in root.iterfind(place):
            if element.get("name") != "crank":
                element.set(name, text)

    return edit


# Of the layers that links lie in, in widths of a link: more than the pins' length of 3.2.
LAYER = 4.0


def visual_geoms(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Bars, pins and blocks as the exported files have them; they cannot collide."""
    for link in tree.mechanism.bodies:
        add_link_geoms(body_element(root, link.name), link.name, tree)


def colliding(layer: float) -> Edit:
    """The same shapes, able to collide, each link in a layer of its own, so many widths of a link from the next."""

    def edit(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
        # Linkages are run with collisions off.
        section(section(root, "option"), "flag").attrib.pop("contact", None)
        for i, link in enumerate(tree.mechanism.bodies):
            shapes = ET.Element("body")
            add_link_geoms(shapes, link.name, tree)
            for shape in shapes:
                shape.attrib |= {"contype": "1", "conaffinity": "1"}
                _lift(shape, i * (layer * link_width(tree)))
            body_element(root, link.name).extend(shapes)

    return edit


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


def sensors(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Sensors that nobody reads, of all kinds that tell a site's motion."""
    points = tree.mechanism.observed
    for i in range(SENSORS):
        kind, point = SENSOR_KINDS[i % len(SENSOR_KINDS)], points[i // len(SENSOR_KINDS) % len(points)]
        # The two kinds of real sensors are bolted to a site, the others are of any object.
        of = {"objtype": "site", "objname": point.name} if kind.startswith("frame") else {"site": point.name}
        add(section(root, "sensor"), kind, name=f"unread-{i + 1}", **of)


def no_contact(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
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
    "touching-geoms": colliding(0.0),
    "colliding-geoms": colliding(LAYER),
    "sensors-64": sensors,
    "energy": attribute("option/flag", "energy", "enable"),
    "fwdinv": attribute("option/flag", "fwdinv", "enable"),
    "sparse-jacobian": attribute("option", "jacobian", "sparse"),
    # MuJoCo has these two on by itself (4.0), so that it is their absence that must be said.
    "no-islands": attribute("option/flag", "island", "disable"),
    "no-multiccd": attribute("option/flag", "multiccd", "disable"),
    "short-line-search": attribute("option", "ls_iterations", str(LINE_SEARCH)),
    "noslip": attribute("option", "noslip_iterations", str(NOSLIP_ITERATIONS)),
    "condim-3": attribute("contact/pair", "condim", "3"),
    "passive-damping": attribute(PASSIVE_JOINTS, "damping", PASSIVE_DAMPING),
    "passive-armature": attribute(PASSIVE_JOINTS, "armature", PASSIVE_ARMATURE),
}
# MuJoCo lets a body through its parent: of the links in one plane only those overlap for it that a closure joins.
OF_LOOPS = ("open-loops", "redundant-closures", "touching-geoms")
OF_CONTACT = ("no-contact", "condim-3")


def dress_up(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
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
