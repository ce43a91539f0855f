"""Steps with nothing recorded, which is what pymunk itself costs; and the slider-crank that timings are ratios to.

NEVER CHANGE THAT ONE: ratios of any date and machine relate to this very space. Ten iterations, pymunk's defaults, a
driven crank of 0.1 m, a rod of 0.3 m and a slider in a groove; no gravity, no shapes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pymunk

from conrod.engines.engine import Machine, run_of
from conrod.engines.pymunk.built import Pushed
from conrod.engines.pymunk.dynamics import started as start_of
from conrod.engines.pymunk.loads import pushes_of
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.stepping import repeat


def reference_loop() -> BareRun:
    """The slider-crank at its start: in line, the crank at one turn a second, 1000 steps a turn."""
    space = pymunk.Space()
    space.iterations = 10
    speed = 6.283185307179586
    crank = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    crank.angular_velocity = speed
    rod = pymunk.Body(1.5, 0.01125)
    rod.position, rod.velocity, rod.angular_velocity = (0.25, 0.0), (0.0, 0.05 * speed), -speed / 3.0
    slider = pymunk.Body(6.0, math.inf)
    slider.position = (0.4, 0.0)
    space.add(crank, rod, slider)
    space.add(
        pymunk.PivotJoint(crank, rod, (0.1, 0.0), (-0.15, 0.0)),
        pymunk.PivotJoint(rod, slider, (0.15, 0.0), (0.0, 0.0)),
        pymunk.GrooveJoint(space.static_body, slider, (-10.0, 0.0), (10.0, 0.0), (0.0, 0.0)),
    )
    return BareRun(space, crank, (), timestep=0.001, turn=0.0, spin=speed)


@dataclass
class BareRun:
    """A space with a driven crank; calling it advances it by so many steps.

    Attributes:
        turn: of the crank body at the start [rad].
        spin: its speed [rad/s].
        substeps: steps of the space, each of `timestep`, for one that is asked for.
        give: gives all bodies their forces for the step that begins so long [s] after the start; None without loads.
        steps: taken so far; the crank's turn is counted from it, as in a recorded run.
    """

    space: pymunk.Space
    crank: pymunk.Body
    pushed: Pushed
    timestep: float
    turn: float
    spin: float
    substeps: int = 1
    give: Callable[[float], object] | None = None
    steps: int = 0

    def __call__(self, steps: int) -> None:
        times = self.timestep * np.arange(self.substeps * self.steps, self.substeps * (self.steps + steps))
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
        timestep=settings.substep,
        turn=made.mechanism.crank_turn(angle),
        spin=driver.sense * machine.speed,
        substeps=settings.substeps,
        give=(lambda since: pushes.give(begun + since)) if pushes else None,
    )
