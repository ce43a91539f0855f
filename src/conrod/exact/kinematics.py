"""Exact motion of any `Mechanism`, by Newton iteration on its joint equations.

The generic reference: it knows nothing of a scene's closed form. Poses come from Newton iteration; derivatives by
the crank angle then follow, order by order, from linear systems with one and the same Jacobian, because the
k-th Taylor coefficient of the joint equations is J q_k + (a term in q_0 .. q_(k-1)).
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from conrod.errors import InvalidInput
from conrod.exact.branch_walk import BranchWalk
from conrod.exact.elimination import Elimination
from conrod.exact.equations import Equations
from conrod.exact.joint_equations import active_arcs, pose_jets
from conrod.exact.motion import BREAK_WIDTH, Array, Motion, PointDerivatives, Side, diameter, motion_in_time
from conrod.mechanism.mechanism import Mechanism

SAMPLES, HALVINGS = 720, 60  # of a turn, where joints of cams are looked for
ASIDE = 0.3  # of a sample's spacing
TURN = 2.0 * np.pi
MOTION_ORDER = 3  # position to jerk
GEOMETRIES_KEPT = 128
CHUNK = 2048  # samples solved together: more would not fit the cache, fewer would be mostly calls
DIFFERENT_TURNS = 2  # that are looked at where one is not like the next


class Kinematics:
    """Solver for one mechanism, on the assembly branch of its start poses.

    Attributes:
        size: largest coordinate [m] in the mechanism's start poses; crank_column: place of the crank's turn in poses.
        poses, reach, near_change: as of `BranchWalk`; jacobian: as of `Equations`, whose `count` is equations_of.
        branch: sign (T,) that distinguishes the assembly branches of poses (T, 3 n).
        branch_at: the sign (T,) that exact poses at crank angles (T,) [rad] have; it changes at change points.

    Raises:
        InvalidInput: the mechanism cannot be assembled, has not mobility one, or cannot turn fully.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        if mechanism.mobility != 1:
            raise InvalidInput(f"{mechanism.name} has mobility {mechanism.mobility}; a driven crank needs exactly 1")
        self.mechanism = mechanism
        poses = tuple((body.name, mechanism.poses[body.name]) for body in mechanism.bodies)
        self._walk = _walk_of(_Geometry(mechanism, (mechanism.name, mechanism.joints, mechanism.driver, poses)))
        self._equations = self._walk.equations
        self.size, self.crank_column = self._equations.size, 3 * self._equations.crank + 2
        self.poses, self.reach, self.near_change = self._walk.poses, self._walk.reach, self._walk.near_change
        self.jacobian, self.equations_of = self._equations.jacobian, self._equations.count
        self.branch, self.branch_at = self._walk.branch_of, self._walk.sign

    def derivatives(self, angle: Array, order: int = MOTION_ORDER, side: Side = "right") -> list[Array]:
        """Poses and their derivatives by the crank angle up to `order`; each (T, 3 n)."""
        coefficients = self._walk.series(angle, order, side)
        return [math.factorial(k) * c for k, c in enumerate(coefficients)]

    @property
    def change_angles(self) -> Array:
        """Crank angles [rad] of change points of the turn or the span, where the motion goes on smoothly."""
        return self._walk.change_angles

    def conditioning(self, poses: Array) -> Array:
        """Smallest singular value of the scaled Jacobian (T,); it vanishes where the linkage gains a freedom.

        Zero also where the Jacobian does not exist: a roller on the axis of its cam.
        """
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            jacobian = self._equations.scaled_jacobian(poses)
        exists = np.isfinite(jacobian).all(axis=(1, 2))
        least = np.zeros(len(poses))
        least[exists] = np.linalg.svd(jacobian[exists], compute_uv=False)[:, -1]
        return least

    @property
    def start(self) -> Array:
        """Exact poses at crank angle 0; (1, 3 n)."""
        return self._walk.start

    @cached_property
    def lengths(self) -> dict[str, float]:
        """Largest distance [m] between two exact positions of each observed point, over the sampled poses of a turn.

        The size of the mechanism stands in where the linkage cannot turn.
        """
        table = self._walk.table
        if table is None:
            return {observed.name: self.size for observed in self.mechanism.observed}
        return {name: diameter(p[0]) for name, p in self.point_derivatives([table.poses]).items()}

    @property
    def turns_fully(self) -> bool:
        """True where the crank turns all the way round on the assembly branch."""
        return self.mechanism.driver.span is None and self._walk.table is not None

    @property
    def repeats(self) -> bool:
        """True where the crank turns fully, and each turn is like the last; after one, gears may stand elsewhere."""
        table = self._walk.table
        return self.mechanism.driver.span is None and table is not None and table.gain is not None

    @property
    def span(self) -> tuple[float, float]:
        """The crank angles [rad] between which the machine is looked at: one turn, or the driver's span."""
        return self.mechanism.driver.span or (0.0, 2.0 * math.pi)

    def angles(self, count: int) -> Array:
        """So many crank angles [rad], evenly over the turn without its end, or over the driver's span with both ends.

        Over two turns where they differ, as behind gears: what a run of usual length passes.

        Raises:
            InvalidInput: names a span that the linkage does not reach.
        """
        if self.turns_fully and not self.repeats:
            return np.linspace(0.0, DIFFERENT_TURNS * 2.0 * math.pi, count, endpoint=False)
        return np.linspace(*self.span, count, endpoint=self.mechanism.driver.span is not None)

    @property
    def travel(self) -> float:
        """The largest distance [m] that an observed point moves in a turn; the size of a linkage that cannot turn."""
        return max(self.lengths.values())

    @cached_property
    def break_angles(self) -> tuple[float, ...]:
        """Angles [rad] in [0, 2 pi) where a roller passes a joint of its cam's arcs or laws that jerks it."""
        return self._arc_ends(jumps_only=True)

    @cached_property
    def arc_ends(self) -> tuple[float, ...]:
        """Angles [rad] in [0, 2 pi) where a roller passes any joint of its cam's arcs or laws."""
        return self._arc_ends(jumps_only=False)

    def _arc_ends(self, jumps_only: bool) -> tuple[float, ...]:
        found: list[float] = []
        angles = np.linspace(*self.span, SAMPLES + 1)
        if self.mechanism.driver.span is None:
            angles -= ASIDE * angles[1]  # a joint at angle 0 is met once, and within
        for k, contact in enumerate(self.mechanism.cam_contacts):
            arcs = self._arcs(angles, k)
            passed = [
                left
                for left in np.flatnonzero(arcs[:-1] != arcs[1:])
                if not jumps_only or contact.profile.jumps(int(arcs[left]), int(arcs[left + 1]))
            ]
            if passed:
                found += [float(angle) for angle in self._bisect(angles[passed], angles[np.array(passed) + 1], k)]
        if self.mechanism.driver.span is None:
            found = [angle % TURN if angle % TURN < TURN - BREAK_WIDTH else 0.0 for angle in found]
        return tuple(sorted(found))

    def _arcs(self, angles: Array, contact: int) -> Array:
        bodies = pose_jets(self.mechanism, [self.poses(angles)])
        return active_arcs(self.mechanism.cam_contacts[contact], bodies).astype(float)

    def _bisect(self, low: Array, high: Array, contact: int) -> Array:
        """Angles (B,) [rad] at which the arc at the lower ends ceases to be in force."""
        before = self._arcs(low, contact)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            same = self._arcs(middle, contact) == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return np.asarray(0.5 * (low + high))

    # -- observed points ---------------------------------------------------------------------------------------

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0, side: Side = "right") -> Motion:
        """Exact motion of the observed points; arguments as in `ExactReference.motion`."""
        angle = np.atleast_1d(np.asarray(angle, dtype=float))
        return motion_in_time(
            lambda some: self.planar_derivatives(self.derivatives(some, side=side)), angle, speed, acceleration, CHUNK
        )

    def point_derivatives(self, derivatives: list[Array]) -> dict[str, list[Array]]:
        """Observed points and their derivatives, each (T, 2), from those of the poses."""
        return {
            name: [np.column_stack([x, y]) for x, y in zip(*planar, strict=True)]
            for name, planar in self.planar_derivatives(derivatives).items()
        }

    def planar_derivatives(self, derivatives: list[Array]) -> dict[str, PointDerivatives]:
        """x and y of the observed points with their derivatives, each (T,), from those of the poses."""
        bodies = pose_jets(self.mechanism, [d / math.factorial(k) for k, d in enumerate(derivatives)])
        points: dict[str, PointDerivatives] = {}
        for observed in self.mechanism.observed:
            planar = [jet.coefficients for jet in bodies[observed.body].point(observed.point)]
            x, y = ([math.factorial(k) * c for k, c in enumerate(along)] for along in planar)
            points[observed.name] = x, y
        return points

    # -- equations ---------------------------------------------------------------------------------------------

    def solve(self, poses: Array, right: Array) -> Array:
        """Changes of the poses (T, 3 n) that make changes (T, 3 n) of all equations: J^-1 right, by elimination."""
        return self.factors(poses).solve(list(right.T))

    def factors(self, poses: Array) -> Elimination:
        """The factors of J at poses (T, 3 n), for several right-hand sides."""
        return self._equations.elimination(poses)

    def residual(self, derivatives: list[Array], crank: Array) -> Array:
        """Residual (T, 3 n) of all equations in a measured state: of their highest derivative in time given.

        Args:
            derivatives: stacked poses, their rates, their accelerations (T, 3 n), as many as are wanted.
            crank: the crank's angle, rate or angular acceleration (T,), the one of the highest derivative.
        """
        order = len(derivatives) - 1
        coefficients = [d / math.factorial(k) for k, d in enumerate(derivatives)]
        # Any angle does for the joints: the driver's row, the last, is made here.
        residual = self._equations.residual(coefficients, np.zeros(len(crank)))
        result = math.factorial(order) * np.stack([np.broadcast_to(r, crank.shape) for r in residual], axis=1)
        driver = self.mechanism.driver
        turn = derivatives[order][:, self.crank_column]
        result[:, -1] = turn - driver.sense * crank - (driver.start if order == 0 else 0.0)
        return result


@dataclass(frozen=True)
class _Geometry:
    """A mechanism, equal to all others that move alike: masses, forces, loads and observed points move nothing."""

    mechanism: Mechanism = field(compare=False)
    moves: tuple[Hashable, ...]


@lru_cache(GEOMETRIES_KEPT)
def _walk_of(geometry: _Geometry) -> BranchWalk:
    """The walk around the turn, whose table takes longer than many runs: once for machines that differ in masses."""
    return BranchWalk(Equations(geometry.mechanism))
