"""Continuation of an assembly branch by the crank angle, through change points and up to dead centres.

A single step follows the tangent dq/dtheta and is corrected by Newton iteration; it is used where the motion may be
blocked. Elsewhere many steps are taken at once, because the cost of a step is its overhead and not its arithmetic:
poses at the next angles are extrapolated from the last points and corrected together. Accepted are poses that single
steps would have reached: each lies where the tangent of the previous one leads, the tangent has no corner, and no
loop's determinant comes near zero. From the first that fails a test, single steps take over.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.change_points import ChangePoint, find_change_point
from conrod.exact.equations import Equations
from conrod.exact.motion import Array

Rows = NDArray[np.bool_] | slice
STEPS_PER_REVOLUTION, MIN_STEP = 64, 1e-9  # first step as a part of a revolution, and smallest step [rad]
STEP_ROUNDING = 1e-9  # share of a step by which rounding may miss the goal
MAX_NEWTON_STEPS = 10  # a good guess needs fewer
# A step is halved until the pose differs less from its tangent prediction (lengths against the size).
MAX_PREDICTION_ERROR = 0.02
# The tangent may change at most by this share of its size: where branches cross, a small step to the other branch is
# near the prediction too, but its tangent has a corner.
MAX_DERIVATIVE_CHANGE = 0.5
# If a step fails, or reduces the determinant below `DETERMINANT_DROP` of its value, a change point is searched for
# `SEARCH_STEPS` steps ahead, unless steps are smaller than `MIN_SEARCH_STEP` [rad].
DETERMINANT_DROP, SEARCH_STEPS, MIN_SEARCH_STEP = 0.5, 3.0, 1e-6
# A search resolves (1/16)^2 of its distance near the start: one from the same point that is not much shorter finds no
# more.
NEW_SEARCH_RATIO = 1.0 / 64.0
PREDICTION_POINTS = 3  # points from which many steps at once are extrapolated
MAX_STEPS_PER_REVOLUTION = 2000  # single steps tried, a hundred times those of any machine that ships


class TooManyStepsError(InvalidInput):
    """The tracking took more steps than any machine of sound dimensions needs, so its end is unknown."""


@dataclass(frozen=True)
class BranchPoint:
    """A solved pose on an assembly branch."""

    angle: float  # crank angle [rad]
    poses: Array  # (1, 3 n)
    derivative: Array  # dq/dtheta of the poses (1, 3 n)
    determinant: float  # of the Jacobian; its sign distinguishes branches


class BranchTracker:
    """Steps along the smooth motion of one mechanism from a point of its branch.

    Attributes:
        equations: equations of the mechanism.
        changes: change points that steps have passed so far.
        tries_left: number of single steps that may still be tried.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self.changes = ChangePointCache()
        self.tries_left = math.inf

    def point_at(self, angle: float, poses: Array) -> BranchPoint:
        """Return the branch point with poses (1, 3 n) at a crank angle [rad]."""
        factors = self.equations.elimination(poses)
        return BranchPoint(
            angle, poses, self.equations.pose_derivative(poses, factors=factors), float(factors.determinant()[0])
        )

    def solve_poses(self, guess: Array, angle: Array) -> Array:
        """Solve for poses (T, 3 n) by Newton iteration; near a change point by its series."""
        return self.changes.taylor_coefficients(
            angle, guess, 0, lambda rows: [self.equations.newton(guess[rows], angle[rows])]
        )[0]

    def pose_derivative(self, poses: Array, angle: Array) -> Array:
        """Return dq/dtheta (T, 3 n) of poses (T, 3 n); near a change point from its series."""
        return self.changes.taylor_coefficients(
            angle, poses, 1, lambda rows: [poses[rows], self.equations.pose_derivative(poses[rows])]
        )[1]

    def steps(self, here: BranchPoint, goal: float, last: float | None = None) -> Iterator[BranchPoint]:
        """Yield branch points from one point up to a goal angle.

        Args:
            here: the point to start from.
            goal: crank angle [rad] of the next wanted pose.
            last: crank angle [rad] of the last wanted pose: a step over a change point may pass `goal` up to there.

        Raises:
            InvalidInput: the linkage cannot move on.
            TooManyStepsError: no steps are left.
        """
        distance = goal - here.angle
        step = math.copysign(min(abs(distance), 2.0 * math.pi / STEPS_PER_REVOLUTION), distance)
        looked = math.inf  # the step [rad] at which a change point was looked for last from here
        while math.copysign(1.0, distance) * (goal - here.angle) > 0.0:
            self.tries_left -= 1
            if self.tries_left < 0:
                raise TooManyStepsError(self.too_many_steps_message(here.angle))
            # A step that falls short of the goal by rounding alone ends there.
            near = abs(goal - here.angle) <= (1.0 + STEP_ROUNDING) * abs(step)
            following = goal if near else here.angle + step
            reached = self._try_step(here, following)
            nearing = reached is None or abs(reached.determinant) < DETERMINANT_DROP * abs(here.determinant)
            if nearing and abs(step) <= NEW_SEARCH_RATIO * looked:
                looked = abs(step)
                reached = self._cross_change_point(here, step, goal if last is None else last) or reached
            if reached is not None:
                here, step, looked = reached, 2.0 * step, math.inf
                yield here
            elif abs(step) > MIN_STEP:
                step *= 0.5
            else:
                raise InvalidInput(self.equations.cannot_turn(np.array([following])))

    def too_many_steps_message(self, angle: float) -> str:
        """Error message for a crank angle [rad] beyond which every step has to be tiny."""
        return (
            f"{self.equations.mechanism.name}: its motion was not found beyond crank angle "
            f"{math.degrees(angle):.6g} deg, where every step has to be tiny; check lengths and their units"
        )

    def _try_step(self, point: BranchPoint, following: float) -> BranchPoint | None:
        """Return the point after a tangent step; None if it deviates from the tangent or changes branch."""
        guess = point.poses + point.derivative * (following - point.angle)
        try:
            poses = self.equations.newton(guess, np.array([following]), MAX_NEWTON_STEPS, falling=True)
        except InvalidInput:
            return None
        if self.equations.pose_distance(poses, guess)[0] > MAX_PREDICTION_ERROR:
            return None
        # The factors that give the branch give the derivative as well, for the step after this one.
        reached = self.point_at(following, poses)
        change = float(self.equations.pose_distance(reached.derivative, point.derivative)[0])
        largest = max(
            float(self.equations.pose_distance(derivative, 0.0 * poses)[0])
            for derivative in (point.derivative, reached.derivative)
        )
        return (
            None
            if reached.determinant * point.determinant <= 0.0 or change / largest > MAX_DERIVATIVE_CHANGE
            else reached
        )

    def _cross_change_point(self, point: BranchPoint, step: float, goal: float) -> BranchPoint | None:
        """Return the point beyond a change point nearby, or the goal if it comes first; else None."""
        if abs(step) < MIN_SEARCH_STEP:
            return None
        crossed = find_change_point(self.equations, point.angle, point.poses, SEARCH_STEPS * step)
        if crossed is None:
            return None
        change, angle, poses = crossed
        beyond = self.point_at(angle, poses)
        if np.sign(beyond.determinant) != np.sign(point.determinant) * (-1.0) ** change.gained_freedoms:
            return None
        self.changes.add(change)
        if abs(goal - point.angle) >= abs(angle - point.angle):
            return beyond
        ending = np.array([goal])
        poses = self.solve_poses(change.series(ending, 0)[0], ending)
        return BranchPoint(goal, poses, self.pose_derivative(poses, ending), math.nan)

    def steps_at_once(self, passed: Sequence[BranchPoint], goals: Array) -> list[BranchPoint]:
        """Return the branch points at the first goal angles, as many as pass all tests of a single step; maybe none.

        Args:
            passed: points tracked so far, the current one last.
            goals: angles (T,) [rad] in the order of the motion.
        """
        goals = goals[: _first_true(self.changes.covers(goals))]
        if not len(goals):
            return []
        equations, here = self.equations, passed[-1]
        try:
            poses = equations.newton(_extrapolate(passed[-PREDICTION_POINTS:], goals), goals)
        except (InvalidInput, np.linalg.LinAlgError):  # the points passed may lie too close to each other
            return []
        poses = np.concatenate([here.poses, poses])
        factors = equations.elimination(poses)
        derivatives, blocks = equations.pose_derivative(poses, factors=factors), factors.block_determinants()
        widths = np.diff(goals, prepend=here.angle)[:, None]
        none = np.zeros_like(derivatives)
        steep = equations.pose_distance(derivatives, none)
        doubtful = (
            (equations.pose_distance(poses[1:], poses[:-1] + widths * derivatives[:-1]) > MAX_PREDICTION_ERROR)
            | (
                equations.pose_distance(derivatives[1:], derivatives[:-1])
                > MAX_DERIVATIVE_CHANGE * np.maximum(steep[1:], steep[:-1])
            )
            | ~(blocks[1:] * np.sign(blocks[:-1]) >= DETERMINANT_DROP * np.abs(blocks[:-1])).all(axis=1)
        )
        determinants = factors.determinant()
        return [
            BranchPoint(float(goals[k - 1]), poses[k : k + 1], derivatives[k : k + 1], float(determinants[k]))
            for k in range(1, _first_true(doubtful) + 1)
        ]


