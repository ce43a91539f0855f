"""Plan of a motion without a prescribed crank: acting loads, duration, and step size."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from conrod.engines.tracks import Pace
from conrod.errors import InvalidInput
from conrod.exact.dynamics.forward import FreeMotion
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.execution.tolerances import Limit, UnscaledLimit
from conrod.mechanism.loads import Load, SpeedLine, Steady, TimePulse, Turn
from conrod.mechanism.mechanism import GROUND, Mechanism

FREE, TORQUE = "free", "torque"
MOTIONS = (FREE, TORQUE)
DRIVING_LAWS = (Steady, TimePulse, SpeedLine)  # laws that can drive a crank; friction, dampers and springs do not
# Limits of a run's duration by rule, [s] and in fastest turns: phase errors grow with the number of turns.
MAX_SECONDS, MAX_TURNS = 10.0, 50.0
MAX_STEP = 0.005  # [s]
# Least steps in the fastest turn. Contact is closed within a step, not by an equation, and needs shorter steps. Where
# branches cross, shorter steps only change how near the crossing a step comes, and how much is rounded there.
STEPS_PER_TURN, CONTACT_STEPS_PER_TURN, CROSSING_STEPS_PER_TURN = 800, 1000, 100
MIN_INSTANTS, MAX_INSTANTS = 1000, 2000  # recorded in a run: enough for the fastest motion of a link
MAX_STEPS = 200_000  # of a run
# Step sizes along the refinement path, as divisors of the run's. A step by rule is so short that longer ones show the
# order where shorter ones show rounding, at a quarter of the cost. Longer ones do not hold through contact or where
# branches cross, and a step of the user's may be any.
COARSER_STEPS, FINER_STEPS = (Fraction(1, 4), Fraction(1, 2), Fraction(1)), (Fraction(1), Fraction(2), Fraction(4))
POSITION_TOLERANCE = 1e-6  # of L, for judged presets


@dataclass(frozen=True)
class MotionPlan:
    """Plan of the runs of free motion.

    Attributes:
        motion: one of `MOTIONS`; with `FREE`, loads that can drive the crank do not act.
        seconds: duration of the run [s]; None for that by rule (`exact.run_duration`).
        step: step size of the engines [s]; None for that by rule (`refine_grid`).
        tolerance: allowed errors of every preset, by quantity; None for `POSITION_TOLERANCE` of judged presets.
        step_factor: on the step size; 1 but for the last bits, for what rounding makes of the results.
    """

    motion: str
    seconds: float | None = None
    step: float | None = None
    tolerance: Mapping[str, Limit] | None = None
    step_factor: float = 1.0

    @property
    def leaving(self) -> float:
        """Position error, over L, at whose first instant a run leaves the exact motion."""
        asked = (self.tolerance or {}).get("position", POSITION_TOLERANCE)
        return POSITION_TOLERANCE if isinstance(asked, UnscaledLimit) else asked

    def keep_acting_loads(self, mechanism: Mechanism, name: str) -> Mechanism:
        """Return the mechanism with all loads, or without the loads that can drive the crank.

        Raises:
            InvalidInput: the motion is driven by a torque, and no load drives the crank.
        """
        driving = [load for load in mechanism.loads if drives_crank(load, mechanism)]
        if self.motion == TORQUE and not driving:
            raise InvalidInput(
                f"--torque: {name} has no torque that drives its crank; let it go without --torque, or give it one "
                "under [torques]"
            )
        if self.motion == TORQUE:
            return mechanism
        return replace(mechanism, loads=tuple(load for load in mechanism.loads if load not in driving))


@dataclass(frozen=True)
class TimeGrid:
    """Equally spaced instants at which a run is recorded, and the engine's steps between them.

    Attributes:
        step: step size of the engine [s].
        stride: steps between two instants.
        count: number of instants after the start.
    """

    step: float
    stride: int
    count: int

    @property
    def steps(self) -> int:
        """Number of steps of the run."""
        return self.stride * self.count

    @property
    def times(self) -> Array:
        """Times (count + 1,) [s] of the instants, the start included."""
        return np.asarray(self.step * self.stride * np.arange(self.count + 1), dtype=float)

    def with_shorter_steps(self, divisor: int) -> TimeGrid:
        """Return the same instants with the step size divided by an integer."""
        return TimeGrid(self.step / divisor, self.stride * divisor, self.count)

    def with_step_divided(self, divisor: Fraction) -> tuple[TimeGrid, int]:
        """Return a grid with the step size divided, and how many instants of this grid one of its intervals spans.

        That is 1 unless a longer step does not lead to each instant.
        """
        steps = self.stride * divisor  # in the time between two instants
        return TimeGrid(self.step / float(divisor), steps.numerator, self.count // steps.denominator), steps.denominator


def drives_crank(load: Load, mechanism: Mechanism) -> bool:
    """True if a load is a torque from ground to crank whose law can drive it (`DRIVING_LAWS`)."""
    along = load.along
    return (
        isinstance(along, Turn)
        and {along.a, along.b} == {GROUND, mechanism.crank}
        and isinstance(load.law, DRIVING_LAWS)
    )


def initial_grid(plan: MotionPlan, seconds: float) -> TimeGrid:
    """Return the grid of a run over a duration [s], with the longest step size that may be used.

    By rule the step is 5 ms, halved until there are at least `MIN_INSTANTS` steps.

    Raises:
        InvalidInput: the number of steps is not 1 to `MAX_STEPS`.
    """
    if plan.step is not None:
        steps = round(seconds / plan.step)
        if not 1 <= steps <= MAX_STEPS:
            raise InvalidInput(
                f"--step {plan.step:g} s in --seconds {seconds:g}: {steps} steps; it must be 1 to {MAX_STEPS}"
            )
        stride = math.ceil(steps / MAX_INSTANTS)
        return TimeGrid(plan.step, stride, steps // stride)
    interval = MAX_STEP
    while seconds / interval < MIN_INSTANTS:
        interval *= 0.5
    stride = math.ceil(seconds / interval / MAX_INSTANTS * (1.0 - 1e-12))
    return TimeGrid(interval, stride, math.floor(seconds / interval / stride * (1.0 + 1e-12)))


def refine_grid(plan: MotionPlan, grid: TimeGrid, mechanism: Mechanism, pace: Pace) -> TimeGrid:
    """Divide the step size until the fastest turn of the exact motion has enough steps.

    Enough is `STEPS_PER_TURN`, or its variants for contact and where branches cross. A step size of the plan stays.

    Raises:
        InvalidInput: more than `MAX_STEPS` steps.
    """
    if plan.step is not None:
        return grid
    usual = CROSSING_STEPS_PER_TURN if pace.crosses_branches else STEPS_PER_TURN
    finer = grid.with_shorter_steps(
        math.ceil(grid.step / pace.revolution * (CONTACT_STEPS_PER_TURN if mechanism.cam_contacts else usual))
    )
    if finer.steps > MAX_STEPS:
        raise InvalidInput(
            f"{mechanism.name}: its fastest turn takes {pace.revolution:.3g} s, and the run more than "
            f"{MAX_STEPS} steps: give --seconds or --step"
        )
    return finer


def refinement_steps(plan: MotionPlan, mechanism: Mechanism, pace: Pace) -> tuple[Fraction, ...]:
    """Return the divisors of the step size along the refinement path, by growing number of steps."""
    delicate = plan.step is not None or mechanism.cam_contacts or pace.crosses_branches
    return FINER_STEPS if delicate else COARSER_STEPS


def fastest_turn_period(mechanism: Mechanism, motion: FreeMotion) -> float:
    """Return the shortest period 2 pi max|v| / max|a| of observed points [s]; inf if none moves.

    That is the period of a point which moves on a circle, or oscillates harmonically.
    """
    bodies = pose_jets(mechanism, [motion.poses, motion.rates, 0.5 * motion.accelerations])
    fastest = 0.0
    for point in mechanism.observed:
        x, y = (jet.coefficients for jet in bodies[point.body].point(point.point))
        velocity = float(np.hypot(x[1], y[1]).max())
        if velocity > 0.0:
            fastest = max(fastest, float(2.0 * np.hypot(x[2], y[2]).max()) / velocity)
    return 2.0 * math.pi / fastest if fastest else math.inf
