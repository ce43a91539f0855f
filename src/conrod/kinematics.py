"""Exact motion of any `Mechanism`, by Newton iteration on its joint equations.

The generic reference: it knows nothing of a scene's closed form. Poses come from Newton iteration; derivatives by
the crank angle then follow, order by order, from linear systems with one and the same Jacobian, because the
k-th Taylor coefficient of the joint equations is J q_k + (a term in q_0 .. q_(k-1)).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.joint_equations import active_arcs, joint_jacobian, joint_residual, pose_jets
from conrod.mechanism import GROUND, CamContact, Joint, Mechanism
from conrod.motion import BREAK_WIDTH, Array, Motion, Side, diameter, point_motion
from conrod.pose_table import PoseTable

MOTION_ORDER = 3  # position to jerk
NEWTON_STEPS = 30
# Newton converges quadratically: after a step this small (lengths against the mechanism's size) its square is left.
NEWTON_DONE = 1e-9
STEPS_PER_TURN, LEAST_STEP = 64, 1e-12  # of the walk around the turn; the least one [rad]
# A step of the walk is halved until its straight prediction is this good (scaled as above), and keeps the branch.
WALK_MISS = 0.02
# The table is refined until it predicts every pose this well, and no pose may lie further from its prediction: a
# Newton iteration that moves more has left for another branch.
TABLE_MISS, REFINEMENTS = 1e-5, 16
STRAYED = 1e-3

Arcs = dict[str, NDArray[np.intp]]


class Kinematics:
    """Solver for one mechanism.

    Raises:
        InvalidInput: the mechanism cannot be assembled, has not mobility one, or cannot turn fully.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        if mechanism.mobility != 1:
            raise InvalidInput(f"{mechanism.name} has mobility {mechanism.mobility}; a driven crank needs exactly 1")
        self.mechanism = mechanism
        self._crank = mechanism.body_index[mechanism.crank]
        start = np.array([mechanism.poses[body.name] for body in mechanism.bodies], dtype=float)
        # Newton works on lengths in units of the mechanism's size, so that its tolerance fits mm and km alike.
        self.size = float(np.abs(start[:, :2]).max()) or 1.0
        self._scale = np.tile([self.size, self.size, 1.0], len(mechanism.bodies))
        self._approximate = start.reshape(1, -1)

    # -- poses -------------------------------------------------------------------------------------------------

    def poses(self, angle: Array) -> Array:
        """Stacked poses (T, 3 n) [m, m, rad] at crank angles (T,) [rad]; all on the branch of the start poses.

        Raises:
            InvalidInput: the linkage does not reach an angle.
        """
        if self._table is None:
            return np.concatenate([self._walk(0.0, self.start, float(goal)) for goal in angle])
        guess = self._table.interpolate(angle)
        poses = self._newton(guess, angle)
        for k in np.flatnonzero(self._scaled_distance(poses, guess) > STRAYED):
            near, here = self._table.nearest(float(angle[k]))
            poses[k] = self._walk(near, here, float(angle[k]))[0]
        return poses

    def derivatives(self, angle: Array, order: int = MOTION_ORDER, side: Side = "right") -> list[Array]:
        """Poses and their derivatives by the crank angle up to `order`; each (T, 3 n)."""
        poses = self.poses(angle)
        arcs = self._arcs(poses, side)
        # One matrix for all orders, so it is inverted once.
        inverse = _inverse(self.jacobian(poses, arcs))
        coefficients = [poses]
        for k in range(1, order + 1):
            zero = np.zeros_like(poses)
            residual = self._residual([*coefficients, zero], angle, arcs)[k]
            coefficients.append(-(inverse @ residual[:, :, None])[:, :, 0])
        return [math.factorial(k) * c for k, c in enumerate(coefficients)]

    def branch(self, poses: Array) -> Array:
        """Sign of the determinant of the joint equations' Jacobian (T,); it tells assembly branches apart."""
        return np.asarray(np.sign(np.linalg.det(self._scaled(self.jacobian(poses)))), dtype=float)

    @cached_property
    def assembled_branch(self) -> float:
        """The branch that the start poses picked, +1 or -1."""
        return float(self.branch(self.start)[0])

    def conditioning(self, poses: Array) -> Array:
        """Smallest singular value of the scaled Jacobian (T,); it vanishes where the linkage gains a freedom."""
        return np.asarray(np.linalg.svd(self._scaled(self.jacobian(poses)), compute_uv=False)[:, -1])

    @cached_property
    def start(self) -> Array:
        """Exact poses at crank angle 0; (1, 3 n)."""
        return self._newton(self._approximate, np.zeros(1))

    @cached_property
    def lengths(self) -> dict[str, float]:
        """Largest distance [m] between two exact positions of each observed point, over the sampled poses of a turn.

        The size of the mechanism stands in where the linkage cannot turn.
        """
        if self._table is None:
            return {observed.name: self.size for observed in self.mechanism.observed}
        return {name: diameter(p[0]) for name, p in self.point_derivatives([self._table.poses]).items()}

    @property
    def travel(self) -> float:
        """The largest distance [m] that an observed point moves in a turn; the size of a linkage that cannot turn."""
        return max(self.lengths.values())

    # -- observed points ---------------------------------------------------------------------------------------

    def motion(
        self, angle: Array, speed: Array | float, acceleration: Array | float = 0.0, side: Side = "right"
    ) -> Motion:
        """Exact motion of the observed points; arguments as in `Scene.motion`."""
        angle = np.atleast_1d(np.asarray(angle, dtype=float))
        w, a = np.broadcast_to(speed, angle.shape), np.broadcast_to(acceleration, angle.shape)
        points = self.point_derivatives(self.derivatives(angle, MOTION_ORDER, side))
        return Motion(angle, {name: point_motion((d[0], d[1], d[2], d[3]), w, a) for name, d in points.items()})

    def point_derivatives(self, derivatives: list[Array]) -> dict[str, list[Array]]:
        """Observed points and their derivatives, each (T, 2), from those of the poses."""
        coefficients = [d / math.factorial(k) for k, d in enumerate(derivatives)]
        bodies = pose_jets(self.mechanism, coefficients)
        points = {}
        for observed in self.mechanism.observed:
            x, y = bodies[observed.body].point(observed.point)
            points[observed.name] = [
                math.factorial(k) * np.column_stack([x.coefficients[k], y.coefficients[k]])
                for k in range(len(derivatives))
            ]
        return points

    # -- equations ---------------------------------------------------------------------------------------------

    def jacobian(self, poses: Array, arcs: Arcs | None = None) -> Array:
        """Derivative of all joint equations and of the driver's by the poses; (T, 3 n, 3 n)."""
        bodies = pose_jets(self.mechanism, [poses])
        matrix = np.zeros((len(poses), poses.shape[1], poses.shape[1]))
        row = 0
        for joint in self.mechanism.joints:
            for a_entries, b_entries in joint_jacobian(joint, bodies, (arcs or {}).get(joint.name)):
                for body, entries in ((joint.a, a_entries), (joint.b, b_entries)):
                    if body != GROUND:
                        for k in range(3):
                            matrix[:, row, 3 * self.mechanism.body_index[body] + k] += entries[k]
                row += 1
        matrix[:, row, 3 * self._crank + 2] = 1.0
        return matrix

    @staticmethod
    def equations_of(joint: Joint) -> int:
        """Number of equations of a joint: two for a lower pair, one for a higher one."""
        return 1 if isinstance(joint, CamContact) else 2

    def residual(self, derivatives: list[Array], crank: Array) -> Array:
        """What a measured state leaves of all equations, (T, 3 n): of their highest derivative in time given.

        Args:
            derivatives: stacked poses, their rates, their accelerations (T, 3 n), as many as are wanted.
            crank: the crank's angle, rate or angular acceleration (T,), the one of the highest derivative.
        """
        order = len(derivatives) - 1
        coefficients = [d / math.factorial(k) for k, d in enumerate(derivatives)]
        # Any angle does for the joints: the driver's row, the last, is made here.
        result = math.factorial(order) * self._residual(coefficients, np.zeros(len(crank)))[order]
        driver = self.mechanism.driver
        turn = derivatives[order][:, 3 * self._crank + 2]
        result[:, -1] = turn - driver.sense * crank - (driver.start if order == 0 else 0.0)
        return result

    def _residual(self, coefficients: list[Array], angle: Array, arcs: Arcs | None = None) -> list[Array]:
        """Taylor coefficients by the crank angle of all equations, each (T, 3 n)."""
        bodies = pose_jets(self.mechanism, coefficients)
        equations = []
        for joint in self.mechanism.joints:
            equations += joint_residual(joint, bodies, (arcs or {}).get(joint.name))
        driver = self.mechanism.driver
        prescribed = [driver.start + driver.sense * angle, np.full_like(angle, driver.sense)]
        prescribed += [np.zeros_like(angle)] * len(coefficients)
        crank = bodies[self.mechanism.crank].phi.coefficients
        rows = [
            [np.broadcast_to(e.coefficients[k], angle.shape) for e in equations] + [crank[k] - prescribed[k]]
            for k in range(len(coefficients))
        ]
        return [np.stack(row, axis=1) for row in rows]

    def _arcs(self, poses: Array, side: Side) -> Arcs:
        """The cam arcs in force on one side of each angle.

        Velocity is continuous across tangent arcs, so a move by +-`BREAK_WIDTH` along it tells the side.
        """
        contacts = self.mechanism.cam_contacts
        if not contacts:
            return {}
        bodies = pose_jets(self.mechanism, [poses])
        here = {joint.name: active_arcs(joint, bodies) for joint in contacts}
        residual = self._residual([poses, np.zeros_like(poses)], np.zeros(len(poses)), here)[1]
        slope = -_solve(self.jacobian(poses, here), residual)
        width = BREAK_WIDTH if side == "right" else -BREAK_WIDTH
        moved = pose_jets(self.mechanism, [poses + width * slope])
        return {joint.name: active_arcs(joint, moved) for joint in contacts}

    def _newton(self, guess: Array, angle: Array) -> Array:
        poses = guess.copy()
        for _ in range(NEWTON_STEPS):
            step = _solve(self.jacobian(poses), self._residual([poses], angle)[0])
            poses -= step
            if not np.all(np.isfinite(step)):
                break
            if np.abs(step / self._scale).max() <= NEWTON_DONE:
                return poses
        raise InvalidInput(self._cannot_turn(angle))

    def _cannot_turn(self, angle: Array) -> str:
        lowest, highest = np.degrees([angle.min(), angle.max()])
        return f"{self.mechanism.name} cannot be assembled at every crank angle from {lowest:.6g} to {highest:.6g} deg"

    @cached_property
    def _table(self) -> PoseTable | None:
        """Poses over one full turn; None if the linkage does not reach all of it."""
        angles, poses = [0.0], [self.start]
        try:
            for goal in np.linspace(0.0, 2.0 * np.pi, STEPS_PER_TURN + 1)[1:]:
                for angle, here in self._steps(angles[-1], poses[-1], float(goal)):
                    angles.append(angle)
                    poses.append(here)
        except InvalidInput:
            return None
        rows, stacked = np.array(angles), np.concatenate(poses)
        table = PoseTable(rows, stacked, self._slope(stacked, rows), self._gain(stacked[0], stacked[-1]))
        return self._refined(table)

    def _refined(self, table: PoseTable) -> PoseTable:
        """The table with a row more in every interval that it does not predict well in its middle."""
        for _ in range(REFINEMENTS):
            middle = 0.5 * (table.angles[:-1] + table.angles[1:])
            guess = table.interpolate(middle)
            poses = self._newton(guess, middle)
            miss = self._scaled_distance(poses, guess)
            for k in np.flatnonzero(miss > STRAYED):
                poses[k] = self._walk(float(table.angles[k]), table.poses[k : k + 1], float(middle[k]))[0]
            coarse = miss > TABLE_MISS
            if not coarse.any():
                break
            rows = middle[coarse]
            table = table.with_rows(rows, poses[coarse], self._slope(poses[coarse], rows))
        return table

    def _walk(self, angle: float, poses: Array, goal: float) -> Array:
        """Poses (1, 3 n) at a goal angle, reached from those at another without leaving the branch."""
        return [poses, *(reached for _, reached in self._steps(angle, poses, goal))][-1]

    def _steps(self, angle: float, poses: Array, goal: float) -> Iterator[tuple[float, Array]]:
        """Angles and poses on the way to a goal, in steps as small as the motion asks for.

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
                raise InvalidInput(self._cannot_turn(np.array([following])))

    def _try_step(self, angle: float, poses: Array, following: float) -> Array | None:
        """Poses after a step along the tangent; None if they strayed from it or changed branch."""
        guess = poses + self._slope(poses, np.array([angle])) * (following - angle)
        try:
            reached = self._newton(guess, np.array([following]))
        except InvalidInput:
            return None
        if self._scaled_distance(reached, guess)[0] > WALK_MISS:
            return None
        return reached if self.branch(reached)[0] == self.assembled_branch else None

    def _scaled_distance(self, first: Array, second: Array) -> Array:
        """Largest difference of poses (T,), lengths against the mechanism's size."""
        return np.asarray(np.abs((first - second) / self._scale).max(axis=1))

    def _gain(self, first: Array, last: Array) -> Array:
        """What one turn adds to the poses: whole turns of bodies, and nothing else."""
        gain = (last - first).reshape(-1, 3)
        whole = 2.0 * np.pi * np.rint(gain[:, 2] / (2.0 * np.pi))
        if np.abs(gain[:, :2]).max() > 1e-9 * self.size or np.abs(gain[:, 2] - whole).max() > 1e-9:
            raise InvalidInput(f"{self.mechanism.name} does not return to its start pose after one turn of the crank")
        return np.column_stack([np.zeros((len(gain), 2)), whole]).ravel()

    def _slope(self, poses: Array, angle: Array) -> Array:
        """Derivative of the poses by the crank angle."""
        residual = self._residual([poses, np.zeros_like(poses)], angle)[1]
        return -_solve(self.jacobian(poses), residual)

    def _scaled(self, jacobian: Array) -> Array:
        """The Jacobian with lengths in units of the mechanism's size, so that its determinant has no unit."""
        scaled = jacobian.copy()
        scaled[:, :, 2::3] /= self.size
        return scaled


def _inverse(matrix: Array) -> Array:
    """Batch of inverses; not finite where a matrix is singular."""
    try:
        return np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:
        return np.full_like(matrix, np.nan)


def _solve(matrix: Array, right: Array) -> Array:
    """Batch of square systems with one right-hand side each; not finite where a matrix is singular."""
    try:
        return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0])
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)
