"""Settings as the lines that a user puts into a model of their own. Imports no engine."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from conrod.engines.engine import Machine
from conrod.engines.left_out_rod import DISTANCE_JOINT, model_form
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import tree_of

# What settings say in MJCF: the rest of a model is the machine itself.
PARTS = ("option", "tendon", "equality", "contact")


def paste(machine: Machine, settings: MuJoCoSettings) -> str:
    """Options, closures or contacts and the drive as MJCF; what MJCF cannot say (hardening, rounding) as Python."""
    form = model_form(machine.kinematics.mechanism, settings.rod)
    model = ET.fromstring(mjcf(tree_of(machine, form), settings, "model"))
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
        if settings.rod == DISTANCE_JOINT:
            lines.append(f"model.tendon_invweight0[:] *= {settings.hardening:g}")
    if settings.rounded_state:
        lines += [
            "# after each step, in Python",
            "data.qpos[:] = data.qpos.astype(np.float32)",
            "data.qvel[:] = data.qvel.astype(np.float32)",
        ]
    return "\n".join(lines)


def _text(element: ET.Element) -> str:
    element.tail = None
    ET.indent(element)
    return ET.tostring(element, encoding="unicode")
