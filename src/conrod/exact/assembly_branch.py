"""Exact poses on the assembly branch of the start poses, as a function of the crank angle.

The branch is tabulated once, over one revolution or the driver's span (`conrod.exact.branch_tracking`). At any angle
the table gives a guess, which Newton iteration makes exact. The motion passes change points smoothly; the determinant
of the Jacobian, whose sign distinguishes branches, changes sign there.
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
from conrod.exact.branch_tracking import (
    MAX_STEPS_PER_REVOLUTION,
    STEPS_PER_REVOLUTION,
    BranchPoint,
    BranchTracker,
    TooManyStepsError,
)
from conrod.exact.equations import Equations, check_meshes
from conrod.exact.motion import Array, Side, hermite_interpolation
from conrod.mechanism.units import REVOLUTION

TABLE_TOLERANCE, MAX_REFINEMENTS = 1e-5, 16  # of poses interpolated in the table (lengths against the size)
MAX_DEVIATION = 1e-3  # of a solved pose from its prediction: a Newton iteration that moves more changes the branch
REPEAT_TOLERANCE = 1e-9  # difference of equal poses one revolution apart (lengths against the size)
MAX_STEPS_AT_ONCE = 16
MAX_TABLE_ROWS = 20_000  # per revolution; machines that ship have at most 83
# From a machine nearby: largest distance of its tabulated poses, and relative change of each block's determinant there.
MAX_NEARBY_DISTANCE, MAX_NEARBY_CHANGE = 0.05, 0.5


@dataclass(frozen=True)
class PoseTable:
    """Poses at increasing crank angles, over one revolution or over the angles of an input without full turns."""

    angles: Array  # (K,) [rad]
    poses: Array  # (K, 3 n)
    derivatives: Array  # (K, 3 n), by the crank angle
    gain: Array | None  # (3 n,) over the whole turn; zero but for bodies that turn; None where poses do not repeat

    def interpolate(self, angle: Array) -> Array:
        """Interpolate poses (T, 3 n) at crank angles (T,) [rad] by cubic Hermite polynomials."""
        turns = self._whole_turns(angle)
        here = hermite_interpolation(self.angles, self.poses, self.derivatives, angle - REVOLUTION * turns)
        return here if self.gain is None else np.asarray(here + turns[:, None] * self.gain)

    def _whole_turns(self, angle: Array) -> Array:
        """Number (T,) of whole revolutions between crank angles and the table."""
        return np.zeros_like(angle) if self.gain is None else np.floor(angle / REVOLUTION)

    def covers(self, angle: Array) -> Array:
        """Mask (T,) of crank angles [rad] for which the table has poses."""
        within = angle - REVOLUTION * self._whole_turns(angle)
        return np.asarray((within >= self.angles[0]) & (within <= self.angles[-1]))

    def nearest(self, angle: float) -> tuple[float, Array]:
        """Return the tabulated crank angle nearest to an angle [rad], and its poses (1, 3 n)."""
        turns = float(self._whole_turns(np.array([angle]))[0])
        k = int(np.argmin(np.abs(self.angles - (angle - REVOLUTION * turns))))
        poses = self.poses[k] if self.gain is None else self.poses[k] + turns * self.gain
        return float(self.angles[k] + REVOLUTION * turns), poses[None]


class AssemblyBranch:
    """Solver for exact poses on the branch of the start poses.

    Args:
        nearby: the branch of a machine with about these lengths, whose table saves tracking the branch. Poses are as
            exact as without it, to rounding, which then depends on that machine.

    Raises:
        InvalidInput: the mechanism cannot be assembled at crank angle 0, or wheels that roll do not touch there.
    """

    def __init__(self, equations: Equations, nearby: AssemblyBranch | None = None) -> None:
        self.equations, self._nearby = equations, nearby
        self._extended_table: PoseTable | None = None
        self._limits: dict[
            bool, float
        ] = {}  # crank angle [rad] that blocks motion forwards (True) or backwards, once found
        self._tracker = BranchTracker(equations)

    @cached_property
    def start(self) -> Array:
        """Exact poses at crank angle 0; (1, 3 n)."""
        start = self._start_of_nearby()
        if start is None:
            start = self.equations.newton(self.equations.start_guess, np.zeros(1))
        check_meshes(self.equations.mechanism, start)
        return start

    def _start_of_nearby(self) -> Array | None:
        """Close the joints at the start of the machine nearby; None if that is not where this one starts."""
        if self._nearby is None:
            return None
        try:
            start = self.equations.newton(self._nearby.start, np.zeros(1), falling=True)
        except (InvalidInput, np.linalg.LinAlgError):
            return None
        return start if self.equations.pose_distance(start, self._nearby.start)[0] <= MAX_NEARBY_DISTANCE else None

    def branch(self, poses: Array) -> Array:
        """Sign (T,) of the Jacobian's determinant at poses (T, 3 n), which distinguishes assembly branches."""
        return np.asarray(np.sign(self.equations.elimination(poses).determinant()))

    def poses(self, angle: Array) -> Array:
        """Return exact poses (T, 3 n) at crank angles (T,) [rad].

        Raises:
            InvalidInput: the linkage does not reach an angle.
        """
        table = self._table_covering(angle)
        if table is None:
            return np.concatenate([self._track_from(0.0, self.start, float(goal)) for goal in angle])
        guess = table.interpolate(angle)
        if table.gain is None or not len(self._tracker.changes.angles):
            poses = self._tracker.solve_poses(guess, angle)
        else:
            within, turns = self._wrap_angle(angle)
            added = turns[:, None] * table.gain
            poses = self._tracker.solve_poses(guess - added, within) + added
        strayed = np.flatnonzero(self.equations.pose_distance(poses, guess) > MAX_DEVIATION)
        begun = [table.nearest(float(angle[k])) for k in strayed]
        distances = angle[strayed] - np.array([near for near, _ in begun])
        before: dict[float, tuple[float, Array]] = {}
        for at in np.argsort(np.abs(distances)):
            # Beyond a span, start from the goal before if it is nearer than the table.
            goal, side, (near, here) = float(angle[strayed[at]]), float(np.sign(distances[at])), begun[at]
            if side in before and abs(goal - before[side][0]) < abs(goal - near):
                near, here = before[side]
            reached = self._track_from(near, here, goal)
            poses[strayed[at]], before[side] = reached[0], (goal, reached)
        return poses

    def series(self, angle: Array, order: int, side: Side) -> list[Array]:
        """Taylor coefficients of the poses by the crank angle at (T,) [rad], up to an order; each (T, 3 n)."""
        poses, equations = self.poses(angle), self.equations
        coefficients = self._tracker.changes.taylor_coefficients(
            self._wrap_angle(angle)[0],
            poses,
            order,
            lambda rows: equations.series(poses[rows], angle[rows], order, equations.arcs(poses[rows], side)),
        )
        return [poses, *coefficients[1:]]

    def branch_at(self, angle: Array) -> Array:
        """Sign (T,) that `branch` has for exact poses at crank angles (T,) [rad] reached before."""
        return np.asarray(self.branch(self.start) * self._tracker.changes.determinant_sign(self._wrap_angle(angle)[0]))

    @property
    def change_angles(self) -> Array:
        """Crank angles [rad] of known change points in one revolution or in the driver's span."""
        low, high = (-math.inf, math.inf) if self.table is None else self.table.angles[[0, -1]]
        angles = self._tracker.changes.angles
        return angles[(angles >= low) & (angles <= high)]

    def near_change(self, angle: Array, distance: float) -> NDArray[np.bool_]:
        """Mask (T,) of angles [rad] closer than a distance [rad] to a change point."""
        return self._tracker.changes.covers(self._wrap_angle(angle)[0], distance)

    def _wrap_angle(self, angle: Array) -> tuple[Array, Array]:
        """Split crank angles (T,) into angles within one revolution, if it repeats, and whole turns (T,)."""
        if self.table is None or self.table.gain is None:
            return angle, np.zeros_like(angle)
        turns = np.floor(angle / REVOLUTION)
        return angle - REVOLUTION * turns, turns

    @cached_property
    def table(self) -> PoseTable | None:
        """Poses over one revolution or the driver's span; None if the crank cannot make a full revolution.

        Raises:
            InvalidInput: the linkage does not reach all of the span.
        """
        span = self.equations.mechanism.driver.span
        _ = self.start  # raises its own error, which is not to be taken for a limit of the turn
        try:
            table = self._tabulate(*(span or (0.0, REVOLUTION)))
        except InvalidInput as error:
            if span is not None or isinstance(error, TooManyStepsError):
                raise
            return None
        check_meshes(self.equations.mechanism, table.poses)
        gain = self._gain_per_turn(table) if span is None else None
        if gain is not None:
            self._tracker.changes.add_period_images(REVOLUTION, gain)
        return replace(table, gain=gain)

    @cached_property
    def _table_determinants(self) -> Array:
        """Determinants (K, k) of the blocks of the Jacobian at the tabulated poses."""
        poses = self.start if self.table is None else self.table.poses
        return self.equations.elimination(poses).block_determinants()

    def _table_covering(self, angle: Array) -> PoseTable | None:
        """Return a table that covers the angles, extended by whole turns if poses do not repeat."""
        if self.table is None or self.table.covers(angle).all() or self.equations.mechanism.driver.span is not None:
            return self.table
        table = self._extended_table or self.table
        if not table.covers(angle).all():
            first, last = min(table.angles[0], angle.min()), max(table.angles[-1], angle.max())
            turn = REVOLUTION
            # Extend by whole turns, because the next angle is often a little further.
            self._extended_table = table = self._tabulate(
                turn * math.floor(first / turn), turn * math.ceil(last / turn)
            )
        return table

    def _tabulate(self, first: float, last: float) -> PoseTable:
        """Tabulate poses from one crank angle to another [rad], with 0 between them."""
        if (known := self._table_of_nearby(first, last)) is not None:
            return known  # as fine as theirs; `poses` follows the branch where a prediction is off
        with self._limited_steps(last - first):
            forth, back = self._track_to(last), self._track_to(first)
            places = [*reversed(back[1:]), *forth]
            stacked = np.concatenate([place.poses for place in places])
            angles = np.array([place.angle for place in places])
            return self._refine_table(PoseTable(angles, stacked, self._tracker.pose_derivative(stacked, angles), None))

    def _table_of_nearby(self, first: float, last: float) -> PoseTable | None:
        """Close the joints at the tabulated poses of the machine nearby; None where that may leave the branch."""
        if self._nearby is None:
            return None
        try:
            known = self._nearby.table
            if known is None or len(self._nearby.change_angles) or tuple(known.angles[[0, -1]]) != (first, last):
                return None
            poses = self.equations.newton(known.poses, known.angles, falling=True)
        except (InvalidInput, np.linalg.LinAlgError):
            return None
        factors, others = self.equations.elimination(poses), self._nearby._table_determinants
        blocks = factors.block_determinants()
        start = poses[np.flatnonzero(known.angles == 0.0)]
        on_branch = (
            self.equations.pose_distance(poses, known.poses).max() <= MAX_NEARBY_DISTANCE
            and blocks.shape == others.shape
            and bool(np.all(np.abs(blocks / others - 1.0) <= MAX_NEARBY_CHANGE))
            and self.equations.pose_distance(start, self.start).max() <= REPEAT_TOLERANCE
        )
        derivatives = self.equations.pose_derivative(poses, factors=factors)
        return PoseTable(known.angles, poses, derivatives, None) if on_branch else None

    @contextmanager
    def _limited_steps(self, distance: float) -> Iterator[None]:
        """Context that limits single steps to the number that a distance [rad] may take."""
        self._tracker.tries_left = MAX_STEPS_PER_REVOLUTION * math.ceil(abs(distance) / REVOLUTION)
        try:
            yield
        finally:
            self._tracker.tries_left = math.inf

    def _track_to(self, goal: float) -> list[BranchPoint]:
        """Track the branch from crank angle 0 to a goal [rad]; return the points passed.

        Raises:
            InvalidInput: the linkage cannot move on; the angle reached is then in `_limits`.
        """
        passed = [self._tracker.point_at(0.0, self.start)]
        goals = np.linspace(0.0, goal, math.ceil(abs(goal) / REVOLUTION * STEPS_PER_REVOLUTION) + 1)[1:]
        length = 2
        while len(goals := goals[np.abs(goals) > abs(passed[-1].angle)]):
            found = self._tracker.steps_at_once(passed, goals[:length])
            try:
                for place in found or self._tracker.steps(passed[-1], float(goals[0]), goal):
                    passed.append(place)
            except InvalidInput as error:
                if not isinstance(error, TooManyStepsError):
                    self._limits[goal > 0.0] = passed[-1].angle
                raise
            length = min(2 * length, MAX_STEPS_AT_ONCE) if len(found) == length else max(len(found), 1)
        return passed

    def _refine_table(self, table: PoseTable) -> PoseTable:
        """Insert rows until the table predicts the pose in the middle of each interval."""
        for _ in range(MAX_REFINEMENTS):
            middle = 0.5 * (table.angles[:-1] + table.angles[1:])
            guess = table.interpolate(middle)
            poses = self._tracker.solve_poses(guess, middle)
            miss = self.equations.pose_distance(poses, guess)
            for k in np.flatnonzero(miss > MAX_DEVIATION):
                poses[k] = self._track_from(float(table.angles[k]), table.poses[k : k + 1], float(middle[k]))[0]
            coarse = miss > TABLE_TOLERANCE
            if not coarse.any():
                break
            if len(table.angles) > MAX_TABLE_ROWS * math.ceil((table.angles[-1] - table.angles[0]) / REVOLUTION):
                raise TooManyStepsError(self._tracker.too_many_steps_message(float(middle[coarse][0])))
            derivatives = self._tracker.pose_derivative(poses[coarse], middle[coarse])
            rows = {"angles": middle[coarse], "poses": poses[coarse], "derivatives": derivatives}
            after = np.flatnonzero(coarse) + 1
            merged = {name: np.insert(getattr(table, name), after, new, axis=0) for name, new in rows.items()}
            table = replace(table, **merged)
        return table

    def _track_from(self, angle: float, poses: Array, goal: float) -> Array:
        """Return poses (1, 3 n) at a goal angle, tracked from given poses without leaving the branch."""
        here = self._tracker.point_at(angle, poses)
        return [here, *self._tracker.steps(here, goal)][-1].poses

    def reachable_angle(self, goal: float) -> float:
        """Crank angle [rad] that is reached from the start towards a goal; the goal if nothing blocks it."""
        forwards = goal > 0.0
        if forwards not in self._limits:
            try:
                with self._limited_steps(goal):
                    self._track_to(goal)
            except InvalidInput as error:
                if isinstance(error, TooManyStepsError):
                    raise
        end = self._limits.get(forwards, goal)
        return end if abs(end) < abs(goal) else goal

    def _gain_per_turn(self, turn: PoseTable) -> Array | None:
        """Change (3 n,) of the poses over one revolution: rotations only; None if poses do not repeat."""
        gain = (turn.poses[-1] - turn.poses[0]).reshape(-1, 3)
        whole = REVOLUTION * np.rint(gain[:, 2] / REVOLUTION)
        if np.abs(gain[:, :2]).max() > REPEAT_TOLERANCE * self.equations.size:
            return None
        if np.abs(gain[:, 2] - whole).max() <= REPEAT_TOLERANCE:
            return np.column_stack([np.zeros((len(gain), 2)), whole]).ravel()
        # Wheels may turn by any part of a turn, as long as nothing distinguishes one of their turns from the next.
        added = np.column_stack([np.zeros((len(gain), 2)), gain[:, 2]]).ravel()
        left = self.equations.residual([turn.poses + added], turn.angles + REVOLUTION)
        repeats = max(float(np.abs(equation).max()) for equation in left) <= REPEAT_TOLERANCE * self.equations.size
        return added if repeats else None
