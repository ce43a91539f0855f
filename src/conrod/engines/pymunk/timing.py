"""Steps with nothing recorded, which is what pymunk itself costs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pymunk

from conrod.engines.engine import STOCK, Machine, run_of
from conrod.engines.pymunk.built import Pushed
from conrod.engines.pymunk.dynamics import started as start_of
from conrod.engines.pymunk.loads import pushes_of
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.stepping import repeat
from conrod.engines.reference_loop import REFERENCE


def reference_loop() -> BareRun:
    """The slider-crank that timings are ratios to, with pymunk's defaults."""
    return started(REFERENCE, PymunkSettings(STOCK, 1000, 0.001))


@dataclass
class BareRun:
    """A space with a driven crank; calling it advances it by so many steps.

    Attributes:
        turn: of the crank body at the start [rad].
        spin: its speed [rad/s].
        give: gives all bodies their forces for the step that begins so long [s] after the start; None without loads.
        steps: taken so far; the crank's turn is counted from it, as in a recorded run.
    """

    space: pymunk.Space
    crank: pymunk.Body
    pushed: Pushed
    timestep: float
    turn: float
    spin: float
    give: Callable[[float], object] | None = None
    steps: int = 0

    def __call__(self, steps: int) -> None:
        times = self.timestep * np.arange(self.steps, self.steps + steps)
        turns = (self.turn + self.spin * times).tolist()
        if self.give is None:
            repeat(self.space, self.crank, self.pushed, self.timestep, turns)
        else:
            for turn, time in zip(turns, times.tolist(), strict=True):
                self.crank.angle = turn
                self.give(time)
                self.space.step(self.timestep)
        self.steps += steps


def started(machine: Machine, settings: PymunkSettings) -> BareRun:
    """A machine in the exact state of its start."""
    angle, _ = run_of(machine, 1, 1.0)
    made = start_of(machine, settings, angle)
    driver, begun = made.mechanism.driver, angle / machine.speed
    pushes = pushes_of(made, settings)
    return BareRun(
        made.space,
        made.crank,
        made.pushed,
        timestep=settings.timestep,
        turn=made.mechanism.crank_turn(angle),
        spin=driver.sense * machine.speed,
        give=(lambda since: pushes.give(begun + since)) if pushes else None,
    )
