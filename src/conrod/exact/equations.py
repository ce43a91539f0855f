"""All equations of a mechanism together, its joints' and its driver's, in the stacked poses of its bodies."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.elimination import Elimination, Entry, PivotOrder
from conrod.exact.joint_equations import PoseJet, active_arcs, joint_jacobian, joint_residual, pose_jets
from conrod.exact.motion import BREAK_WIDTH, Array, Side
from conrod.mechanism.mechanism import GROUND, CamContact, HigherPair, Joint, Mechanism, Mesh, Point, Prismatic, Rack

NEWTON_STEPS = 30
# Newton converges quadratically: after a step this small (lengths against the mechanism's size) its square is left.
NEWTON_DONE = 1e-9
# Start poses may be far from any that fit: the size that they give is taken within this factor of the parts' own.
FAR_OFF = 3.0
CAM_POINTS = 16  # of an outline, for its size
UNITS = 1e4  # from one unit of length to the next: metres serve from centimetres to a hundred metres

Arcs = dict[str, NDArray[np.intp]]


class Equations:
    """The equations of one mechanism, with Newton iteration on them.

    Attributes:
        mechanism: the mechanism.
        approximate: its given start poses (1, 3 n) [m, m, rad].
        size: the largest coordinate [m] in them, but no further from the mechanism's extent than by `FAR_OFF`.
        scale: what poses are measured by (3 n,): the size [m] and one radian.
        unit: of length [m], the power of ten thousand nearest to the size.
        rows: what equations are measured by (3 n,): the unit and one radian.
        crank: index of the driven body.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.crank = mechanism.body_index[mechanism.crank]
        start = np.array([mechanism.poses[body.name] for body in mechanism.bodies], dtype=float)
        # Newton works on lengths in units of the mechanism's size, so that its tolerance fits mm and km alike.
        size, extent = float(np.abs(start[:, :2]).max()) or 1.0, _extent(mechanism)
        self.size = min(max(size, extent / FAR_OFF), extent * FAR_OFF) if extent else size
        self.approximate = start.reshape(1, -1)
        self.scale = np.tile([self.size, self.size, 1.0], len(mechanism.bodies))
        self.unit = UNITS ** round(math.log(self.size, UNITS))
        self.rows = np.append(self.row_lengths(self.unit), 1.0)
        # The numbers in the Jacobian are the mechanism's, whatever its poses: they are looked through once.
        self._order: PivotOrder | None = None

    def jacobian(self, poses: Array, arcs: Arcs | None = None) -> Array:
        """Derivative of all joint equations and of the driver's by the poses; (T, 3 n, 3 n)."""
        matrix = np.zeros((len(poses), poses.shape[1], poses.shape[1]))
        for i, row in enumerate(self._rows(pose_jets(self.mechanism, [poses]), arcs)):
            for column, value in row.items():
                matrix[:, i, column] = value
        return matrix

    def scaled_jacobian(self, poses: Array) -> Array:
        """The Jacobian with lengths in units of the mechanism's size, so that it has no unit."""
        scaled = self.jacobian(poses) * (self.unit / self.rows)[:, None]
        scaled[:, :, 2::3] /= self.size
        return scaled

    def elimination(self, poses: Array, arcs: Arcs | None = None) -> Elimination:
        """The Jacobian's factors."""
        return self._eliminated(pose_jets(self.mechanism, [poses]), len(poses), arcs)

    def _eliminated(self, bodies: dict[str, PoseJet], samples: int, arcs: Arcs | None = None) -> Elimination:
        factors = Elimination(self._rows(bodies, arcs), samples, self._order)
        self._order = factors.order
        return factors

    def _rows(self, bodies: dict[str, PoseJet], arcs: Arcs | None = None) -> list[dict[int, Entry]]:
        """Of the Jacobian, each its entries by column."""
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
    def count(joint: Joint) -> int:
        """Number of equations of a joint: two for a lower pair, one for a higher one."""
        return 1 if isinstance(joint, HigherPair) else 2

    def row_lengths(self, length: float) -> Array:
        """Divisors of the joints' equations (3 n - 1,): a length [m], but for the angle that a slide keeps."""
        joints = self.mechanism.joints
        return np.concatenate([[length, 1.0] if isinstance(j, Prismatic) else [length] * self.count(j) for j in joints])

    def residual(self, coefficients: list[Array], angle: Array, arcs: Arcs | None = None) -> list[Entry]:
        """Residual of all equations along Taylor coefficients by the crank angle: the coefficient of their order.

        Args:
            coefficients: those of the stacked poses, each (T, 3 n), as many as are wanted.
            angle: crank angles (T,) [rad].
        """
        return self._residual(pose_jets(self.mechanism, coefficients), len(coefficients) - 1, angle, arcs)

    def _residual(self, bodies: dict[str, PoseJet], order: int, angle: Array, arcs: Arcs | None = None) -> list[Entry]:
        joints = [
            equation.coefficients[order]
            for joint in self.mechanism.joints
            for equation in joint_residual(joint, bodies, (arcs or {}).get(joint.name))
        ]
        driver, turn = self.mechanism.driver, bodies[self.mechanism.crank].phi.coefficients[order]
        prescribed = (driver.start + driver.sense * angle, float(driver.sense))
        return [*joints, turn - prescribed[order] if order < len(prescribed) else turn]

    def slope(self, poses: Array, arcs: Arcs | None = None, factors: Elimination | None = None) -> Array:
        """First derivative (T, 3 n) of the poses by the crank angle; not finite where it does not exist.

        Args:
            factors: those of `elimination`, where they are at hand.
        """
        # The driver's rate is the same at every angle, so any will do.
        residual = self.residual([poses, np.zeros_like(poses)], np.zeros(len(poses)), arcs)
        return -(factors or self.elimination(poses, arcs)).solve(residual)

    def series(self, poses: Array, angle: Array, order: int, arcs: Arcs | None = None) -> list[Array]:
        """Taylor coefficients of the poses by the crank angle, from the poses themselves up to an order; each (T, 3 n).

        They are not finite where the Jacobian is singular.
        """
        # One matrix for all orders, so it is factored once.
        factors = self.elimination(poses, arcs)
        coefficients, zero = [poses], np.zeros_like(poses)
        for _ in range(order):
            coefficients.append(-factors.solve(self.residual([*coefficients, zero], angle, arcs)))
        return coefficients

    def arcs(self, poses: Array, side: Side) -> Arcs:
        """The cam arcs in force on one side of each angle.

        Velocity is continuous across tangent arcs, so a move by +-`BREAK_WIDTH` along it determines the side.
        """
        contacts = self.mechanism.cam_contacts
        if not contacts:
            return {}
        bodies = pose_jets(self.mechanism, [poses])
        here = {joint.name: active_arcs(joint, bodies) for joint in contacts}
        width = BREAK_WIDTH if side == "right" else -BREAK_WIDTH
        moved = pose_jets(self.mechanism, [poses + width * self.slope(poses, here)])
        return {joint.name: active_arcs(joint, moved) for joint in contacts}

    def newton(self, guess: Array, angle: Array, attempts: int = NEWTON_STEPS, falling: bool = False) -> Array:
        """Poses (T, 3 n) that fit the crank angles (T,), near a guess, after so many steps at most.

        Args:
            falling: give up at the first step that is longer than the one before, which from a good guess none is.

        Raises:
            InvalidInput: the iteration does not converge at every angle.
        """
        poses, longest = guess.copy(), math.inf
        for _ in range(attempts):
            # A guess may lie where an equation has no slope, a roller on a cam's axis; what is not finite ends it.
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                bodies = pose_jets(self.mechanism, [poses])
                step = self._eliminated(bodies, len(poses)).solve(self._residual(bodies, 0, angle))
            poses -= step
            length = float(np.abs(step / self.scale).max())
            if not math.isfinite(length) or (falling and length > longest):
                break
            if length <= NEWTON_DONE:
                return poses
            longest = length
        raise InvalidInput(self.cannot_turn(angle))

    def distance(self, first: Array, second: Array) -> Array:
        """Largest difference of poses (T,), lengths against the mechanism's size."""
        return np.asarray(np.abs((first - second) / self.scale).max(axis=1))

    def cannot_turn(self, angle: Array) -> str:
        """Message on angles (T,) [rad] that the linkage does not reach."""
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
            found.append(joint.roller_radius + float(np.hypot(*joint.profile.outline(CAM_POINTS).T).max()))
            points.setdefault(joint.b, []).append(joint.roller_centre)
            continue
        if isinstance(joint, Mesh):
            found.append(joint.radius if isinstance(joint, Rack) else joint.distance)
        points.setdefault(joint.a, []).append(joint.point_a)
        points.setdefault(joint.b, []).append(joint.point_b)
    return max([*found, *(math.dist(p, q) for of_body in points.values() for p, q in combinations(of_body, 2))])


# Of the distance; lengths are given in six digits or more.
OFF = 1e-6


def check_meshes(mechanism: Mechanism, poses: Array) -> None:
    """Refuse pairs whose wheels do not touch in poses (T, 3 n); raises InvalidInput with both distances."""
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
        if abs(worst - wanted) > OFF * wanted:
            raise InvalidInput(
                f"{mechanism.name}: {mesh.name}: the centres, or centre and line, are {worst:.9g} m apart, the radii "
                f"ask for {wanted:.9g} m; other joints must hold them so"
            )
