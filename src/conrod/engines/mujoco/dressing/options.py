"""Flags and options of the engine."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from conrod.engines.mujoco.dressing.edit import Edit, section
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import Tree


def flag(name: str, *, on: bool) -> Edit:
    """A flag set, whatever the engine's default is."""

    def edit(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
        section(section(root, "option"), "flag").set(name, "enable" if on else "disable")

    return edit


def option(name: str, value: str) -> Edit:
    """An option set."""

    def edit(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
        section(root, "option").set(name, value)

    return edit
