"""Docstrings of standalone modules: machine, source, frame, units and every constant, drive, instants, settings."""

from __future__ import annotations

import textwrap

from conrod.engines.engine import CUSTOM, DescribedMachine, pass_sentence
from conrod.engines.pymunk import PymunkSettings
from conrod.mechanism.mechanism import Mechanism
from conrod.mechanism.units import unit_in_prose

PARAGRAPH_WIDTH = 110
# Columns of the table of parameters [characters].
MEANING_COLUMN = 44


def driven_header(name: str, machine: DescribedMachine, settings: PymunkSettings) -> str:
    """Docstring of a machine that is driven at constant speed."""
    mechanism = machine.kinematics.mechanism
    sense = "counter-clockwise" if mechanism.driver.sense > 0 else "clockwise"
    drive = (
        f"Body {mechanism.crank!r} is the crank, driven at SPEED: a kinematic body, whose speed no force changes, and "
        f"whose angle `step` writes. The crank angle counts {sense}; it is 0 at time 0. build(speed=...) takes another "
        "speed, at as many steps a revolution; build(drive=False) leaves the crank to its mass, pinned to its shaft."
        f"{pass_sentence(machine, 'RUN_STEPS steps')}"
    )
    paragraphs = [drive, _instants(mechanism), *_forces(mechanism), *_settings(settings)]
    return _document(name, machine, "model = build()", paragraphs)


def free_header(name: str, machine: DescribedMachine, settings: PymunkSettings, motor: bool) -> str:
    """Docstring of a machine without a drive."""
    mechanism = machine.kinematics.mechanism
    rates = ", ".join(f"{body} {rate:.9g} rad/s" for body, rate in machine.start_rates.items())
    moves = (
        f"Nothing holds the speed of body {mechanism.crank!r}, the crank: it has its own mass, and moves as weight and "
        f"loads demand. Its start, counter-clockwise: {rates}."
    )
    if motor:
        moves += (
            " constraints[MOTOR] is a motor on it; its `rate` [rad/s] and largest torque `max_force` [N m] are those "
            "of build(rate=..., max_force=...), and may be set at any time."
        )
    paragraphs = [moves, _instants(mechanism), *_forces(mechanism), *_settings(settings, free=True)]
    return _document(name, machine, "model = build()", paragraphs)


def _document(name: str, machine: DescribedMachine, building: str, paragraphs: list[str]) -> str:
    """Docstring: title, use, source, parameters, frame, and further paragraphs."""
    use = (
        f"    {building}\n    step(model)  # as often as needed\n    model.position({_first_observed_name(machine)!r})"
    )
    return "\n\n".join(
        [
            _wrap_paragraph(f"{machine.title}, scene {name} of conrod, as a pymunk model."),
            use,
            _wrap_paragraph(f"Source: {machine.source}."),
            "Parameters (SI):\n\n" + "\n".join(_parameter_lines(machine)),
            _wrap_paragraph(f"Frame (z points to the viewer, angles count counter-clockwise): {machine.frame}"),
            *map(_wrap_paragraph, paragraphs),
        ]
    )


def _first_observed_name(machine: DescribedMachine) -> str:
    """Name of the first observed point; empty if no point is observed."""
    return next((point.name for point in machine.kinematics.mechanism.observed), "")


def _wrap_paragraph(paragraph: str) -> str:
    return textwrap.fill(paragraph, PARAGRAPH_WIDTH)


def _parameter_lines(machine: DescribedMachine) -> list[str]:
    """A line on each parameter: value, unit and meaning."""
    facts, lines = machine.parameter_facts(), []
    for name, value in machine.parameters.items():
        unit = unit_in_prose(facts[name].unit)
        quantity = f"    {name} = {value:.9g}{' ' * bool(unit)}{unit}"
        meaning = facts[name].meaning
        lines.append(f"{quantity:{MEANING_COLUMN}}  {meaning}" if meaning else quantity)
    return lines


def _instants(mechanism: Mechanism) -> str:
    """Paragraph on the instants that positions and velocities belong to."""
    if mechanism.cam_contacts:
        return "After a step, positions and velocities belong to model.time."
    return (
        "After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies "
        "first, and then finds velocities that fit the joints."
    )


def _forces(mechanism: Mechanism) -> list[str]:
    """Paragraphs on constant forces and on loads, which `step` applies."""
    found = []
    if mechanism.constant_forces:
        found.append(f"Constant forces act on {', '.join(mechanism.constant_forces)}: PUSHES, applied by `step`.")
    if mechanism.loads:
        names = ", ".join(f"{load.name} ({load.law})" for load in mechanism.loads)
        found.append(f"Loads, applied by `step`: {names}.")
    return found


def _settings(settings: PymunkSettings, free: bool = False) -> list[str]:
    """Paragraphs on the settings, and on the command that wrote them."""
    at = f"at {settings.timestep:.6g} s a step" if free else f"at {settings.steps_per_revolution} steps a revolution"
    if settings.preset == CUSTOM:
        return [f"Settings: {at}, of the recommend command of conrod."]
    return [
        f"Settings: conrod's preset '{settings.preset}' {at}. Written by the export command of conrod, format pymunk."
    ]
