"""Plan of a motion without a prescribed crank: loads that act, duration, and steps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from conrod.engines.engine import Preset
from conrod.errors import InvalidInput
from conrod.exact.dynamics.forward import FreeMotion
from conrod.exact.joint_equations import pose_jets
from conrod.mechanism.loads import Load, SpeedLine, Steady, TimePulse, Turn
from conrod.mechanism.mechanism import GROUND, Mechanism

FREE, TORQUE = "free", "torque"
MOTIONS = (FREE, TORQUE)
DRIVING = (Steady, TimePulse, SpeedLine)  # laws that can drive a crank; friction, dampers and springs do not
SECONDS = 10.0
LONGEST_STEP = 0.005  # [s]
# Steps that the fastest turn has, at least. Contact is closed in a step, not by an equation, and needs shorter ones.
STEPS_A_TURN, CONTACT_STEPS_A_TURN = 100, 1000
FEWEST_INSTANTS, MOST_INSTANTS = 200, 2000
MOST_STEPS = 200_000
PATH = (1, 2, 4)  # the step is divided by these
LENGTH_ERROR = 1e-6  # of the length: what judged presets are held to


@dataclass(frozen=True)
class MotionPlan:
    """Plan of the runs.

    Attributes:
        motion: one of `MOTIONS`.
        seconds: length of the run [s].
        step: of the engines [s], None for that of the rule.
        tolerance: what every preset is judged by, by quantity; None for the rule.
    """

    motion: str
    seconds: float = SECONDS
    step: float | None = None
    tolerance: Mapping[str, float] | None = None

    @property
    def leaving(self) -> float:
        """The position error, of the length, whose first instant is reported."""
        return (self.tolerance or {}).get("position", LENGTH_ERROR)

    def judged_by(self, preset: Preset[Any]) -> dict[str, float]:
        """Tolerances of a preset by quantity, empty where it is only measured."""
        if self.tolerance is not None:
            return dict(self.tolerance)
        return {"position": LENGTH_ERROR} if preset.judged_free else {}

    def mechanism(self, mechanism: Mechanism, name: str) -> Mechanism:
        """The mechanism with the loads that act: all of them, or all but what drives the crank.

        Raises:
            InvalidInput: it is to be driven by a torque, and has none.
        """
        driving = [load for load in mechanism.loads if drives(load, mechanism)]
        if self.motion == TORQUE and not driving:
            raise InvalidInput(
                f"--motion torque: {name} has no torque that drives its crank; use --motion free, or give it one under "
                "[torques]"
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

    def finer(self, divisor: int) -> Grid:
        """The same instants with shorter steps."""
        return Grid(self.step / divisor, self.every * divisor, self.count)


def drives(load: Load, mechanism: Mechanism) -> bool:
    """True if a load is a torque from the ground that can drive the crank: constant, a pulse in time, a motor's."""
    along = load.along
    return isinstance(along, Turn) and {along.a, along.b} == {GROUND, mechanism.crank} and isinstance(load.law, DRIVING)


def instants(plan: MotionPlan) -> Grid:
    """Instants of a run, and the step with which they would be reached if the rule did not ask for a shorter one.

    Raises:
        InvalidInput: more steps than a run may have, or none.
    """
    if plan.step is not None:
        steps = round(plan.seconds / plan.step)
        if not 1 <= steps <= MOST_STEPS:
            raise InvalidInput(
                f"--step {plan.step:g} s in --seconds {plan.seconds:g}: {steps} steps; it must be 1 to {MOST_STEPS}"
            )
        every = math.ceil(steps / MOST_INSTANTS)
        return Grid(plan.step, every, steps // every)
    interval = LONGEST_STEP
    while plan.seconds / interval < FEWEST_INSTANTS:
        interval *= 0.5
    every = math.ceil(plan.seconds / interval / MOST_INSTANTS * (1.0 - 1e-12))
    return Grid(interval, every, math.floor(plan.seconds / interval / every * (1.0 + 1e-12)))


def chosen(plan: MotionPlan, grid: Grid, mechanism: Mechanism, motion: FreeMotion, shortest: float) -> Grid:
    """The rule of the step: 5 ms, halved until the fastest turn of the exact motion has a hundred of them.

    The fastest turn is found from the largest acceleration against the largest velocity of an observed point: 2 pi
    velocity / acceleration, which is the period of a point that turns or oscillates. A pulse of a load is held to be
    one, too.

    Args:
        shortest: pulse [s], inf where there is none.

    Raises:
        InvalidInput: nothing that is observed moves, or more steps than a run may have.
    """
    rate = pace(mechanism, motion)
    if plan.step is not None:
        return grid
    turn = min(2.0 * math.pi / rate, shortest)
    wanted = turn / (CONTACT_STEPS_A_TURN if mechanism.cam_contacts else STEPS_A_TURN)
    divisor = 1
    while grid.step / divisor > wanted:
        divisor *= 2
        if grid.finer(divisor).steps > MOST_STEPS:
            raise InvalidInput(
                f"{mechanism.name}: moves as fast as {rate:g} rad/s, and would take more than {MOST_STEPS} steps: give "
                "--seconds or --step"
            )
    return grid.finer(divisor)


def pace(mechanism: Mechanism, motion: FreeMotion) -> float:
    """Largest acceleration against the largest velocity [rad/s], of the observed point where that is most.

    Raises:
        InvalidInput: no observed point moves.
    """
    bodies = pose_jets(mechanism, [motion.poses, motion.rates, 0.5 * motion.accelerations])
    fastest = 0.0
    for point in mechanism.observed:
        x, y = (jet.coefficients for jet in bodies[point.body].point(point.point))
        velocity = float(np.hypot(x[1], y[1]).max())
        if velocity > 0.0:
            fastest = max(fastest, float(2.0 * np.hypot(x[2], y[2]).max()) / velocity)
    if fastest == 0.0:
        raise InvalidInput(f"{mechanism.name}: it stays at rest: there is no motion to compare; start it in motion")
    return fastest
