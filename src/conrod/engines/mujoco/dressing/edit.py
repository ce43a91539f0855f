"""What an edit of a model is, and how its elements are found."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from typing import TypeAlias

from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.mujoco.xml import add
from conrod.engines.tree import Tree
from conrod.mechanism import GROUND

Edit: TypeAlias = Callable[[ET.Element, Tree, MuJoCoSettings], None]


def section(root: ET.Element, tag: str) -> ET.Element:
    """A section of the model, made where it is missing."""
    found = root.find(tag)
    return add(root, tag) if found is None else found


def body_element(root: ET.Element, name: str) -> ET.Element:
    """The element of a body, or of the ground."""
    found = root.find("worldbody") if name == GROUND else root.find(f".//body[@name='{name}']")
    if found is None:
        raise ValueError(f"the model has no body {name!r}")
    return found
