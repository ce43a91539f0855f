"""The walk along an assembly branch, from the start pose around the turn, in steps as small as the motion asks for."""

from __future__ import annotations

import math
from collections.abc import Iterator
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


class BranchWalk:
    """Poses on the branch of the start poses.

    Raises:
        InvalidInput: the mechanism cannot be assembled at crank angle 0.
    """

    def __init__(self, equations: Equations) -> None:
        self._equations = equations

    @cached_property
    def start(self) -> Array:
        """Exact poses at crank angle 0; (1, 3 n)."""
        return self._equations.newton(self._equations.approximate, np.zeros(1))

    @cached_property
    def branch(self) -> float:
        """The branch that the start poses picked, +1 or -1."""
        return float(self.branch_of(self.start)[0])

    def branch_of(self, poses: Array) -> Array:
        """Sign of the determinant of the Jacobian (T,); it tells assembly branches apart."""
        return self._equations.elimination(poses).determinant_sign()

    def poses(self, angle: Array) -> Array:
        """Exact poses (T, 3 n) at crank angles (T,) [rad].

        Raises:
            InvalidInput: the linkage does not reach an angle.
        """
        if self.table is None:
            return np.concatenate([self._walk(0.0, self.start, float(goal)) for goal in angle])
        guess = self.table.interpolate(angle)
        poses = self._equations.newton(guess, angle)
        for k in np.flatnonzero(self._equations.distance(poses, guess) > STRAYED):
            near, here = self.table.nearest(float(angle[k]))
            poses[k] = self._walk(near, here, float(angle[k]))[0]
        return poses

    @cached_property
    def table(self) -> PoseTable | None:
        """Poses over one full turn; None if the linkage does not reach all of it."""
        angles, poses = [0.0], [self.start]
        try:
            for goal in np.linspace(0.0, 2.0 * np.pi, STEPS_PER_TURN + 1)[1:]:
                for angle, here in self._steps(angles[-1], poses[-1], float(goal)):
                    angles.append(angle)
                    poses.append(here)
        except InvalidInput:
            return None
        stacked = np.concatenate(poses)
        gain = self._gain(stacked[0], stacked[-1])
        return self._refined(PoseTable(np.array(angles), stacked, self._equations.slope(stacked), gain))

    def _refined(self, table: PoseTable) -> PoseTable:
        """The table with a row more in every interval that it does not predict well in its middle."""
        for _ in range(REFINEMENTS):
            middle = 0.5 * (table.angles[:-1] + table.angles[1:])
            guess = table.interpolate(middle)
            poses = self._equations.newton(guess, middle)
            miss = self._equations.distance(poses, guess)
            for k in np.flatnonzero(miss > STRAYED):
                poses[k] = self._walk(float(table.angles[k]), table.poses[k : k + 1], float(middle[k]))[0]
            coarse = miss > TABLE_MISS
            if not coarse.any():
                break
            table = table.with_rows(middle[coarse], poses[coarse], self._equations.slope(poses[coarse]))
        return table

    def _walk(self, angle: float, poses: Array, goal: float) -> Array:
        """Poses (1, 3 n) at a goal angle, reached from those at another without leaving the branch."""
        return [poses, *(reached for _, reached in self._steps(angle, poses, goal))][-1]

    def _steps(self, angle: float, poses: Array, goal: float) -> Iterator[tuple[float, Array]]:
        """Angles and poses on the way to a goal.

        Raises:
            InvalidInput: the linkage goes no further.
        """
        step = math.copysign(min(abs(goal - angle), 2.0 * math.pi / STEPS_PER_TURN), goal - angle)
        while angle != goal:
            following = goal if abs(goal - angle) <= abs(step) else angle + step
            reached = self._try_step(angle, poses, following)
            if reached is not None:
                angle, poses, step = following, reached, 2.0 * step
                yield angle, poses
            elif abs(step) > LEAST_STEP:
                step *= 0.5
            else:
                raise InvalidInput(self._equations.cannot_turn(np.array([following])))

    def _try_step(self, angle: float, poses: Array, following: float) -> Array | None:
        """Poses after a step along the tangent; None if they strayed from it or changed branch."""
        guess = poses + self._equations.slope(poses) * (following - angle)
        try:
            reached = self._equations.newton(guess, np.array([following]))
        except InvalidInput:
            return None
        if self._equations.distance(reached, guess)[0] > WALK_MISS:
            return None
        return reached if self.branch_of(reached)[0] == self.branch else None

    def _gain(self, first: Array, last: Array) -> Array:
        """What one turn adds to the poses: whole turns of bodies, and nothing else."""
        gain = (last - first).reshape(-1, 3)
        whole = 2.0 * np.pi * np.rint(gain[:, 2] / (2.0 * np.pi))
        if np.abs(gain[:, :2]).max() > 1e-9 * self._equations.size or np.abs(gain[:, 2] - whole).max() > 1e-9:
            name = self._equations.mechanism.name
            raise InvalidInput(f"{name} does not return to its start pose after one turn of the crank")
        return np.column_stack([np.zeros((len(gain), 2)), whole]).ravel()
