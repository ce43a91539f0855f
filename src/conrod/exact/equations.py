"""All equations of a mechanism, of its joints and its driver, in the stacked poses q of its bodies."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.elimination import Elimination, Entry, PivotOrder
from conrod.exact.joint_equations import PoseJet, active_arcs, joint_jacobian, joint_residual, pose_jets
from conrod.exact.motion import BREAK_WIDTH, Array, Side, rotate_planar
from conrod.mechanism.mechanism import GROUND, CamContact, HigherPair, Joint, Mechanism, Mesh, Point, Prismatic, Rack

MAX_NEWTON_STEPS = 30
# Last step (lengths against the mechanism's size): Newton converges quadratically, so its square is the error left.
NEWTON_TOLERANCE = 1e-9
# Start poses may be far from any that fit: the size that they give is limited to this factor of the parts' extent.
MAX_SIZE_RATIO = 3.0
CAM_OUTLINE_POINTS = 16  # of an outline, for its size
UNIT_RATIO = 1e4  # ratio of neighbouring units of length: metres serve from centimetres to a hundred metres

Arcs = dict[str, NDArray[np.intp]]


class Equations:
    """Equations of one mechanism, their derivatives, and Newton iteration on them.

    Attributes:
        mechanism: the mechanism.
        start_guess: its given start poses (1, 3 n) [m, m, rad].
        size: the largest coordinate [m] in them, but no further from the mechanism's extent than by `MAX_SIZE_RATIO`.
        scale: size of each coordinate (3 n,): the mechanism's size [m] and one radian.
        unit: unit of length [m], the power of ten thousand nearest to the size.
        rows: divisors of the equations (3 n,): the unit and one radian.
        crank: index of the driven body.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.crank = mechanism.body_index[mechanism.crank]
        start = np.array([mechanism.poses[body.name] for body in mechanism.bodies], dtype=float)
        # Newton works on lengths in units of the mechanism's size, so that its tolerance fits mm and km alike.
        size, extent = float(np.abs(start[:, :2]).max()) or 1.0, _extent(mechanism)
        self.size = min(max(size, extent / MAX_SIZE_RATIO), extent * MAX_SIZE_RATIO) if extent else size
        self.start_guess = start.reshape(1, -1)
        self.scale = np.tile([self.size, self.size, 1.0], len(mechanism.bodies))
        self.unit = UNIT_RATIO ** round(math.log(self.size, UNIT_RATIO))
        self.rows = np.append(self.row_lengths(self.unit), 1.0)
        # The numbers in the Jacobian are the mechanism's, whatever its poses: they are looked through once.
        self._order: PivotOrder | None = None

    def jacobian(self, poses: Array, arcs: Arcs | None = None) -> Array:
        """Derivative J (T, 3 n, 3 n) of all joint equations and the driver's by the poses."""
        matrix = np.zeros((len(poses), poses.shape[1], poses.shape[1]))
        for i, row in enumerate(self._rows(pose_jets(self.mechanism, [poses]), arcs)):
            for column, value in row.items():
                matrix[:, i, column] = value
        return matrix

    def scaled_jacobian(self, poses: Array) -> Array:
        """The Jacobian (T, 3 n, 3 n) with lengths over the mechanism's size, so that it has no unit."""
        scaled = self.jacobian(poses) * (self.unit / self.rows)[:, None]
        scaled[:, :, 2::3] /= self.size
        return scaled

    def elimination(self, poses: Array, arcs: Arcs | None = None) -> Elimination:
        """Factors of the Jacobian at poses (T, 3 n)."""
        return self._factor(pose_jets(self.mechanism, [poses]), len(poses), arcs)

    def _factor(self, bodies: dict[str, PoseJet], samples: int, arcs: Arcs | None = None) -> Elimination:
        """Factor the Jacobian of pose jets, with the pivot order of earlier calls."""
        factors = Elimination(self._rows(bodies, arcs), samples, self._order)
        self._order = factors.order
        return factors

    def _rows(self, bodies: dict[str, PoseJet], arcs: Arcs | None = None) -> list[dict[int, Entry]]:
        """Rows of the Jacobian, each as its entries by column."""
        rows = []
        for joint in self.mechanism.joints:
            for both in joint_jacobian(joint, bodies, (arcs or {}).get(joint.name)):
                row: dict[int, Entry] = {}
                for body, entries in zip((joint.a, joint.b), both, strict=True):
                    if body != GROUND:
                        first = 3 * self.mechanism.body_index[body]
                        row |= {first + k: entry for k, entry in enumerate(entries)}
                rows.append(row)
        return [*rows, {3 * self.crank + 2: 1.0}]

    @staticmethod
    def equations_of(joint: Joint) -> int:
        """Number of equations of a joint: two for a lower pair, one for a higher one."""
        return 1 if isinstance(joint, HigherPair) else 2

    def row_lengths(self, length: float) -> Array:
        """Divisors (3 n - 1,) of the joints' equations: a length [m], but 1 for the angle of a slide."""
        joints = self.mechanism.joints
        return np.concatenate(
            [[length, 1.0] if isinstance(j, Prismatic) else [length] * self.equations_of(j) for j in joints]
        )

    def residual(self, coefficients: list[Array], angle: Array, arcs: Arcs | None = None) -> list[Entry]:
        """Residual of all equations along a series of poses: its Taylor coefficient of the highest order given.

        Args:
            coefficients: Taylor coefficients of the stacked poses by the crank angle, each (T, 3 n).
            angle: crank angles (T,) [rad].
        """
        return self._residual(pose_jets(self.mechanism, coefficients), len(coefficients) - 1, angle, arcs)

    def _residual(self, bodies: dict[str, PoseJet], order: int, angle: Array, arcs: Arcs | None = None) -> list[Entry]:
        """Residual of all equations of pose jets: the Taylor coefficient of one order."""
        joints = [
            equation.coefficients[order]
            for joint in self.mechanism.joints
            for equation in joint_residual(joint, bodies, (arcs or {}).get(joint.name))
        ]
        driver, turn = self.mechanism.driver, bodies[self.mechanism.crank].phi.coefficients[order]
        prescribed = (driver.start + driver.sense * angle, float(driver.sense))
        return [*joints, turn - prescribed[order] if order < len(prescribed) else turn]

    def pose_derivative(self, poses: Array, arcs: Arcs | None = None, factors: Elimination | None = None) -> Array:
        """First derivative dq/dtheta (T, 3 n) of the poses by the crank angle; not finite where it does not exist.

        Args:
            factors: result of `elimination` at these poses, if it is known.
        """
        # The driver's rate is the same at every angle, so any will do.
        residual = self.residual([poses, np.zeros_like(poses)], np.zeros(len(poses)), arcs)
        return -(factors or self.elimination(poses, arcs)).solve(residual)

    def series(self, poses: Array, angle: Array, order: int, arcs: Arcs | None = None) -> list[Array]:
        """Taylor coefficients of the poses by the crank angle up to an order, the poses first; each (T, 3 n).

        The k-th, q_k, solves J q_k = -r_k, with r_k the k-th coefficient of the residual for q_k = 0. Coefficients are
        not finite where J is singular.
        """
        # One matrix for all orders, so it is factored once.
        factors = self.elimination(poses, arcs)
        coefficients, zero = [poses], np.zeros_like(poses)
        for _ in range(order):
            coefficients.append(-factors.solve(self.residual([*coefficients, zero], angle, arcs)))
        return coefficients

    def arcs(self, poses: Array, side: Side) -> Arcs:
        """Index (T,) of the cam arc in contact on one side of each angle, by contact.

        The side is found by a move of +-`BREAK_WIDTH` along the velocity, which is continuous across tangent arcs.
        """
        contacts = self.mechanism.cam_contacts
        if not contacts:
            return {}
        bodies = pose_jets(self.mechanism, [poses])
        here = {joint.name: active_arcs(joint, bodies) for joint in contacts}
        width = BREAK_WIDTH if side == "right" else -BREAK_WIDTH
        moved = pose_jets(self.mechanism, [poses + width * self.pose_derivative(poses, here)])
        return {joint.name: active_arcs(joint, moved) for joint in contacts}

    def newton(self, guess: Array, angle: Array, attempts: int = MAX_NEWTON_STEPS, falling: bool = False) -> Array:
        """Solve for poses (T, 3 n) at crank angles (T,) [rad] near a guess, by Newton iteration.

        Args:
            attempts: largest number of steps.
            falling: stop as soon as a step is longer than the previous one, which does not happen from a good guess.

        Raises:
            InvalidInput: the iteration does not converge at every angle.
        """
        poses, longest = guess.copy(), math.inf
        for _ in range(attempts):
            # A guess may lie where an equation has no derivative, a roller on a cam's axis; what is not finite ends it.
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                bodies = pose_jets(self.mechanism, [poses])
                step = self._factor(bodies, len(poses)).solve(self._residual(bodies, 0, angle))
            poses -= step
            length = float(np.abs(step / self.scale).max(initial=0.0))
            if not math.isfinite(length) or (falling and length > longest):
                break
            if length <= NEWTON_TOLERANCE:
                return poses
            longest = length
        raise InvalidInput(self.cannot_turn(angle))

    def pose_distance(self, first: Array, second: Array) -> Array:
        """Largest difference of poses (T,), lengths against the mechanism's size."""
        return np.asarray(np.abs((first - second) / self.scale).max(axis=1))

    def cannot_turn(self, angle: Array) -> str:
        """Error message for crank angles (T,) [rad] that the linkage does not reach."""
        lowest, highest = np.degrees([angle.min(), angle.max()])
        if lowest == highest:
            return (
                f"{self.mechanism.name} cannot be assembled at crank angle {lowest:.6g} deg: lengths do not reach, or "
                "the start poses are too far from any that fit"
            )
        return f"{self.mechanism.name} cannot be assembled at every crank angle from {lowest:.6g} to {highest:.6g} deg"


