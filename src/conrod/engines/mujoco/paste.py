"""Settings as the lines that a user puts into a model of their own. Imports no engine."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from conrod.engines.engine import Machine
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import spanning_tree

# What settings say in MJCF: the rest of a model is the machine itself.
PARTS = ("option", "equality", "contact")


def paste(machine: Machine, settings: MuJoCoSettings) -> str:
    """Options, loop closures or contacts and the drive as MJCF; hardening, which MJCF cannot say, as Python."""
    kinematics = machine.kinematics
    model = ET.fromstring(mjcf(spanning_tree(kinematics.mechanism, kinematics.start[0]), settings, "model"))
    parts = [
        element for name in PARTS if (element := model.find(name)) is not None and len(element.attrib) + len(element)
    ]
    crank = model.find(".//joint[@name='crank']")
    lines = [_text(element) for element in [*parts, *([] if crank is None else [crank])]]
    if settings.hardening is not None:
        lines += [
            "# after compiling, in Python; or conrod.harden(model)",
            f"model.body_invweight0[:] *= {settings.hardening:g}",
            f"model.dof_invweight0[:] *= {settings.hardening:g}",
        ]
    return "\n".join(lines)


def _text(element: ET.Element) -> str:
    element.tail = None
    ET.indent(element)
    return ET.tostring(element, encoding="unicode")
