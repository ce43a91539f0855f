"""The walk along an assembly branch from the start pose, around the turn or over a span, in steps that it allows.

At a change point it goes on smoothly; from there on the determinant of the Jacobian, which distinguishes branches, has
the other sign.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.branch_continuation import MOST_TRIES, STEPS_PER_TURN, BranchContinuation, BranchPoint, OutOfSteps
from conrod.exact.equations import Equations, check_meshes
from conrod.exact.motion import Array, Side, hermite

# The table is refined until it predicts every pose this well, and no pose may lie further from its prediction: a
# Newton iteration that moves more has left for another branch.
TABLE_MISS, REFINEMENTS = 1e-5, 16
STRAYED = 1e-3
# What poses may differ by after a turn and yet be the same (lengths against the size).
RETURNED = 1e-9
LONGEST = 16  # steps at once
MOST_ROWS = 20_000  # of a turn in the table; of machines that ship none has more than 83


@dataclass(frozen=True)
class PoseTable:
    """Poses at increasing crank angles: from 0 to 2 pi, or over the stretch that an input without full turns makes."""

    angles: Array  # (K,) [rad]
    poses: Array  # (K, 3 n)
    slopes: Array  # (K, 3 n), by the crank angle
    gain: Array | None  # (3 n,) over the whole turn; zero but for bodies that turn; None where poses do not repeat

    def interpolate(self, angle: Array) -> Array:
        """Poses (T, 3 n) at any angles, or of the stretch, by cubic Hermite interpolation within the turn."""
        turns = self._turns(angle)
        here = hermite(self.angles, self.poses, self.slopes, angle - 2.0 * np.pi * turns)
        return here if self.gain is None else np.asarray(here + turns[:, None] * self.gain)

    def _turns(self, angle: Array) -> Array:
        """Whole turns that angles are beyond those of the table."""
        return np.zeros_like(angle) if self.gain is None else np.floor(angle / (2.0 * np.pi))

    def covers(self, angle: Array) -> Array:
        """True (T,) for angles that the table has poses of."""
        within = angle - 2.0 * np.pi * self._turns(angle)
        return np.asarray((within >= self.angles[0]) & (within <= self.angles[-1]))

    def nearest(self, angle: float) -> tuple[float, Array]:
        """The tabulated angle (whole turns added) next to an angle, and the poses (1, 3 n) there."""
        turns = float(self._turns(np.array([angle]))[0])
        k = int(np.argmin(np.abs(self.angles - (angle - 2.0 * np.pi * turns))))
        poses = self.poses[k] if self.gain is None else self.poses[k] + turns * self.gain
        return float(self.angles[k] + 2.0 * np.pi * turns), poses[None]


class BranchWalk:
    """Poses on the branch of the start poses.

    Raises:
        InvalidInput: the mechanism cannot be assembled at crank angle 0, or wheels that roll do not touch there.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self._longer: PoseTable | None = None
        self._ends: dict[bool, float] = {}  # where the way forwards (True) and backwards ends, once it was gone
        self._continuation = BranchContinuation(equations)

    @cached_property
    def start(self) -> Array:
        """Exact poses at crank angle 0; (1, 3 n)."""
        start = self.equations.newton(self.equations.approximate, np.zeros(1))
        check_meshes(self.equations.mechanism, start)
        return start

    def branch_of(self, poses: Array) -> Array:
        """Sign of the determinant of the Jacobian (T,); it distinguishes assembly branches."""
        return np.asarray(np.sign(self.equations.elimination(poses).determinant()))

    def poses(self, angle: Array) -> Array:
        """Exact poses (T, 3 n) at crank angles (T,) [rad].

        Raises:
            InvalidInput: the linkage does not reach an angle.
        """
        table = self._reaching(angle)
        if table is None:
            return np.concatenate([self._walk(0.0, self.start, float(goal)) for goal in angle])
        guess = table.interpolate(angle)
        if table.gain is None or not len(self._continuation.changes.angles):
            poses = self._continuation.solved(guess, angle)
        else:
            within, turns = self._within(angle)
            added = turns[:, None] * table.gain
            poses = self._continuation.solved(guess - added, within) + added
        strayed = np.flatnonzero(self.equations.distance(poses, guess) > STRAYED)
        begun = [table.nearest(float(angle[k])) for k in strayed]
        ways = angle[strayed] - np.array([near for near, _ in begun])
        before: dict[float, tuple[float, Array]] = {}
        for at in np.argsort(np.abs(ways)):
            # Beyond a span the way goes on from the angle before, if that is nearer.
            goal, side, (near, here) = float(angle[strayed[at]]), float(np.sign(ways[at])), begun[at]
            if side in before and abs(goal - before[side][0]) < abs(goal - near):
                near, here = before[side]
            reached = self._walk(near, here, goal)
            poses[strayed[at]], before[side] = reached[0], (goal, reached)
        return poses

    def series(self, angle: Array, order: int, side: Side) -> list[Array]:
        """Taylor coefficients of the poses by the crank angle at angles (T,) up to an order; each (T, 3 n)."""
        poses, equations = self.poses(angle), self.equations
        coefficients = self._continuation.changes.apart(
            self._within(angle)[0],
            poses,
            order,
            lambda rows: equations.series(poses[rows], angle[rows], order, equations.arcs(poses[rows], side)),
        )
        return [poses, *coefficients[1:]]

    def sign(self, angle: Array) -> Array:
        """Value of `branch_of` on the smooth course at angles (T,) [rad] that were reached."""
        return np.asarray(self.branch_of(self.start) * self._continuation.changes.sign(self._within(angle)[0]))

    @property
    def change_angles(self) -> Array:
        """Crank angles [rad] of the change points of the turn, or of the span, or of what was reached so far."""
        low, high = (-math.inf, math.inf) if self.table is None else self.table.angles[[0, -1]]
        angles = self._continuation.changes.angles
        return angles[(angles >= low) & (angles <= high)]

    def near_change(self, angle: Array, distance: float) -> NDArray[np.bool_]:
        """Mask (T,) of angles [rad] that are less than a distance [rad] from a change point."""
        return self._continuation.changes.near(self._within(angle)[0], distance)

    def _within(self, angle: Array) -> tuple[Array, Array]:
        """Angles (T,) within the turn that repeats, where one does, and the whole turns (T,) left out."""
        if self.table is None or self.table.gain is None:
            return angle, np.zeros_like(angle)
        turns = np.floor(angle / (2.0 * math.pi))
        return angle - 2.0 * math.pi * turns, turns

    @cached_property
    def table(self) -> PoseTable | None:
        """Poses over one full turn, or over the driver's span; None if the linkage does not reach all of the turn.

        Raises:
            InvalidInput: the linkage does not reach all of the span.
        """
        span = self.equations.mechanism.driver.span
        _ = self.start  # what is wrong there is reported, and not taken for a limit of the turn
        try:
            table = self._stretch(*(span or (0.0, 2.0 * np.pi)))
        except InvalidInput as error:
            if span is not None or isinstance(error, OutOfSteps):
                raise
            return None
        check_meshes(self.equations.mechanism, table.poses)
        gain = self._gain(table) if span is None else None
        if gain is not None:
            self._continuation.changes.repeat(2.0 * math.pi, gain)
        return replace(table, gain=gain)

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
        with self._budgeted(last - first):
            forth, back = self._passed(last), self._passed(first)
            places = [*reversed(back[1:]), *forth]
            stacked = np.concatenate([place.poses for place in places])
            angles = np.array([place.angle for place in places])
            return self._refined(PoseTable(angles, stacked, self._continuation.slope(stacked, angles), None))

    @contextmanager
    def _budgeted(self, way: float) -> Iterator[None]:
        """Allow the single steps of a way [rad], and raise OutOfSteps beyond them."""
        self._continuation.tries_left = MOST_TRIES * math.ceil(abs(way) / (2.0 * math.pi))
        try:
            yield
        finally:
            self._continuation.tries_left = math.inf

    def _passed(self, goal: float) -> list[BranchPoint]:
        """Places from the start to an angle, in steps of no more than one of the turn's.

        Raises:
            InvalidInput: the linkage goes no further than to the angle that is then in `_ends`.
        """
        passed = [self._continuation.place(0.0, self.start)]
        goals = np.linspace(0.0, goal, math.ceil(abs(goal) / (2.0 * math.pi) * STEPS_PER_TURN) + 1)[1:]
        length = 2
        while len(goals := goals[np.abs(goals) > abs(passed[-1].angle)]):
            found = self._continuation.steps_at_once(passed, goals[:length])
            try:
                for place in found or self._continuation.steps(passed[-1], float(goals[0]), goal):
                    passed.append(place)
            except InvalidInput as error:
                if not isinstance(error, OutOfSteps):
                    self._ends[goal > 0.0] = passed[-1].angle
                raise
            length = min(2 * length, LONGEST) if len(found) == length else max(len(found), 1)
        return passed

    def _refined(self, table: PoseTable) -> PoseTable:
        """The table with a row more in every interval that it does not predict well in its middle."""
        for _ in range(REFINEMENTS):
            middle = 0.5 * (table.angles[:-1] + table.angles[1:])
            guess = table.interpolate(middle)
            poses = self._continuation.solved(guess, middle)
            miss = self.equations.distance(poses, guess)
            for k in np.flatnonzero(miss > STRAYED):
                poses[k] = self._walk(float(table.angles[k]), table.poses[k : k + 1], float(middle[k]))[0]
            coarse = miss > TABLE_MISS
            if not coarse.any():
                break
            if len(table.angles) > MOST_ROWS * math.ceil((table.angles[-1] - table.angles[0]) / (2.0 * math.pi)):
                raise OutOfSteps(self._continuation.out_of_steps(float(middle[coarse][0])))
            slopes = self._continuation.slope(poses[coarse], middle[coarse])
            rows = {"angles": middle[coarse], "poses": poses[coarse], "slopes": slopes}
            after = np.flatnonzero(coarse) + 1
            merged = {name: np.insert(getattr(table, name), after, new, axis=0) for name, new in rows.items()}
            table = replace(table, **merged)
        return table

    def _walk(self, angle: float, poses: Array, goal: float) -> Array:
        """Poses (1, 3 n) at a goal angle, reached from those at another without leaving the branch."""
        here = self._continuation.place(angle, poses)
        return [here, *self._continuation.steps(here, goal)][-1].poses

    def reach(self, goal: float) -> float:
        """The crank angle [rad] where the way from the start to a goal ends; the goal, if nothing ends it before."""
        forwards = goal > 0.0
        if forwards not in self._ends:
            try:
                with self._budgeted(goal):
                    self._passed(goal)
            except InvalidInput as error:
                if isinstance(error, OutOfSteps):
                    raise
        end = self._ends.get(forwards, goal)
        return end if abs(end) < abs(goal) else goal

    def _gain(self, turn: PoseTable) -> Array | None:
        """Gain of the poses over one turn: turns of bodies, and nothing else; None if the next turn is another one."""
        gain = (turn.poses[-1] - turn.poses[0]).reshape(-1, 3)
        whole = 2.0 * np.pi * np.rint(gain[:, 2] / (2.0 * np.pi))
        if np.abs(gain[:, :2]).max() > RETURNED * self.equations.size:
            return None
        if np.abs(gain[:, 2] - whole).max() <= RETURNED:
            return np.column_stack([np.zeros((len(gain), 2)), whole]).ravel()
        # Wheels may turn by any part of a turn, as long as nothing distinguishes one of their turns from the next.
        added = np.column_stack([np.zeros((len(gain), 2)), gain[:, 2]]).ravel()
        left = self.equations.residual([turn.poses + added], turn.angles + 2.0 * np.pi)
        repeats = max(float(np.abs(equation).max()) for equation in left) <= RETURNED * self.equations.size
        return added if repeats else None
