"""One run of a machine in the engine that its settings are for."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from conrod.engines import Engine, engine_named
from conrod.engines.engine import Machine, step_length
from conrod.errors import InvalidInput
from conrod.exact.reference import ExactReference
from conrod.mechanism.units import check_number
from conrod.runs.comparison import Stretch
from conrod.runs.outcome import Verdict
from conrod.runs.run_errors import Recorder
from conrod.runs.trajectory import Outcome, Settings, Trajectory, concatenate_pieces

# Settings made for another speed or step would put every sample at a wrong angle.
SAME_STEP = 1e-5  # as settings are pasted: a step of another speed is off by more than its sixth digit
SAME_ANGLE = 1e-9  # [rad], rounding of what a run takes


def run(machine: Machine, settings: Settings, revolutions: float = 2.0, start_angle: float = 0.0) -> Trajectory:
    """Drive a machine at constant crank speed and sample it at every step.

    Args:
        machine: a scene.
        settings: of the engine to use, from a preset or made by hand.
        revolutions: turns of the crank.
        start_angle: crank angle [rad] at the start, where the exact state is set.

    Returns:
        The trajectory; how it ended is in its `outcome`, never an exception.

    Raises:
        InvalidInput: settings that the engine would abort on, that have no meaning, or that are for another speed.
    """
    check_run(machine, settings, revolutions, start_angle)
    return whole_run(engine_named(settings.engine), machine, settings, float(revolutions), float(start_angle))


def whole_run(
    engine: Engine[Any], machine: Machine, settings: Settings, revolutions: float, start_angle: float = 0.0
) -> Trajectory:
    """A run of an engine as one piece; nothing is checked."""
    steps = max(round(settings.steps_per_revolution * revolutions), 1)
    return concatenate_pieces(list(engine.run(machine, settings, revolutions, start_angle, steps))).trajectory


def followed(
    engine: Engine[Any],
    machine: ExactReference,
    settings: Settings,
    revolutions: float,
    start_angle: float,
    *recorders: Recorder,
    every: Callable[[Trajectory], None] = lambda _: None,
) -> Verdict:
    """The end of a run of an engine, of which the recorders get what is in one piece; nothing is checked.

    Memory does not grow with the run but by what they keep.

    Args:
        every: gets all pieces, also those of a machine that is no longer in one piece.
    """
    samples = round(settings.steps_per_revolution * revolutions) + 1
    for piece in engine.run(machine, settings, revolutions, start_angle):
        found = piece.trajectory
        left = samples - piece.first_step - len(piece.clock)
        every(found)
        if found.outcome is Outcome.COMPLETED:
            stretch = Stretch(found, machine, max(0, left))
            for recorder in recorders:
                recorder.add(stretch)
    if found.outcome is Outcome.COMPLETED and left > 0:
        return Verdict(Outcome.CRASHED, f"the run ended after {samples - left} of {samples} samples")
    return Verdict(found.outcome, found.reason)


def check_run(machine: Machine, settings: Settings, revolutions: float, start_angle: float) -> None:
    """Refuse what `run` refuses, before an engine is asked.

    Raises:
        InvalidInput: a number out of its range, or settings for another speed.
    """
    check_number("revolutions", revolutions, 1e-3, 1e6)
    check_number("start_angle", start_angle, -1e6, 1e6, "rad")
    span = machine.kinematics.mechanism.driver.span
    if span is not None:
        _check_span(machine, span, revolutions, start_angle)
    step = step_length(machine, settings.steps_per_revolution)
    if abs(settings.timestep / step - 1.0) > SAME_STEP:
        raise InvalidInput(
            f"timestep = {settings.timestep:g} s does not fit: {settings.steps_per_revolution} steps a revolution at "
            f"{machine.speed:g} rad/s are {step:g} s each"
        )


def _check_span(machine: Machine, span: tuple[float, float], revolutions: float, start_angle: float) -> None:
    """Refuse a run that leaves the span of an input which cannot turn fully."""
    stop_angle = start_angle + math.copysign(2.0 * math.pi * revolutions, machine.speed)
    if not all(span[0] - SAME_ANGLE <= angle <= span[1] + SAME_ANGLE for angle in (start_angle, stop_angle)):
        start, turns = span[0] if machine.speed > 0.0 else span[1], (span[1] - span[0]) / (2.0 * math.pi)
        raise InvalidInput(
            f"start_angle = {start_angle:.9g} rad, revolutions = {revolutions:.9g}: the run leaves the one pass that "
            f"the input makes; it starts at {start:.9g} rad and takes {turns:.9g} revolutions"
        )
