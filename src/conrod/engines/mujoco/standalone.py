"""MJCF files for people to reuse: with geoms and keyframe, complete to run alone. Does not import the engine."""

from __future__ import annotations

import re
import textwrap
from xml.etree import ElementTree as ET

import numpy as np

from conrod.engines.engine import CUSTOM, DescribedMachine, Machine, default_steps, pass_sentence, run_extent
from conrod.engines.mujoco import MuJoCoSettings
from conrod.engines.mujoco.loads import callback_loads, does_no_work
from conrod.engines.mujoco.mjcf import Presentation, mjcf_text
from conrod.engines.spanning_tree import SpanningTree, grow_spanning_tree, machine_tree, tree_refusal
from conrod.errors import InvalidInput
from conrod.exact.motion import Array


def standalone_mjcf(
    name: str,
    machine: DescribedMachine,
    steps_per_revolution: int | None = None,
    settings: MuJoCoSettings | None = None,
) -> str:
    """MJCF text of a scene with geoms to look at and a keyframe to start from; tuned by default."""
    if settings is None:
        settings = MuJoCoSettings.tuned(machine, steps_per_revolution or default_steps(machine))
    kinematics = machine.kinematics
    poses, derivative = kinematics.derivatives(np.array([run_extent(machine, 1, 1.0)[0]]), 1)
    # Coordinates are zero in the model's start pose; an input that makes one pass starts where the pass does.
    turns = kinematics.mechanism.driver.span is None
    tree = grow_spanning_tree(kinematics.mechanism, kinematics.start[0] if turns else poses[0])
    rates = tree.rates(poses, derivative * machine.speed)[0]
    dress = Presentation(_header(name, machine, settings, tree), tuple(float(rate) for rate in rates))
    return mjcf_text(tree, settings, f"conrod-{name}", dress)


def standalone_free_mjcf(
    name: str, machine: DescribedMachine, start: tuple[Array, Array], settings: MuJoCoSettings, motor: bool = False
) -> str:
    """MJCF text of a scene without a drive, to look at and to move; with a motor on the crank if asked for.

    Args:
        start: exact poses and rates (3 n,) of all bodies, for the keyframe.

    Raises:
        InvalidInput: MuJoCo cannot have the machine as a tree with closures; says why.
    """
    poses, rates = start
    tree = grow_spanning_tree(machine.kinematics.mechanism, poses)
    if reason := tree_refusal(tree):
        raise InvalidInput(f"{name}: {reason}")
    found = ", ".join(f"{body} {rate:.9g} rad/s" for body, rate in machine.start_rates.items())
    moves = (
        "Nothing holds the speed of joint 'crank': there is no drive and no flywheel. Start rates (counter-clockwise), "
        f"in the keyframe 'start': {found}."
    )
    if motor:
        moves += " Actuator 'motor' turns joint 'crank' with the torque ctrl [N m], counter-clockwise; 0 at first."
    paragraphs = [
        *_description(name, machine),
        moves,
        *_load_paragraphs(tree),
        f"Settings: conrod's preset '{settings.preset}' for motion without a drive, {settings.timestep:.6g} s a step. "
        "Written by the export command of conrod, format mjcf.",
    ]
    joint_rates = tree.rates(poses[None], rates[None])[0]
    dress = Presentation(_comment(paragraphs), tuple(float(rate) for rate in joint_rates), motor)
    return mjcf_text(tree, settings, f"conrod-{name}", dress)


def _description(name: str, machine: DescribedMachine) -> list[str]:
    """Paragraphs on the machine: title, source, parameters, frame."""
    values = ", ".join(f"{key} = {value:.9g}" for key, value in machine.parameters.items())
    return [
        f"{machine.title}, scene {name} of conrod. Source: {machine.source}.",
        f"Parameters (SI): {values}.",
        f"Frame (z points to the viewer): {machine.frame}",
    ]


def _header(name: str, machine: DescribedMachine, settings: MuJoCoSettings, tree: SpanningTree) -> str:
    """Comment at the head of the file: source, parameters, frame, use."""
    points = " and ".join(point.name for point in tree.mechanism.observed)
    paragraphs = [
        *_description(name, machine),
        "Joint 'crank' is driven at constant speed by its armature, a flywheel that nothing in the model can slow down."
        f" Observed: {points}, as sites with sensors for position, velocity and acceleration (an accelerometer's: the "
        "reaction to gravity is in it, where there is gravity). Sensor values after mj_step belong to the instant "
        "before the step.",
        "LOAD THE KEYFRAME 'start' FIRST: it sets the machine in motion (mj_resetDataKeyframe(model, data, 0)). "
        f"Without it the machine stands still.{pass_sentence(machine)}",
        *_load_paragraphs(tree),
        *_free_motion_paragraphs(machine),
        *_settings_paragraphs(settings),
    ]
    return _comment(paragraphs)