def _first_true(marked: NDArray[np.bool_]) -> int:
    """Index of the first true entry of a mask; its length if none is true."""
    return int(np.argmax([*marked, True]))


def _extrapolate(passed: Sequence[BranchPoint], goals: Array) -> Array:
    """Extrapolate poses (T, 3 n) to goal angles by the Hermite polynomial through the points passed."""
    angles = np.array([place.angle for place in passed])
    width = max(float(np.ptp(angles)), abs(float(goals[0] - angles[-1])))
    at, powers = (angles[:, None] - angles[-1]) / width, np.arange(2 * len(angles))
    rates = np.where(powers > 0, powers * at ** np.maximum(powers - 1, 0), 0.0)
    given = np.concatenate([*(place.poses for place in passed), *(width * place.derivative for place in passed)])
    coefficients = np.linalg.solve(np.concatenate([at**powers, rates]), given)
    return np.asarray(((goals[:, None] - angles[-1]) / width) ** powers @ coefficients)


SAME_CHANGE_POINT = 1e-6  # [rad], distance below which two change points found are one


class ChangePointCache:
    """Change points found so far, sorted by crank angle, so that each is searched for once."""

    def __init__(self) -> None:
        self._changes: list[ChangePoint] = []

    def add(self, change: ChangePoint) -> None:
        """Add a change point unless it is known already."""
        if not any(abs(change.angle - known.angle) < SAME_CHANGE_POINT for known in self._changes):
            self._changes.append(change)
            self._changes.sort(key=lambda known: known.angle)

    def add_period_images(self, turn: float, gain: Array) -> None:
        """Add the images of all change points one period before and after them.

        Args:
            turn: period of the motion [rad].
            gain: change (3 n,) of the poses over one period.
        """
        for change in list(self._changes):
            for turns in (-1.0, 1.0):
                shifted = change.coefficients.copy()
                shifted[0] += turns * gain
                self.add(replace(change, angle=change.angle + turns * turn, coefficients=shifted))

    @property
    def angles(self) -> Array:
        """Crank angles [rad] of the change points, ascending."""
        return np.array([change.angle for change in self._changes])

    def covers(self, angle: Array, distance: float | None = None) -> NDArray[np.bool_]:
        """Mask (T,) of angles [rad] within a distance of a change point, by default where its series holds."""
        result = np.zeros(len(angle), dtype=bool)
        for change in self._changes:
            result |= change.covers(angle) if distance is None else np.abs(angle - change.angle) < distance
        return result

    def taylor_coefficients(
        self, angle: Array, poses: Array, order: int, regular: Callable[[Rows], list[Array]]
    ) -> list[Array]:
        """Return Taylor coefficients of poses (T, 3 n) up to an order, from a change point's series where it holds.

        Args:
            regular: computes the coefficients of the given rows, where no change point is near.
        """
        far = ~self.covers(angle)
        if far.all():
            return regular(slice(None))
        found = np.empty((order + 1, *poses.shape))
        if far.any():
            found[:, far] = regular(far)
        for change in self._changes:
            if (near := change.covers(angle)).any():
                found[:, near] = change.series(angle[near], order)
        return list(found)

    def determinant_sign(self, angle: Array) -> Array:
        """Sign (T,) of the Jacobian's determinant at angles (T,) [rad], over its sign at crank angle 0."""
        result = np.ones(len(angle))
        for change in self._changes:
            if change.gained_freedoms % 2:
                result[(angle > change.angle) != (change.angle < 0.0)] *= -1.0
        return result
