"""Exact motion of any `Mechanism`, by Newton iteration on its joint equations; and of one at constant speed.

The generic reference, which knows nothing of a scene's closed form. Poses q come from Newton iteration. Derivatives by
the crank angle follow order by order from linear systems with one and the same Jacobian J, because the k-th Taylor
coefficient of the joint equations is J q_k + (a term in q_0 .. q_(k-1)).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from conrod.errors import InvalidInput
from conrod.exact.assembly_branch import AssemblyBranch
from conrod.exact.elimination import Elimination
from conrod.exact.equations import Equations
from conrod.exact.joint_equations import active_arcs, pose_jets
from conrod.exact.motion import BREAK_WIDTH, Array, Motion, PointDerivatives, Side, diameter, motion_in_time
from conrod.mechanism.mechanism import Mechanism
from conrod.mechanism.units import REVOLUTION

ARC_SAMPLES, ARC_HALVINGS = 720, 60  # per revolution, to find the ends of cam arcs
SAMPLE_OFFSET = 0.3  # of those samples, as a share of their spacing
MOTION_ORDER = 3  # position to jerk
RANGE_SAMPLES = 720  # of a revolution or a pass, from which ranges of rotation are taken
MAX_CACHED_GEOMETRIES = 128
SAMPLES_TOGETHER = 2048  # solved at once: more would not fit the cache, fewer would be mostly overhead
TURNS_WITHOUT_REPEAT = 2  # revolutions sampled if poses do not repeat after one


class Kinematics:
    """Solver for the exact motion of one mechanism, on the assembly branch of its start poses.

    Attributes:
        size: largest coordinate [m] in the mechanism's start poses.
        crank_column: column of the crank's rotation in the stacked poses.
        poses, reachable_angle, near_change: methods of `AssemblyBranch`.
        jacobian, equations_of: methods of `Equations`.
        branch: sign (T,) that distinguishes the assembly branches of poses (T, 3 n).
        branch_at: the sign (T,) that exact poses at crank angles (T,) [rad] have; it changes at change points.

    Args:
        nearby: solver of a machine with about these lengths, from whose poses those of this one are found, as in fits.

    Raises:
        InvalidInput: the mechanism cannot be assembled, its mobility is not one, or its crank cannot turn fully.
    """

    def __init__(self, mechanism: Mechanism, nearby: Kinematics | None = None) -> None:
        if mechanism.mobility != 1:
            raise InvalidInput(f"{mechanism.name} has mobility {mechanism.mobility}; a driven crank needs exactly 1")
        self.mechanism = mechanism
        poses = tuple((body.name, mechanism.poses[body.name]) for body in mechanism.bodies)
        geometry = _Geometry(mechanism, (mechanism.name, mechanism.joints, mechanism.driver, poses))
        self._branch: AssemblyBranch = _cached_branch(geometry, None if nearby is None else nearby._branch)
        self._equations = self._branch.equations
        self.size, self.crank_column = self._equations.size, 3 * self._equations.crank + 2
        self.poses, self.reachable_angle, self.near_change = (
            self._branch.poses,
            self._branch.reachable_angle,
            self._branch.near_change,
        )
        self.jacobian, self.equations_of = self._equations.jacobian, self._equations.equations_of
        self.branch, self.branch_at = self._branch.branch, self._branch.branch_at

    def derivatives(self, angle: Array, order: int = MOTION_ORDER, side: Side = "right") -> list[Array]:
        """Poses and their derivatives by the crank angle at (T,) [rad], up to `order`; each (T, 3 n)."""
        coefficients = self._branch.series(angle, order, side)
        return [math.factorial(k) * c for k, c in enumerate(coefficients)]

    @property
    def change_angles(self) -> Array:
        """Crank angles [rad] of the change points in one revolution or the driver's span."""
        return self._branch.change_angles

    def conditioning(self, poses: Array) -> Array:
        """Smallest singular value (T,) of the scaled Jacobian; it vanishes where the linkage gains a freedom.

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
        return self._branch.start

    @cached_property
    def lengths(self) -> dict[str, float]:
        """Travel L [m] of each observed point: the largest distance between two of its positions in one revolution.

        For a linkage whose crank cannot turn fully it is the size of the mechanism.
        """
        table = self._branch.table
        if table is None:
            return {observed.name: self.size for observed in self.mechanism.observed}
        return {name: diameter(p[0]) for name, p in self.point_derivatives([table.poses]).items()}

    @cached_property
    def rotation_ranges(self) -> dict[str, float]:
        """Range [rad] of each body's rotation over one revolution or the driver's span: greatest less least angle."""
        angles = self.poses(np.linspace(*self.span, RANGE_SAMPLES + 1))[:, 2::3]
        return {
            body.name: float(size) for body, size in zip(self.mechanism.bodies, np.ptp(angles, axis=0), strict=True)
        }

    @property
    def turns_fully(self) -> bool:
        """True if the crank makes full revolutions on the assembly branch."""
        return self.mechanism.driver.span is None and self._branch.table is not None

    @property
    def repeats(self) -> bool:
        """True if the crank turns fully and all poses repeat after each turn, as behind gears they need not."""
        table = self._branch.table
        return self.mechanism.driver.span is None and table is not None and table.gain is not None

    @property
    def span(self) -> tuple[float, float]:
        """Crank angles [rad] between which the machine is examined: one revolution, or the driver's span."""
        return self.mechanism.driver.span or (0.0, REVOLUTION)

    def angles(self, count: int) -> Array:
        """Return evenly spaced crank angles [rad]: one revolution without its end, or the driver's span with both ends.

        Over two revolutions if the second differs from the first, as behind gears: a run of usual length makes two.

        Raises:
            InvalidInput: names a span that the linkage does not reach.
        """
        if self.turns_fully and not self.repeats:
            return np.linspace(0.0, TURNS_WITHOUT_REPEAT * 2.0 * math.pi, count, endpoint=False)
        return np.linspace(*self.span, count, endpoint=self.mechanism.driver.span is not None)

    @property
    def travel(self) -> float:
        """Largest travel [m] of an observed point; the size of the mechanism if its crank cannot turn fully."""
        return max(self.lengths.values())

    @cached_property
    def break_angles(self) -> tuple[float, ...]:
        """Crank angles [rad] in [0, 2 pi) where a roller's acceleration or jerk jumps, between arcs or laws."""
        return self._arc_ends(jumps_only=True)

    @cached_property
    def arc_ends(self) -> tuple[float, ...]:
        """Crank angles [rad] in [0, 2 pi) where a roller passes any joint of its cam's arcs or laws."""
        return self._arc_ends(jumps_only=False)

    def _arc_ends(self, jumps_only: bool) -> tuple[float, ...]:
        """Crank angles where a roller changes arcs; only those where a derivative jumps if `jumps_only`."""
        found: list[float] = []
        angles = np.linspace(*self.span, ARC_SAMPLES + 1)
        if self.mechanism.driver.span is None:
            angles -= SAMPLE_OFFSET * angles[1]  # a joint at angle 0 is met once, and within
        for k, contact in enumerate(self.mechanism.cam_contacts):
            arcs = self._arcs(angles, k)
            passed = [
                left
                for left in np.flatnonzero(arcs[:-1] != arcs[1:])
                if not jumps_only or contact.profile.jumps(int(arcs[left]), int(arcs[left + 1]))
            ]
            if passed:
                found += [
                    float(angle) for angle in self._bisect_arc_ends(angles[passed], angles[np.array(passed) + 1], k)
                ]
        if self.mechanism.driver.span is None:
            found = [angle % REVOLUTION if angle % REVOLUTION < REVOLUTION - BREAK_WIDTH else 0.0 for angle in found]
        return tuple(sorted(found))

    def _arcs(self, angles: Array, contact: int) -> Array:
        """Arc index (T,) that the roller of a numbered contact touches at crank angles (T,)."""
        bodies = pose_jets(self.mechanism, [self.poses(angles)])
        return active_arcs(self.mechanism.cam_contacts[contact], bodies).astype(float)

    def _bisect_arc_ends(self, low: Array, high: Array, contact: int) -> Array:
        """Angles (B,) [rad] between two limits at which a roller leaves the arc of the lower limit."""
        before = self._arcs(low, contact)
        for _ in range(ARC_HALVINGS):
            middle = 0.5 * (low + high)
            same = self._arcs(middle, contact) == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return np.asarray(0.5 * (low + high))

    # -- observed points ---------------------------------------------------------------------------------------

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0, side: Side = "right") -> Motion:
        """Exact motion of the observed points; arguments as for `ExactReference.motion`."""
        angle = np.atleast_1d(np.asarray(angle, dtype=float))
        return motion_in_time(
            lambda some: self.planar_derivatives(self.derivatives(some, side=side)),
            angle,
            speed,
            acceleration,
            SAMPLES_TOGETHER,
        )

    def positions(self, angle: Array) -> dict[str, tuple[Array, Array]]:
        """Exact x and y of each observed point, each (T,), at crank angles (T,) [rad]; `motion` gives rates too."""
        derivatives = self.planar_derivatives(self.derivatives(angle, order=0))
        return {
            name: (np.broadcast_to(x[0], angle.shape), np.broadcast_to(y[0], angle.shape))
            for name, (x, y) in derivatives.items()
        }

    def point_derivatives(self, derivatives: list[Array]) -> dict[str, list[Array]]:
        """Observed points and their derivatives, each (T, 2), from derivatives of the poses."""
        return {
            name: [np.column_stack([x, y]) for x, y in zip(*planar, strict=True)]
            for name, planar in self.planar_derivatives(derivatives).items()
        }

    def planar_derivatives(self, derivatives: list[Array]) -> dict[str, PointDerivatives]:
        """x and y of each observed point with derivatives, each (T,), from derivatives of the poses."""
        bodies = pose_jets(self.mechanism, [d / math.factorial(k) for k, d in enumerate(derivatives)])
        points: dict[str, PointDerivatives] = {}
        for observed in self.mechanism.observed:
            planar = [jet.coefficients for jet in bodies[observed.body].point(observed.point)]
            x, y = ([math.factorial(k) * c for k, c in enumerate(along)] for along in planar)
            points[observed.name] = x, y
        return points

    # -- equations ---------------------------------------------------------------------------------------------

    def solve(self, poses: Array, right: Array) -> Array:
        """Solve J dq = right for pose changes dq (T, 3 n), at poses (T, 3 n), by elimination."""
        return self.factors(poses).solve(list(right.T))

    def factors(self, poses: Array) -> Elimination:
        """Factors of the Jacobian J at poses (T, 3 n), for several right-hand sides."""
        return self._equations.elimination(poses)

    def residual(self, derivatives: list[Array], crank: Array) -> Array:
        """Residual (T, 3 n) of all equations in a measured state, differentiated as often as the state is.

        Args:
            derivatives: stacked poses, their rates, their accelerations (T, 3 n), the first one, two or three.
            crank: angle, rate or angular acceleration (T,) of the crank, of the order of the highest derivative.
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
    """A mechanism, equal to all others that move alike: masses, loads and observed points do not count."""

    mechanism: Mechanism = field(compare=False)
    moves: tuple[Hashable, ...]


@lru_cache(MAX_CACHED_GEOMETRIES)
def _cached_branch(geometry: _Geometry, nearby: AssemblyBranch | None) -> AssemblyBranch:
    """Return the assembly branch of a geometry; cached, because its table takes longer than many runs."""
    return AssemblyBranch(Equations(geometry.mechanism), nearby)


# -- a machine driven at constant speed, which engines run and are compared with ---------------------------------------


class ExactReference(ABC):
    """The exact motion of a mechanism as a function of the crank angle, and of time at constant speed.

    The motion comes from the generic solver (`Kinematics`) unless a subclass knows it in closed form.
    """

    speed: float  # crank speed [rad/s]; the crank angle is speed x time

    @abstractmethod
    def mechanism(self) -> Mechanism:
        """The declarative description, source of the generic solver and of the engines' models."""

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0, side: Side = "right") -> Motion:
        """Return the exact motion of all observed points at crank angles.

        Args:
            angle: crank angles (T,) [rad].
            speed: crank speed [rad/s], a number or (T,).
            acceleration: crank angular acceleration [rad/s^2], constant in time if the jerk is used.
            side: the limit to take where the acceleration jumps, seen along increasing crank angle.
        """
        return self.kinematics.motion(angle, speed, acceleration, side)

    def break_angles(self) -> tuple[float, ...]:
        """Crank angles [rad] in [0, 2 pi) at which the acceleration or the jerk jumps."""
        return self.kinematics.break_angles

    @property
    def lengths(self) -> Mapping[str, float]:
        """Travel L [m] of each observed point: the largest distance between two of its exact positions.

        Position errors are divided by it (docs/design.md, 'Errors have names').
        """
        return self.kinematics.lengths

    @property
    def period(self) -> float:
        """Time of one crank revolution [s]."""
        return 2.0 * np.pi / abs(self.speed)

    @cached_property
    def kinematics(self) -> Kinematics:
        """The generic solver of this mechanism."""
        return Kinematics(self.mechanism())

    def reference(self, times: ArrayLike, side: Side = "right") -> Motion:
        """Return the exact motion at times (T,) [s] at constant speed; `side` is seen along increasing time."""
        backward: Side = "left" if side == "right" else "right"
        seen = side if self.speed > 0 else backward
        return self.motion(self.speed * np.atleast_1d(np.asarray(times, dtype=float)), self.speed, 0.0, seen)


@dataclass(frozen=True)
class GenericReference(ExactReference):
    """A mechanism without a closed form, solved by Newton iteration on its joint equations."""

    described: Mechanism
    speed: float

    def mechanism(self) -> Mechanism:
        return self.described