def _comment(paragraphs: list[str]) -> str:
    """Paragraphs as text of an XML comment."""
    text = "\n\n".join(textwrap.fill(p, 110, initial_indent="  ", subsequent_indent="  ") for p in paragraphs)
    # Two hyphens would end the comment, and what a machine's file says after them would be part of the model.
    return re.sub("-(?=-)", "- ", text)


def _settings_paragraphs(settings: MuJoCoSettings) -> list[str]:
    """Paragraphs on the settings, and on the command that wrote them."""
    at = f"at {settings.steps_per_revolution} steps a revolution"
    if settings.preset == CUSTOM:
        lines = hardening_statements(settings)
        after = [f"AFTER COMPILING, IN PYTHON, because MJCF has no words for it: {'; '.join(lines)}"] if lines else []
        return [f"Settings: {settings.integrator}, {at}, of the recommend command of conrod.", *after]
    return [
        f"Settings: conrod's preset 'tuned' {at}. The solver "
        "tolerance of 0 is needed: with this armature MuJoCo's default ends the solver before its first iteration, and "
        "what closes the joints does not act.",
        "Written by the export command of conrod, format mjcf.",
    ]


def _load_paragraphs(tree: SpanningTree) -> list[str]:
    """Paragraphs on the loads in the model, and on the loads left out of it."""
    loads = tree.mechanism.loads
    left_out = [load for load in loads if load in callback_loads(tree.mechanism) or does_no_work(load, tree)]
    kept = ", ".join(load.name for load in loads if load not in left_out)
    found = [f"Loads in this model, as tendons or as actuators without an input: {kept}."] if kept else []
    if left_out:
        names = ", ".join(f"{load.name} ({load.law})" for load in left_out)
        found.append(f"NOT IN THIS MODEL, because MJCF has no words for their laws or they move nothing: {names}.")
    return found


def _free_motion_paragraphs(machine: DescribedMachine) -> list[str]:
    """Paragraph on free motion; none for a machine without loads and without start rates."""
    mechanism = machine.kinematics.mechanism
    driven = {mechanism.crank: mechanism.driver.sense * machine.speed}
    if not mechanism.loads and dict(machine.start_rates) == driven:
        return []
    rates = ", ".join(f"{body} {rate:.9g} rad/s" for body, rate in machine.start_rates.items())
    return [
        "FOR FREE OR TORQUE-DRIVEN MOTION set the armature of joint 'crank' to 0: as it is, neither weight nor loads "
        f"change the speed. The keyframe's qvel are those of the driver's speed, {machine.speed:.9g} rad/s; all of "
        f"them times one number make another start. The scene's own (counter-clockwise): {rates}."
    ]


# -- settings to paste -------------------------------------------------------------------------------------------------

# What settings say in MJCF: the rest of a model is the machine itself.
PASTED_SECTIONS = ("option", "tendon", "equality", "contact")


def paste(machine: Machine, settings: MuJoCoSettings) -> str:
    """Options, closures or contacts and drive as MJCF lines; hardening, which MJCF lacks, as Python lines."""
    model = ET.fromstring(mjcf_text(machine_tree(machine), settings, "model"))
    parts = [
        element
        for name in PASTED_SECTIONS
        if (element := model.find(name)) is not None and len(element.attrib) + len(element)
    ]
    crank = model.find(".//joint[@name='crank']")
    lines = [_element_text(element) for element in [*parts, *([] if crank is None else [crank])]]
    if after := hardening_statements(settings):
        lines += [f"# after compiling, in Python; or conrod.harden(model, {settings.hardening:g})", *after]
    return "\n".join(lines)


def hardening_statements(settings: MuJoCoSettings) -> list[str]:
    """Python statements that harden a compiled model; none without hardening."""
    factor = settings.hardening
    return [] if factor is None else [f"model.{part}_invweight0[:] *= {factor:g}" for part in ("body", "dof")]


def _element_text(element: ET.Element) -> str:
    """An XML element as indented text."""
    element.tail = None
    ET.indent(element)
    return ET.tostring(element, encoding="unicode")
