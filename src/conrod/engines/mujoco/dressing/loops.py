"""Closures of loops, taken away or doubled."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET

from conrod.engines.mujoco.dressing.edit import section
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import Tree


def open_loops(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Without what closes the loops; pins that carry free bodies stay."""
    equality = section(root, "equality")
    closures = [joint.name for joint in tree.cuts] + [distance.link for distance in tree.distances]
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
