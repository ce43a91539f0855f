"""Plan of a motion without a prescribed crank: loads that act, duration, and steps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from conrod.engines.tracks import Pace
from conrod.errors import InvalidInput
from conrod.exact.dynamics.forward import FreeMotion
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import Load, SpeedLine, Steady, TimePulse, Turn
from conrod.mechanism.mechanism import GROUND, Mechanism

FREE, TORQUE = "free", "torque"
MOTIONS = (FREE, TORQUE)
DRIVING = (Steady, TimePulse, SpeedLine)  # laws that can drive a crank; friction, dampers and springs do not
SECONDS, TURNS = 10.0, 50.0  # what a run lasts, and at most so many of the fastest turns: phase errors grow with them
LONGEST_STEP = 0.005  # [s]
# Steps that the fastest turn has, at least. Contact is closed in a step, not by an equation, and needs shorter ones.
# Where branches cross, shorter ones change nothing but how near one comes to the crossing, and what is rounded there.
STEPS_A_TURN, CONTACT_STEPS_A_TURN, CROSSING_STEPS_A_TURN = 800, 1000, 100
FEWEST_INSTANTS, MOST_INSTANTS = 1000, 2000  # enough to see how fast a link whips round
MOST_STEPS = 200_000
PATH = (1, 2, 4)  # the step is divided by these
LENGTH_ERROR = 1e-6  # of the length: what judged presets are held to


@dataclass(frozen=True)
class MotionPlan:
    """Plan of the runs.

    Attributes:
        motion: one of `MOTIONS`.
        seconds: length of the run [s], None for that of the rule.
        step: of the engines [s], None for that of the rule.
        tolerance: what every preset is judged by, by quantity; None for the rule.
    """

    motion: str
    seconds: float | None = None
    step: float | None = None
    tolerance: Mapping[str, float] | None = None

    @property
    def leaving(self) -> float:
        """The position error, of the length, whose first instant is reported."""
        return (self.tolerance or {}).get("position", LENGTH_ERROR)

    def mechanism(self, mechanism: Mechanism, name: str) -> Mechanism:
        """The mechanism with the loads that act: all of them, or all but what drives the crank.

        Raises:
            InvalidInput: it is to be driven by a torque, and has none.
        """
        driving = [load for load in mechanism.loads if drives(load, mechanism)]
        if self.motion == TORQUE and not driving:
            raise InvalidInput(
                f"--torque: {name} has no torque that drives its crank; let it go without --torque, or give it one "
                "under [torques]"
            )
        if self.motion == TORQUE:
            return mechanism
        return replace(mechanism, loads=tuple(load for load in mechanism.loads if load not in driving))


@dataclass(frozen=True)
class Grid:
    """Instants at which a run is recorded, each so many steps after the other.

    Attributes:
        step: of the engines [s].
        every: steps between two instants.
        count: of the instants after the start.
    """

    step: float
    every: int
    count: int

    @property
    def steps(self) -> int:
        """In all."""
        return self.every * self.count

    @property
    def times(self) -> Array:
        """Of the instants and the start [s]."""
        return np.asarray(self.step * self.every * np.arange(self.count + 1), dtype=float)

    def finer(self, divisor: int) -> Grid:
        """The same instants with shorter steps."""
        return Grid(self.step / divisor, self.every * divisor, self.count)


def drives(load: Load, mechanism: Mechanism) -> bool:
    """True if a load is a torque from the ground that can drive the crank: constant, a pulse in time, a motor's."""
    along = load.along
    return isinstance(along, Turn) and {along.a, along.b} == {GROUND, mechanism.crank} and isinstance(load.law, DRIVING)


def instants(plan: MotionPlan, seconds: float) -> Grid:
    """Instants of a run of so long [s], and the step that reaches them where the rule does not ask for a shorter one.

    Raises:
        InvalidInput: more steps than a run may have, or none.
    """
    if plan.step is not None:
        steps = round(seconds / plan.step)
        if not 1 <= steps <= MOST_STEPS:
            raise InvalidInput(
                f"--step {plan.step:g} s in --seconds {seconds:g}: {steps} steps; it must be 1 to {MOST_STEPS}"
            )
        every = math.ceil(steps / MOST_INSTANTS)
        return Grid(plan.step, every, steps // every)
    interval = LONGEST_STEP
    while seconds / interval < FEWEST_INSTANTS:
        interval *= 0.5
    every = math.ceil(seconds / interval / MOST_INSTANTS * (1.0 - 1e-12))
    return Grid(interval, every, math.floor(seconds / interval / every * (1.0 + 1e-12)))


def chosen(plan: MotionPlan, grid: Grid, mechanism: Mechanism, pace: Pace) -> Grid:
    """The rule of the step: 5 ms, divided so that the fastest turn of the exact motion has as many as it needs.

    Raises:
        InvalidInput: more steps than a run may have.
    """
    if plan.step is not None:
        return grid
    usual = CROSSING_STEPS_A_TURN if pace.crosses_branches else STEPS_A_TURN
    finer = grid.finer(
        math.ceil(grid.step / pace.revolution * (CONTACT_STEPS_A_TURN if mechanism.cam_contacts else usual))
    )
    if finer.steps > MOST_STEPS:
        raise InvalidInput(
            f"{mechanism.name}: its fastest turn takes {pace.revolution:.3g} s, and the run more than "
            f"{MOST_STEPS} steps: give --seconds or --step"
        )
    return finer


def fastest_turn(mechanism: Mechanism, motion: FreeMotion) -> float:
    """The period of a point that turns or oscillates [s]: 2 pi largest velocity / largest acceleration.

    Of the observed point where it is shortest; inf where none moves.
    """
    bodies = pose_jets(mechanism, [motion.poses, motion.rates, 0.5 * motion.accelerations])
    fastest = 0.0
    for point in mechanism.observed:
        x, y = (jet.coefficients for jet in bodies[point.body].point(point.point))
        velocity = float(np.hypot(x[1], y[1]).max())
        if velocity > 0.0:
            fastest = max(fastest, float(2.0 * np.hypot(x[2], y[2]).max()) / velocity)
    return 2.0 * math.pi / fastest if fastest else math.inf
