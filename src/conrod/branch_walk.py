"""The walk along an assembly branch from the start pose, around the turn or over a span, in steps that it allows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from conrod.equations import Equations
from conrod.errors import InvalidInput
from conrod.mesh_geometry import check_meshes
from conrod.motion import Array
from conrod.pose_table import PoseTable

STEPS_PER_TURN, LEAST_STEP = 64, 1e-12  # of the walk around the turn; the least one [rad]
# A step of the walk is halved until its straight prediction is this good (lengths against the size), and keeps the
# branch.
WALK_MISS = 0.02
# The table is refined until it predicts every pose this well, and no pose may lie further from its prediction: a
# Newton iteration that moves more has left for another branch.
TABLE_MISS, REFINEMENTS = 1e-5, 16
STRAYED = 1e-3
# What poses may differ by after a turn and yet be the same (lengths against the size).
RETURNED = 1e-9


@dataclass(frozen=True)
class _Place:
    """Where a walk is: crank angle [rad], poses there (1, 3 n) and their slope by the angle (1, 3 n)."""

    angle: float
    poses: Array
    slope: Array


class BranchWalk:
    """Poses on the branch of the start poses.

    Raises:
        InvalidInput: the mechanism cannot be assembled at crank angle 0, or wheels that roll do not touch there.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self._longer: PoseTable | None = None

    @cached_property
    def start(self) -> Array:
        """Exact poses at crank angle 0; (1, 3 n)."""
        start = self.equations.newton(self.equations.approximate, np.zeros(1))
        check_meshes(self.equations.mechanism, start)
        return start

    @cached_property
    def branch(self) -> float:
        """The branch that the start poses picked, +1 or -1."""
        return float(self.branch_of(self.start)[0])

    def branch_of(self, poses: Array) -> Array:
        """Sign of the determinant of the Jacobian (T,); it tells assembly branches apart."""
        return self.equations.elimination(poses).determinant_sign()

    def poses(self, angle: Array) -> Array:
        """Exact poses (T, 3 n) at crank angles (T,) [rad].

        Raises:
            InvalidInput: the linkage does not reach an angle.
        """
        table = self._reaching(angle)
        if table is None:
            return np.concatenate([self._walk(0.0, self.start, float(goal)) for goal in angle])
        guess = table.interpolate(angle)
        poses = self.equations.newton(guess, angle)
        for k in np.flatnonzero(self.equations.distance(poses, guess) > STRAYED):
            near, here = table.nearest(float(angle[k]))
            poses[k] = self._walk(near, here, float(angle[k]))[0]
        return poses

    @cached_property
    def table(self) -> PoseTable | None:
        """Poses over one full turn, or over the driver's span; None if the linkage does not reach all of the turn.

        Raises:
            InvalidInput: the linkage does not reach all of the span.
        """
        span = self.equations.mechanism.driver.span
        _ = self.start  # what is wrong there is told, and not taken for a limit of the turn
        try:
            table = self._stretch(*(span or (0.0, 2.0 * np.pi)))
        except InvalidInput:
            if span is not None:
                raise
            return None
        check_meshes(self.equations.mechanism, table.poses)
        return table if span is not None else replace(table, gain=self._gain(table))

    def _reaching(self, angle: Array) -> PoseTable | None:
        """The table, with the turns added that the angles ask for where poses do not repeat after a turn."""
        if self.table is None or self.table.covers(angle).all() or self.equations.mechanism.driver.span is not None:
            return self.table
        table = self._longer or self.table
        if not table.covers(angle).all():
            first, last = min(table.angles[0], angle.min()), max(table.angles[-1], angle.max())
            turn = 2.0 * math.pi
            # Whole turns: the next angle asked for is often a little further.
            self._longer = table = self._stretch(turn * math.floor(first / turn), turn * math.ceil(last / turn))
        return table

    def _stretch(self, first: float, last: float) -> PoseTable:
        """Poses from one crank angle to another, with 0 between them."""
        forth, back = self._passed(last), self._passed(first)
        places = [*reversed(back[1:]), *forth]
        stacked = np.concatenate([place.poses for place in places])
        angles = np.array([place.angle for place in places])
        return self._refined(PoseTable(angles, stacked, self.equations.slope(stacked), None))

    def _passed(self, goal: float) -> list[_Place]:
        """Places from the start to an angle, in steps of no more than one of the turn's."""
        passed = [self._place(0.0, self.start)]
        steps = math.ceil(abs(goal) / (2.0 * math.pi) * STEPS_PER_TURN)
        for following in np.linspace(0.0, goal, steps + 1)[1:]:
            passed.extend(self._steps(passed[-1], float(following)))
        return passed

    def _refined(self, table: PoseTable) -> PoseTable:
        """The table with a row more in every interval that it does not predict well in its middle."""
        for _ in range(REFINEMENTS):
            middle = 0.5 * (table.angles[:-1] + table.angles[1:])
            guess = table.interpolate(middle)
            poses = self.equations.newton(guess, middle)
            miss = self.equations.distance(poses, guess)
            for k in np.flatnonzero(miss > STRAYED):
                poses[k] = self._walk(float(table.angles[k]), table.poses[k : k + 1], float(middle[k]))[0]
            coarse = miss > TABLE_MISS
            if not coarse.any():
                break
            table = table.with_rows(middle[coarse], poses[coarse], self.equations.slope(poses[coarse]))
        return table

    def _walk(self, angle: float, poses: Array, goal: float) -> Array:
        """Poses (1, 3 n) at a goal angle, reached from those at another without leaving the branch."""
        here = self._place(angle, poses)
        return [here, *self._steps(here, goal)][-1].poses

    def _place(self, angle: float, poses: Array) -> _Place:
        return _Place(angle, poses, self.equations.slope(poses))

    def reach(self, goal: float) -> float:
        """The crank angle [rad] where the way from the start to a goal ends; the goal, if nothing ends it before."""
        here = self._place(0.0, self.start)
        with suppress(InvalidInput):
            for passed in self._steps(here, goal):
                here = passed
        return here.angle

    def _steps(self, here: _Place, goal: float) -> Iterator[_Place]:
        """Places on the way to a goal.

        Raises:
            InvalidInput: the linkage goes no further.
        """
        way = goal - here.angle
        step = math.copysign(min(abs(way), 2.0 * math.pi / STEPS_PER_TURN), way)
        while here.angle != goal:
            following = goal if abs(goal - here.angle) <= abs(step) else here.angle + step
            reached = self._try_step(here, following)
            if reached is not None:
                here, step = reached, 2.0 * step
                yield here
            elif abs(step) > LEAST_STEP:
                step *= 0.5
            else:
                raise InvalidInput(self.equations.cannot_turn(np.array([following])))

    def _try_step(self, here: _Place, following: float) -> _Place | None:
        """The place after a step along the tangent; None if it strayed from it or changed branch."""
        guess = here.poses + here.slope * (following - here.angle)
        try:
            reached = self.equations.newton(guess, np.array([following]))
        except InvalidInput:
            return None
        if self.equations.distance(reached, guess)[0] > WALK_MISS:
            return None
        # The factors that tell the branch give the slope as well, for the step after this one.
        factors = self.equations.elimination(reached)
        if factors.determinant_sign()[0] != self.branch:
            return None
        return _Place(following, reached, self.equations.slope(reached, factors=factors))

    def _gain(self, turn: PoseTable) -> Array | None:
        """What one turn adds to the poses: turns of bodies, and nothing else; None if the next turn is another one."""
        gain = (turn.poses[-1] - turn.poses[0]).reshape(-1, 3)
        whole = 2.0 * np.pi * np.rint(gain[:, 2] / (2.0 * np.pi))
        if np.abs(gain[:, :2]).max() > RETURNED * self.equations.size:
            return None
        if np.abs(gain[:, 2] - whole).max() <= RETURNED:
            return np.column_stack([np.zeros((len(gain), 2)), whole]).ravel()
        # Wheels may turn by any part of a turn, as long as nothing tells one of their turns from the next.
        added = np.column_stack([np.zeros((len(gain), 2)), gain[:, 2]]).ravel()
        left = self.equations.residual([turn.poses + added], turn.angles + 2.0 * np.pi)
        repeats = max(float(np.abs(equation).max()) for equation in left) <= RETURNED * self.equations.size
        return added if repeats else None
