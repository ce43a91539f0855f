"""All equations of a mechanism together, its joints' and its driver's, in the stacked poses of its bodies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.joint_equations import active_arcs, joint_jacobian, joint_residual, pose_jets
from conrod.mechanism import GROUND, CamContact, Joint, Mechanism
from conrod.motion import BREAK_WIDTH, Array, Side

NEWTON_STEPS = 30
# Newton converges quadratically: after a step this small (lengths against the mechanism's size) its square is left.
NEWTON_DONE = 1e-9

Arcs = dict[str, NDArray[np.intp]]


class Equations:
    """The equations of one mechanism, with Newton iteration on them.

    Attributes:
        mechanism: the mechanism.
        approximate: its given start poses (1, 3 n) [m, m, rad].
        size: the largest coordinate [m] in them.
        crank: index of the driven body.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.crank = mechanism.body_index[mechanism.crank]
        start = np.array([mechanism.poses[body.name] for body in mechanism.bodies], dtype=float)
        # Newton works on lengths in units of the mechanism's size, so that its tolerance fits mm and km alike.
        self.size = float(np.abs(start[:, :2]).max()) or 1.0
        self.approximate = start.reshape(1, -1)
        self._scale = np.tile([self.size, self.size, 1.0], len(mechanism.bodies))

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
        matrix[:, row, 3 * self.crank + 2] = 1.0
        return matrix

    def scaled_jacobian(self, poses: Array) -> Array:
        """The Jacobian with lengths in units of the mechanism's size, so that its determinant has no unit."""
        scaled = self.jacobian(poses)
        scaled[:, :, 2::3] /= self.size
        return scaled

    @staticmethod
    def count(joint: Joint) -> int:
        """Number of equations of a joint: two for a lower pair, one for a higher one."""
        return 1 if isinstance(joint, CamContact) else 2

    def residual(self, coefficients: list[Array], angle: Array, arcs: Arcs | None = None) -> list[Array]:
        """Taylor coefficients by the crank angle of all equations, each (T, 3 n).

        Args:
            coefficients: those of the stacked poses, each (T, 3 n).
            angle: crank angles (T,) [rad].
        """
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

    def slope(self, poses: Array, arcs: Arcs | None = None) -> Array:
        """First derivative (T, 3 n) of the poses by the crank angle; not finite where it does not exist."""
        # The driver's rate is the same at every angle, so any will do.
        residual = self.residual([poses, np.zeros_like(poses)], np.zeros(len(poses)), arcs)[1]
        return -_solve(self.jacobian(poses, arcs), residual)

    def arcs(self, poses: Array, side: Side) -> Arcs:
        """The cam arcs in force on one side of each angle.

        Velocity is continuous across tangent arcs, so a move by +-`BREAK_WIDTH` along it tells the side.
        """
        contacts = self.mechanism.cam_contacts
        if not contacts:
            return {}
        bodies = pose_jets(self.mechanism, [poses])
        here = {joint.name: active_arcs(joint, bodies) for joint in contacts}
        width = BREAK_WIDTH if side == "right" else -BREAK_WIDTH
        moved = pose_jets(self.mechanism, [poses + width * self.slope(poses, here)])
        return {joint.name: active_arcs(joint, moved) for joint in contacts}

    def newton(self, guess: Array, angle: Array) -> Array:
        """Poses (T, 3 n) that fit the crank angles (T,), near a guess.

        Raises:
            InvalidInput: the iteration does not converge at every angle.
        """
        poses = guess.copy()
        for _ in range(NEWTON_STEPS):
            step = _solve(self.jacobian(poses), self.residual([poses], angle)[0])
            poses -= step
            if not np.all(np.isfinite(step)):
                break
            if np.abs(step / self._scale).max() <= NEWTON_DONE:
                return poses
        raise InvalidInput(self.cannot_turn(angle))

    def distance(self, first: Array, second: Array) -> Array:
        """Largest difference of poses (T,), lengths against the mechanism's size."""
        return np.asarray(np.abs((first - second) / self._scale).max(axis=1))

    def cannot_turn(self, angle: Array) -> str:
        """What to say of angles (T,) [rad] that the linkage does not reach."""
        lowest, highest = np.degrees([angle.min(), angle.max()])
        return f"{self.mechanism.name} cannot be assembled at every crank angle from {lowest:.6g} to {highest:.6g} deg"


def _solve(matrix: Array, right: Array) -> Array:
    """Batch of square systems with one right-hand side each; not finite where a matrix is singular."""
    try:
        return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0])
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)
