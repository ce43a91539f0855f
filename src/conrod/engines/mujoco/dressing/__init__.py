"""What a model carries beside what its motion needs, by name: edits of the MJCF element tree. Imports no engine."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

from conrod.engines.left_out_rod import BODY
from conrod.engines.mujoco.dressing.edit import Edit
from conrod.engines.mujoco.dressing.free_bodies import free_bodies
from conrod.engines.mujoco.dressing.geoms import geoms_apart, geoms_that_touch, visual_geoms
from conrod.engines.mujoco.dressing.loops import open_loops, redundant_closures
from conrod.engines.mujoco.dressing.options import flag, option
from conrod.engines.mujoco.dressing.parts import contact_dimension, no_contact, passive, sensors
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import Tree
from conrod.errors import unknown_choice
from conrod.mechanism import Mechanism

PASSIVE_DAMPING, PASSIVE_ARMATURE = 0.1, 0.01
NOSLIP_ITERATIONS = 5
# Evaluations; two are exact along a direction of Newton's method, as long as the set of acting constraints stays.
LINE_SEARCH = 5

# Applied from the first to the last: what moves a body, or takes a closure away, comes before what adds to it.
EDITS: Mapping[str, Edit] = {
    "free-bodies": free_bodies,
    "open-loops": open_loops,
    "redundant-closures": redundant_closures,
    "no-contact": no_contact,
    "visual-geoms": visual_geoms,
    "touching-geoms": geoms_that_touch,
    "colliding-geoms": geoms_apart,
    "sensors-1": sensors(1),
    "sensors-8": sensors(8),
    "sensors-64": sensors(64),
    "energy": flag("energy", on=True),
    "fwdinv": flag("fwdinv", on=True),
    "sparse-jacobian": option("jacobian", "sparse"),
    # MuJoCo has these two on by itself (4.0), so that it is their absence that must be said.
    "no-islands": flag("island", on=False),
    "no-multiccd": flag("multiccd", on=False),
    "short-line-search": option("ls_iterations", str(LINE_SEARCH)),
    "noslip": option("noslip_iterations", str(NOSLIP_ITERATIONS)),
    "condim-3": contact_dimension(3),
    "condim-4": contact_dimension(4),
    "condim-6": contact_dimension(6),
    "passive-damping": passive("damping", PASSIVE_DAMPING),
    "passive-armature": passive("armature", PASSIVE_ARMATURE),
}
# MuJoCo lets a body through its parent: of the links in one plane only those overlap for it that a closure joins.
OF_LOOPS = ("free-bodies", "open-loops", "redundant-closures", "touching-geoms")
OF_CONTACT = ("no-contact", "condim-3", "condim-4", "condim-6")


def dress_up(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Edit a complete model as its settings say.

    Raises:
        InvalidInput: a name is none of `EDITS`, or does not apply to the machine, see `dressing_refusal`.
    """
    for name in settings.dressing:
        if name not in EDITS:
            raise unknown_choice("dressing", name, EDITS)
    for name, edit in EDITS.items():
        if name in settings.dressing:
            edit(root, tree, settings)


def dressing_refusal(mechanism: Mechanism, settings: MuJoCoSettings) -> str | None:
    """None, or the reason why a model of a mechanism cannot be dressed like this."""
    for name in settings.dressing:
        if name in OF_CONTACT and not mechanism.cam_contacts:
            return f"{name} is of a cam's contact, and there is none"
        if name in OF_LOOPS and mechanism.cam_contacts:
            return f"{name} is of loops that joints close, and there are none"
        if name == "free-bodies" and settings.rod != BODY:
            return "a link that is left out cannot be a free body"
        if name == "free-bodies" and mechanism.meshes:
            return "a rolling pair ties the joints of its wheels, which free bodies do not have"
    return None