def _extent(mechanism: Mechanism) -> float:
    """Largest distance [m] between joints of one body or of the ground, or radius of a wheel or a cam."""
    points: dict[str, list[Point]] = {}
    found = [0.0]
    for joint in mechanism.joints:
        if isinstance(joint, CamContact):
            found.append(joint.roller_radius + float(np.hypot(*joint.profile.outline(CAM_OUTLINE_POINTS).T).max()))
            points.setdefault(joint.b, []).append(joint.roller_centre)
            continue
        if isinstance(joint, Mesh):
            found.append(joint.radius if isinstance(joint, Rack) else joint.distance)
        points.setdefault(joint.a, []).append(joint.point_a)
        points.setdefault(joint.b, []).append(joint.point_b)
    return max([*found, *(math.dist(p, q) for of_body in points.values() for p, q in combinations(of_body, 2))])


MESH_TOLERANCE = 1e-6  # of a distance, as lengths are given in six digits or more


def check_meshes(mechanism: Mechanism, poses: Array) -> None:
    """Refuse rolling pairs whose wheels do not touch in poses (T, 3 n); InvalidInput gives both distances."""
    bodies = pose_jets(mechanism, [poses]) if mechanism.meshes else {}
    for mesh in mechanism.meshes:
        wanted = mesh.radius if isinstance(mesh, Rack) else mesh.distance
        (ax, ay), (bx, by) = bodies[mesh.a].point(mesh.point_a), bodies[mesh.b].point(mesh.point_b)
        dx, dy = (np.broadcast_to((q - p).coefficients[0], len(poses)) for p, q in ((ax, bx), (ay, by)))
        if isinstance(mesh, Rack):  # of the wheel's centre from the line
            line = np.broadcast_to(bodies[mesh.b].phi.coefficients[0], len(poses)) + mesh.direction
            found = dx * np.sin(line) - dy * np.cos(line)
        else:
            found = np.hypot(dx, dy)
        worst = float(found[np.argmax(np.abs(found - wanted))])
        if abs(worst - wanted) > MESH_TOLERANCE * wanted:
            raise InvalidInput(
                f"{mechanism.name}: {mesh.name}: the centres, or centre and line, are {worst:.9g} m apart, the radii "
                f"ask for {wanted:.9g} m; other joints must hold them so"
            )


def inertia_forces(mechanism: Mechanism, poses: Array, rates: Array, accelerations: Array) -> Array:
    """Generalised forces M q'' - Q (T, 3 n) of every body about the origin of its frame."""
    result = np.zeros_like(poses)
    for i, body in enumerate(mechanism.bodies):
        rx, ry = rotate_planar(body.centre_of_gravity, poses[:, 3 * i + 2])
        spin, turn = rates[:, 3 * i + 2], accelerations[:, 3 * i + 2]
        push = mechanism.constant_force_on(body.name)
        ax = accelerations[:, 3 * i] - turn * ry - spin**2 * rx
        ay = accelerations[:, 3 * i + 1] + turn * rx - spin**2 * ry
        fx = body.mass * (ax - mechanism.gravity[0]) - push[0]
        fy = body.mass * (ay - mechanism.gravity[1]) - push[1]
        result[:, 3 * i], result[:, 3 * i + 1] = fx, fy
        result[:, 3 * i + 2] = body.inertia * turn + rx * fy - ry * fx
    return result
