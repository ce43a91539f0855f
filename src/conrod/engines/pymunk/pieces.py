"""Dynamic mode in pieces: a run of any length in memory that one piece takes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from conrod.engines.engine import Machine
from conrod.engines.left_out_rod import ModelForm
from conrod.engines.pymunk.dynamics import Stretch, started, stretches, trajectory_of
from conrod.engines.pymunk.left_over import gap_rate_left
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.trajectory import Piece, SolverState, Trajectory


def pieces(
    machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float, length: int
) -> Iterator[Piece]:
    """One run at constant crank speed, in pieces of so many steps."""
    made = started(machine, settings, start_angle)
    steps = round(settings.steps_per_revolution * revolutions)
    clock = start_angle / machine.speed
    for stretch in stretches(machine, made, settings, start_angle, steps, length):
        trajectory = trajectory_of(machine, settings, revolutions, stretch)
        piece = piece_of(trajectory, made.form, settings, stretch, clock)
        clock = float(piece.clock[-1])
        yield piece


def piece_of(
    trajectory: Trajectory, form: ModelForm, settings: PymunkSettings, stretch: Stretch, clock: float
) -> Piece:
    """A stretch of a run with what is known beside its trajectory.

    Args:
        form: of the space.
        settings: with the length of the steps that were taken.
        clock: at the sample before the stretch, or at the start [s].
    """
    samples = len(stretch.bodies.position.poses)
    # Chipmunk has no clock. A user keeps one, step by step: `accumulate` adds in this order, with its rounding.
    ticks = np.full(samples + (stretch.first > 0), settings.timestep)
    ticks[0] = clock
    with np.errstate(all="ignore"):
        left = gap_rate_left(form, settings, stretch.centres, stretch.rates)
    # The iteration has no test of its own, and takes all it may.
    solver = None if left is None else SolverState(settings.iterations, left, of_rates=True)
    return Piece(trajectory, stretch.first, np.add.accumulate(ticks)[-samples:], {}, solver, None)
