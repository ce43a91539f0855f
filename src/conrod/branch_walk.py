"""The walk along an assembly branch, from the start pose around the turn, in steps as small as the motion asks for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from conrod.equations import Equations
from conrod.errors import InvalidInput
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


@dataclass(frozen=True)
class _Place:
    """Where a walk is: crank angle [rad], poses there (1, 3 n) and their slope by the angle (1, 3 n)."""

    angle: float
    poses: Array
    slope: Array


class BranchWalk:
    """Poses on the branch of the start poses.

    Raises:
        InvalidInput: the mechanism cannot be assembled at crank angle 0.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations = equations

    @cached_property
    def start(self) -> Array:
        """Exact poses at crank angle 0; (1, 3 n)."""
        return self.equations.newton(self.equations.approximate, np.zeros(1))

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
        if self.table is None:
            return np.concatenate([self._walk(0.0, self.start, float(goal)) for goal in angle])
        guess = self.table.interpolate(angle)
        poses = self.equations.newton(guess, angle)
        for k in np.flatnonzero(self.equations.distance(poses, guess) > STRAYED):
            near, here = self.table.nearest(float(angle[k]))
            poses[k] = self._walk(near, here, float(angle[k]))[0]
        return poses

    @cached_property
    def table(self) -> PoseTable | None:
        """Poses over one full turn; None if the linkage does not reach all of it."""
        passed = [self._place(0.0, self.start)]
        try:
            for goal in np.linspace(0.0, 2.0 * np.pi, STEPS_PER_TURN + 1)[1:]:
                passed.extend(self._steps(passed[-1], float(goal)))
        except InvalidInput:
            return None
        stacked = np.concatenate([place.poses for place in passed])
        gain = self._gain(stacked[0], stacked[-1])
        angles = np.array([place.angle for place in passed])
        return self._refined(PoseTable(angles, stacked, self.equations.slope(stacked), gain))

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

    def _gain(self, first: Array, last: Array) -> Array:
        """What one turn adds to the poses: whole turns of bodies, and nothing else."""
        gain = (last - first).reshape(-1, 3)
        whole = 2.0 * np.pi * np.rint(gain[:, 2] / (2.0 * np.pi))
        if np.abs(gain[:, :2]).max() > 1e-9 * self.equations.size or np.abs(gain[:, 2] - whole).max() > 1e-9:
            name = self.equations.mechanism.name
            raise InvalidInput(f"{name} does not return to its start pose after one turn of the crank")
        return np.column_stack([np.zeros((len(gain), 2)), whole]).ravel()
