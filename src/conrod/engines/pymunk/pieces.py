"""Dynamic mode in pieces: a run of any length in memory that one piece takes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from conrod.engines.engine import Machine
from conrod.engines.pymunk.dynamics import stretches, trajectory_of
from conrod.engines.pymunk.left_over import gap_rate_left
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.space import build
from conrod.trajectory import Piece, SolverState


def pieces(
    machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float, length: int
) -> Iterator[Piece]:
    """One run at constant crank speed, in pieces of so many steps."""
    made = build(machine, settings)
    steps = round(settings.steps_per_revolution * revolutions)
    clock = start_angle / machine.speed
    for stretch in stretches(machine, made, settings, start_angle, steps, length):
        trajectory = trajectory_of(machine, settings, revolutions, stretch)
        samples = len(stretch.bodies.position.poses)
        # Chipmunk has no clock. A user keeps one, step by step: `accumulate` adds in this order, with its rounding.
        ticks = np.full(samples + (stretch.first > 0), settings.timestep)
        ticks[0] = clock
        clocks = np.add.accumulate(ticks)[-samples:]
        clock = float(clocks[-1])
        with np.errstate(all="ignore"):
            left = gap_rate_left(made.form, settings, stretch.centres, stretch.rates)
        # The iteration has no test of its own, and takes all it may.
        solver = None if left is None else SolverState(settings.iterations, left, of_rates=True)
        yield Piece(trajectory, stretch.first, clocks, {}, solver, None)
