"""Shapes on the links: to be seen only, or such that may collide."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from conrod.engines.mujoco.dressing.edit import body_element, section
from conrod.engines.mujoco.looks import add_link_geoms, link_width
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.mujoco.xml import numbers
from conrod.engines.tree import Tree

# Of the layers that links lie in, in widths of a link: more than the pins' length of 3.2.
LAYER = 4.0


def visual_geoms(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Bars, pins and blocks as the exported files have them; they cannot collide."""
    for link in tree.mechanism.bodies:
        add_link_geoms(body_element(root, link.name), link.name, tree)


def geoms_that_touch(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """The same shapes, all in the plane of motion: links overlap where pins join them."""
    _colliding(root, tree, 0.0)


def geoms_apart(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """The same shapes, each link in a layer of its own, as in a real machine: they pass close, and never touch."""
    _colliding(root, tree, LAYER * link_width(tree))


def _colliding(root: ET.Element, tree: Tree, layer: float) -> None:
    # Linkages are run with collisions off.
    section(section(root, "option"), "flag").attrib.pop("contact", None)
    for i, link in enumerate(tree.mechanism.bodies):
        shapes = ET.Element("body")
        add_link_geoms(shapes, link.name, tree)
        element = body_element(root, link.name)
        for shape in list(shapes):
            shape.attrib |= {"contype": "1", "conaffinity": "1"}
            _lift(shape, i * layer)
            element.append(shape)


def _lift(shape: ET.Element, height: float) -> None:
    """Raise a shape out of the plane of motion by so much [m]."""
    for attribute in ("pos", "fromto"):
        if attribute in shape.attrib or (attribute == "pos" and "fromto" not in shape.attrib):
            values = [float(text) for text in shape.get(attribute, "0 0 0").split()]
            shape.set(attribute, numbers([v + height * (i % 3 == 2) for i, v in enumerate(values)]))
