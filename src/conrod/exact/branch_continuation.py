"""Continuation along an assembly branch by the crank angle, through change points and up to dead centres.

Step by step where the way may be blocked. Where nothing is in the way, many steps at once: what takes time in a step is
not its arithmetic, so that many together cost little more than one. Poses at the next angles are guessed from the last
places and made exact together; those are taken that single steps would have taken: each lies where the tangent of the
one before leads to, without a corner, and no loop's determinant comes near zero on the way. The first that does not is
left to single steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.change_points import ChangePoint, crossing
from conrod.exact.equations import Equations
from conrod.exact.motion import Array

Rows = NDArray[np.bool_] | slice
STEPS_PER_TURN, LEAST_STEP = 64, 1e-9  # of the walk around the turn; the least one [rad]
SAME_STEP = 1e-9
ATTEMPTS = 10  # of Newton iteration, which needs fewer from a guess that is good enough
# A step of the walk is halved until its straight prediction is this good (lengths against the size), and keeps the
# branch.
WALK_MISS = 0.02
# Nor may the slope change by more than this part of itself: where branches cross, a small step to the other one is no
# further than that, but turns a corner.
WALK_BEND = 0.5
# Where a step fails, or takes the determinant below this part of what it was, a change point is looked for so many
# steps ahead, unless steps are this small already [rad].
NEARING, LOOK_AHEAD, LEAST_LOOK = 0.5, 3.0, 1e-6
# Points of a look are closest where it begins, and resolve (1/16)^2 of its way: a second one from the same place, not
# much shorter, sees no more.
LOOK_AGAIN = 1.0 / 64.0
KNOWN = 3  # places that many steps at once are guessed from
# Single steps that may be tried in a turn: a hundred times those of any machine that ships.
MOST_TRIES = 2000


class OutOfSteps(InvalidInput):
    """The walk took more steps than any machine of sound dimensions needs: where it would end is not known."""


@dataclass(frozen=True)
class BranchPoint:
    """A crank angle [rad], poses there (1, 3 n), their slope by the angle (1, 3 n), the Jacobian's determinant."""

    angle: float
    poses: Array
    slope: Array
    determinant: float


