"""Links as free bodies in space, their pins three connects each, where hinges in a tree would do."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from conrod.engines.mujoco.dressing.edit import body_element, section
from conrod.engines.mujoco.looks import link_width
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.mujoco.xml import add, numbers
from conrod.engines.tree import Branch, Tree
from conrod.mechanism import Point, Revolute

# Where a pin is held, along its axis in widths of a link.
PLACES = {"": 0.0, "/above": 1.5, "/below": -1.5}


def hung_on_pins(tree: Tree) -> tuple[Branch, ...]:
    """Branches that are pins, the driven one apart: it stays a hinge, because a flywheel needs a joint."""
    driven = tree.mechanism.driver.joint
    return tuple(b for b in tree.branches if isinstance(b.joint, Revolute) and b.joint.name != driven)


def free_bodies(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Free every link that hangs on a pin, and hold all pins but the driven one by three connects along the axis.

    Slides stay joints: MuJoCo has no equality that is one.
    """
    parents = {child: parent for parent in root.iter() for child in parent}
    world, pins = section(root, "worldbody"), list(tree.cuts)
    for branch in hung_on_pins(tree):
        assert isinstance(branch.joint, Revolute)
        element = body_element(root, branch.child)
        parents[element].remove(element)
        world.append(element)
        _set_free(element, tree, branch.child)
        pins.append(branch.joint)
    for pin in pins:
        _hold(root, pin, settings, PLACES, link_width(tree))


def _set_free(element: ET.Element, tree: Tree, body: str) -> None:
    """The body, now a child of the world, in its start pose there."""
    x, y, turn = (float(value) for value in tree.start_pose(body))
    element.attrib |= {"pos": numbers([x, y, 0.0]), "euler": numbers([0.0, 0.0, turn])}
    joint = element.find("joint")
    assert joint is not None
    element.remove(joint)
    element.insert(0, ET.Element("freejoint", name=joint.get("name", "")))


def _hold(root: ET.Element, pin: Revolute, settings: MuJoCoSettings, places: dict[str, float], width: float) -> None:
    """Connects of a pin, the one in the plane as well where it is not there yet."""
    stiffness = {"solref": numbers(settings.solref), "solimp": numbers(settings.solimp)}
    equality = section(root, "equality")
    for suffix, height in places.items():
        ends = [_site(root, pin, body, point, suffix, height * width) for body, point in _ends(pin)]
        if equality.find(f"connect[@name='{pin.name}{suffix}']") is None:
            add(equality, "connect", name=pin.name + suffix, site1=ends[0], site2=ends[1], **stiffness)


def _ends(pin: Revolute) -> tuple[tuple[str, Point], tuple[str, Point]]:
    return (pin.a, pin.point_a), (pin.b, pin.point_b)


def _site(root: ET.Element, pin: Revolute, body: str, point: Point, suffix: str, height: float) -> str:
    """Name of the pin's site on a body, made where it is missing."""
    name = f"{pin.name}.{body}{suffix}"
    if root.find(f".//site[@name='{name}']") is None:
        add(body_element(root, body), "site", name=name, pos=numbers([*point, height]))
    return name
