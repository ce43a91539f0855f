"""One run of a machine in the engine that its settings are for."""

from __future__ import annotations

from conrod.engines import engine_named
from conrod.engines.engine import Machine
from conrod.trajectory import Settings, Trajectory


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
        InvalidInput: settings that the engine would abort on or that have no meaning.
    """
    return engine_named(settings.engine).run(machine, settings, revolutions, start_angle)
