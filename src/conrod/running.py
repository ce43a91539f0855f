"""One run of a machine in the engine that its settings are for."""

from __future__ import annotations

from conrod.engines import engine_named
from conrod.engines.engine import Machine, step_length
from conrod.errors import InvalidInput
from conrod.ranges import check_number
from conrod.trajectory import Settings, Trajectory

# Settings made for another speed or step would put every sample at a wrong angle.
SAME_STEP = 1e-9


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
    return engine_named(settings.engine).run(machine, settings, float(revolutions), float(start_angle))


def check_run(machine: Machine, settings: Settings, revolutions: float, start_angle: float) -> None:
    """Refuse what `run` refuses, before an engine is asked.

    Raises:
        InvalidInput: a number out of its range, or settings for another speed.
    """
    check_number("revolutions", revolutions, 1e-3, 1e6)
    check_number("start_angle", start_angle, -1e6, 1e6, "rad")
    step = step_length(machine, settings.steps_per_revolution)
    if abs(settings.timestep / step - 1.0) > SAME_STEP:
        raise InvalidInput(
            f"timestep = {settings.timestep:g} s does not fit: {settings.steps_per_revolution} steps a revolution at "
            f"{machine.speed:g} rad/s are {step:g} s each"
        )
