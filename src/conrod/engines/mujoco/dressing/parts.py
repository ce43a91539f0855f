"""Sensors, passive joints, and the contact of a cam."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from conrod.engines.mujoco.dressing.edit import Edit, section
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.mujoco.xml import add, number
from conrod.engines.tree import Tree

# In turn, at every observed point in turn.
SENSORS = ("framepos", "framelinvel", "framelinacc", "framequat", "frameangvel", "frameangacc", "accelerometer", "gyro")


def sensors(count: int) -> Edit:
    """So many sensors that nobody reads, of all kinds that tell a site's motion."""

    def edit(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
        points = tree.mechanism.observed
        for i in range(count):
            kind, point = SENSORS[i % len(SENSORS)], points[i // len(SENSORS) % len(points)]
            # The two kinds of real sensors are bolted to a site, the others are told of any object.
            of = {"objtype": "site", "objname": point.name} if kind.startswith("frame") else {"site": point.name}
            add(section(root, "sensor"), kind, name=f"unread-{i + 1}", **of)

    return edit


def passive(attribute: str, value: float) -> Edit:
    """An attribute of all joints but the driven one."""

    def edit(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
        # A tendon that ties wheels has elements of the same name.
        for joint in root.iterfind(".//body/joint"):
            if joint.get("name") != "crank":
                joint.set(attribute, number(value))

    return edit


def contact_dimension(dimension: int) -> Edit:
    """Friction along, about and across the normal of the cam's contact, as far as the dimension says."""

    def edit(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
        for pair in root.iter("pair"):
            pair.set("condim", str(dimension))

    return edit


def no_contact(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Cam and roller pass through each other."""
    contacts = section(root, "contact")
    for pair in list(contacts.iter("pair")):
        contacts.remove(pair)