class BranchContinuation:
    """The smooth motion of one mechanism.

    Attributes:
        equations: the mechanism's.
        changes: the change points that steps have come through so far.
        tries_left: single steps that may still be tried.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self.changes = ChangePointCache()
        self.tries_left = math.inf

    def place(self, angle: float, poses: Array) -> BranchPoint:
        """The point of the branch with poses (1, 3 n) at a crank angle [rad]."""
        factors = self.equations.elimination(poses)
        return BranchPoint(angle, poses, self.equations.slope(poses, factors=factors), float(factors.determinant()[0]))

    def solved(self, guess: Array, angle: Array) -> Array:
        """Poses (T, 3 n) of the turn or stretch, by Newton iteration; near a change point by its series."""
        return self.changes.apart(angle, guess, 0, lambda rows: [self.equations.newton(guess[rows], angle[rows])])[0]

    def slope(self, poses: Array, angle: Array) -> Array:
        """Slope (T, 3 n) of poses, near a change point by its series."""
        return self.changes.apart(angle, poses, 1, lambda rows: [poses[rows], self.equations.slope(poses[rows])])[1]

    def steps(self, here: BranchPoint, goal: float, last: float | None = None) -> Iterator[BranchPoint]:
        """Points on the way to a goal, or where a change point is next to it, on the way to the last goal beyond it.

        Raises:
            InvalidInput: the linkage goes no further.
            OutOfSteps: no steps are left.
        """
        way = goal - here.angle
        step = math.copysign(min(abs(way), 2.0 * math.pi / STEPS_PER_TURN), way)
        looked = math.inf  # the step [rad] at which a change point was looked for last from here
        while math.copysign(1.0, way) * (goal - here.angle) > 0.0:
            # A step that ends short of the goal by rounding alone ends there.
            self.tries_left -= 1
            if self.tries_left < 0:
                raise OutOfSteps(self.out_of_steps(here.angle))
            near = abs(goal - here.angle) <= (1.0 + SAME_STEP) * abs(step)
            following = goal if near else here.angle + step
            reached = self._try_step(here, following)
            nearing = reached is None or abs(reached.determinant) < NEARING * abs(here.determinant)
            if nearing and abs(step) <= LOOK_AGAIN * looked:
                looked = abs(step)
                reached = self._cross(here, step, goal if last is None else last) or reached
            if reached is not None:
                here, step, looked = reached, 2.0 * step, math.inf
                yield here
            elif abs(step) > LEAST_STEP:
                step *= 0.5
            else:
                raise InvalidInput(self.equations.cannot_turn(np.array([following])))

    def out_of_steps(self, angle: float) -> str:
        """Message on a crank angle [rad] that the walk did not get past."""
        return (
            f"{self.equations.mechanism.name}: its motion was not found beyond crank angle "
            f"{math.degrees(angle):.6g} deg, where every step has to be tiny; check lengths and their units"
        )

    def _try_step(self, here: BranchPoint, following: float) -> BranchPoint | None:
        """The place after a step along the tangent; None if it strayed from it, turned a corner or changed branch."""
        guess = here.poses + here.slope * (following - here.angle)
        try:
            poses = self.equations.newton(guess, np.array([following]), ATTEMPTS, falling=True)
        except InvalidInput:
            return None
        if self.equations.distance(poses, guess)[0] > WALK_MISS:
            return None
        # The factors that give the branch give the slope as well, for the step after this one.
        reached = self.place(following, poses)
        bend = float(self.equations.distance(reached.slope, here.slope)[0])
        largest = max(float(self.equations.distance(slope, 0.0 * poses)[0]) for slope in (here.slope, reached.slope))
        return None if reached.determinant * here.determinant <= 0.0 or bend / largest > WALK_BEND else reached

    def _cross(self, here: BranchPoint, step: float, goal: float) -> BranchPoint | None:
        """The place beyond a change point that is next on the way, or the goal itself; None if none is near."""
        if abs(step) < LEAST_LOOK:
            return None
        crossed = crossing(self.equations, here.angle, here.poses, LOOK_AHEAD * step)
        if crossed is None:
            return None
        change, angle, poses = crossed
        beyond = self.place(angle, poses)
        if np.sign(beyond.determinant) != np.sign(here.determinant) * (-1.0) ** change.freedoms:
            return None
        self.changes.add(change)
        if abs(goal - here.angle) >= abs(angle - here.angle):
            return beyond
        ending = np.array([goal])
        poses = self.solved(change.series(ending, 0)[0], ending)
        return BranchPoint(goal, poses, self.slope(poses, ending), math.nan)

    def steps_at_once(self, passed: Sequence[BranchPoint], goals: Array) -> list[BranchPoint]:
        """Points at the first of some goal angles, as many as follow each other without a doubt; maybe none.

        Args:
            passed: points that the walk has been at, the last one where it is.
            goals: angles (T,) [rad] in the order of the walk.
        """
        goals = goals[: _first(self.changes.near(goals))]
        if not len(goals):
            return []
        equations, here = self.equations, passed[-1]
        try:
            poses = equations.newton(_ahead(passed[-KNOWN:], goals), goals)
        except (InvalidInput, np.linalg.LinAlgError):  # the points passed may lie too close to each other
            return []
        poses = np.concatenate([here.poses, poses])
        factors = equations.elimination(poses)
        slopes, blocks = equations.slope(poses, factors=factors), factors.block_determinants()
        widths = np.diff(goals, prepend=here.angle)[:, None]
        none = np.zeros_like(slopes)
        steep = equations.distance(slopes, none)
        doubtful = (
            (equations.distance(poses[1:], poses[:-1] + widths * slopes[:-1]) > WALK_MISS)
            | (equations.distance(slopes[1:], slopes[:-1]) > WALK_BEND * np.maximum(steep[1:], steep[:-1]))
            | ~(blocks[1:] * np.sign(blocks[:-1]) >= NEARING * np.abs(blocks[:-1])).all(axis=1)
        )
        determinants = factors.determinant()
        return [
            BranchPoint(float(goals[k - 1]), poses[k : k + 1], slopes[k : k + 1], float(determinants[k]))
            for k in range(1, _first(doubtful) + 1)
        ]


def _first(marked: NDArray[np.bool_]) -> int:
    """Index of the first one that is marked; their number if none is."""
    return int(np.argmax([*marked, True]))


def _ahead(passed: Sequence[BranchPoint], goals: Array) -> Array:
    """Poses (T, 3 n) at angles ahead, by the polynomial through the points passed and their slopes."""
    angles = np.array([place.angle for place in passed])
    width = max(float(np.ptp(angles)), abs(float(goals[0] - angles[-1])))
    at, powers = (angles[:, None] - angles[-1]) / width, np.arange(2 * len(angles))
    rates = np.where(powers > 0, powers * at ** np.maximum(powers - 1, 0), 0.0)
    given = np.concatenate([*(place.poses for place in passed), *(width * place.slope for place in passed)])
    coefficients = np.linalg.solve(np.concatenate([at**powers, rates]), given)
    return np.asarray(((goals[:, None] - angles[-1]) / width) ** powers @ coefficients)


SAME = 1e-6  # [rad], between two findings of one change point


class ChangePointCache:
    """Change points by their angle, those that a walk passes on its way to and fro found once."""

    def __init__(self) -> None:
        self._changes: list[ChangePoint] = []

    def add(self, change: ChangePoint) -> None:
        """Take in a change point."""
        if not any(abs(change.angle - known.angle) < SAME for known in self._changes):
            self._changes.append(change)
            self._changes.sort(key=lambda known: known.angle)

    def repeat(self, turn: float, gain: Array) -> None:
        """Take in those of the turns before and after one that repeats, with what it adds to the poses (3 n,)."""
        for change in list(self._changes):
            for turns in (-1.0, 1.0):
                shifted = change.coefficients.copy()
                shifted[0] += turns * gain
                self.add(replace(change, angle=change.angle + turns * turn, coefficients=shifted))

    @property
    def angles(self) -> Array:
        """Their crank angles [rad], growing."""
        return np.array([change.angle for change in self._changes])

    def near(self, angle: Array, distance: float | None = None) -> NDArray[np.bool_]:
        """Mask (T,) of angles [rad] less than a distance from a change point, or so near that its series is used."""
        result = np.zeros(len(angle), dtype=bool)
        for change in self._changes:
            result |= change.near(angle) if distance is None else np.abs(angle - change.angle) < distance
        return result

    def apart(self, angle: Array, poses: Array, order: int, away: Callable[[Rows], list[Array]]) -> list[Array]:
        """Taylor coefficients of poses (T, 3 n): near a change point by its series, else by a function of the rows."""
        far = ~self.near(angle)
        if far.all():
            return away(slice(None))
        found = np.empty((order + 1, *poses.shape))
        if far.any():
            found[:, far] = away(far)
        for change in self._changes:
            if (near := change.near(angle)).any():
                found[:, near] = change.series(angle[near], order)
        return list(found)

    def sign(self, angle: Array) -> Array:
        """Sign of the determinant (T,) on the smooth course at angles (T,) [rad], against that at crank angle 0."""
        result = np.ones(len(angle))
        for change in self._changes:
            if change.freedoms % 2:
                result[(angle > change.angle) != (change.angle < 0.0)] *= -1.0
        return result
