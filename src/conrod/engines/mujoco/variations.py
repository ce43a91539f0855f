"""Variations of MuJoCo's settings, and settings as lines of a user's own model. Imports no engine."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from conrod.engines.engine import Machine, with_fields
from conrod.engines.massless_rod import DISTANCE_JOINT, model_form
from conrod.engines.mujoco.mjcf import mjcf
from conrod.engines.mujoco.settings import LEAST_STEPS, MuJoCoSettings
from conrod.engines.tree import tree_of


def stabilised(machine: Machine, settings: MuJoCoSettings, steps: float) -> MuJoCoSettings:
    """The damping ratio stays. Below two steps MuJoCo's guard (refsafe) would raise the time constant."""
    field = "contact_solref" if machine.kinematics.mechanism.cam_contacts else "solref"
    solref = (steps * settings.timestep, getattr(settings, field)[1])
    return with_fields(settings, refsafe=settings.refsafe and steps >= LEAST_STEPS, **{field: solref})


def regularised(machine: Machine, settings: MuJoCoSettings, share: float) -> MuJoCoSettings:
    """Loops by hardening; contacts, which it is not for, by an impedance that does not change with the overlap."""
    if machine.kinematics.mechanism.cam_contacts:
        impedance = (1.0 - share, 1.0 - share, *settings.contact_solimp[2:])
        return with_fields(settings, contact_solimp=impedance)
    return with_fields(settings, hardening=share)


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
    if after := after_compiling(settings):
        lines += [f"# after compiling, in Python; or conrod.harden(model, {settings.hardening:g})", *after]
    if settings.rounded_state:
        lines += [
            "# after each step, in Python",
            "data.qpos[:] = data.qpos.astype(np.float32)",
            "data.qvel[:] = data.qvel.astype(np.float32)",
        ]
    return "\n".join(lines)


def after_compiling(settings: MuJoCoSettings) -> list[str]:
    """Statements on a compiled model, of what MJCF cannot say: hardening."""
    parts = ["body", "dof", *(["tendon"] if settings.rod == DISTANCE_JOINT else [])]
    return [] if (factor := settings.hardening) is None else [f"model.{p}_invweight0[:] *= {factor:g}" for p in parts]


def _text(element: ET.Element) -> str:
    element.tail = None
    ET.indent(element)
    return ET.tostring(element, encoding="unicode")
