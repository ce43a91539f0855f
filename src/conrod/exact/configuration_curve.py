"""The curve of configurations that the joints, without a driver, leave to a mechanism of mobility one."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Self

import numpy as np
from threadpoolctl import ThreadpoolController

from conrod.exact.equations import Arcs, Equations
from conrod.exact.joint_equations import active_arcs, pose_jets
from conrod.exact.motion import Array
from conrod.exact.sparse_pins import Solver, SparsePins
from conrod.mechanism.mechanism import GROUND, CamContact, Mechanism
from conrod.mechanism.units import REVOLUTION

MAX_NEWTON_STEPS, NEWTON_TOLERANCE = 12, 1e-9  # quadratic convergence: the error left is the square of the last step


_libraries = cache(ThreadpoolController)


@contextmanager
def single_blas_thread() -> Iterator[None]:
    """Limit linear algebra to one thread while this context is open.

    On matrices this small threads cost more than they save: 46 s of CPU time instead of 3 s for a chain of 20
    four-bars. With one thread, last digits do not depend on the number of cores either.
    """
    with _libraries().limit(limits=1, user_api="blas"):
        yield


@dataclass(frozen=True)
class CurveFrame:
    """Tangent and curvature of the configuration curve at T points.

    Attributes:
        singular_value: estimate (T,) of the smallest singular value of the joints' Jacobian beside the tangent's 0; it
            vanishes where the linkage gains another freedom.
    """

    tangent: Array  # of unit length (T, 3 n)
    curvature: Array  # its derivative by the arc length (T, 3 n)
    singular_value: Array


class ConfigurationCurve:
    """Equations of the configuration curve; its points (T, 3 n) are poses with lengths over the mechanism's size.

    Attributes:
        mechanism: mechanism of mobility one.
        scale: size of each coordinate (3 n,) [m, m, 1].
        unit: arc length that n bodies add together when each turns by one radian.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._equations = Equations(mechanism)
        size = _link_size(mechanism) or self._equations.size
        self.scale = np.tile([size, size, 1.0], len(mechanism.bodies))
        self.unit = math.sqrt(len(mechanism.bodies))
        self._lengths = self._equations.row_lengths(size)
        self._fixed_arcs: dict[str, int] = {}
        self._pins = SparsePins.from_mechanism(mechanism, self.scale, self._lengths)

    def with_arcs(self, arcs: dict[str, int]) -> Self:
        """Return the curve for rollers that stay on given arcs of their cams, smooth beyond the arcs' ends."""
        held = copy.copy(self)
        held._fixed_arcs = dict(arcs)
        return held

    def arcs(self, point: Array) -> dict[str, int]:
        """Index of the arc that each roller touches, by cam contact, at one point (1, 3 n)."""
        contacts = self.mechanism.cam_contacts
        bodies = pose_jets(self.mechanism, [point * self.scale]) if contacts else {}
        return {joint.name: int(np.ravel(active_arcs(joint, bodies))[0]) for joint in contacts}

    def _arcs(self, samples: int) -> Arcs:
        """Fixed arcs of all contacts, repeated for each sample."""
        return {name: np.full(samples, arc, dtype=np.intp) for name, arc in self._fixed_arcs.items()}

    def jacobian(self, points: Array) -> Array:
        """Derivative (T, 3 n - 1, 3 n) of the joints' equations by the coordinates, without units."""
        full = self._equations.jacobian(points * self.scale, self._arcs(len(points)))[:, :-1, :]
        return np.asarray(full * self.scale / self._lengths[:, None])

    def residual_coefficient(self, coefficients: list[Array]) -> Array:
        """Taylor coefficient (T, 3 n - 1) of the joints' equations along Taylor coefficients of points."""
        if self._pins is not None:
            return self._pins.residual([c * self.scale for c in coefficients])
        samples = len(coefficients[0])
        rows = self._equations.residual([c * self.scale for c in coefficients], np.zeros(samples), self._arcs(samples))
        return np.stack([np.broadcast_to(row, samples) for row in rows[:-1]], axis=1) / self._lengths

    def bordered_jacobian(self, points: Array, row: Array) -> Array:
        """The Jacobian with one row added below; (T, 3 n, 3 n)."""
        below = np.broadcast_to(row, points.shape)[:, None, :]
        return np.concatenate([self.jacobian(points), below], axis=1)

    def correct_points(self, guess: Array, row: Array, done: float = NEWTON_TOLERANCE) -> Array | None:
        """Correct guesses (T, 3 n) to points of the curve by Newton iteration; None if it does not converge.

        Args:
            row: normals (T, 3 n) of the planes through the guesses in which the points are searched.
        """
        points, rows = guess.copy(), np.broadcast_to(row, guess.shape)
        for _ in range(MAX_NEWTON_STEPS):
            within = np.sum(rows * (points - guess), axis=1)[:, None]
            left = np.concatenate([self.residual_coefficient([points]), within], axis=1)
            if self._pins is not None:
                step = self._factors(points, rows).solve(left)
            else:
                try:
                    step = np.linalg.solve(self.bordered_jacobian(points, rows), left[:, :, None])[:, :, 0]
                except np.linalg.LinAlgError:
                    return None
            points = points - step
            if not np.isfinite(step).all():
                return None
            if np.abs(step).max() <= done:
                return np.asarray(points)
        return None

    def frame(self, points: Array, along: Array) -> CurveFrame:
        """Return tangents and curvatures at points (T, 3 n); `along` (T, 3 n) picks the tangent's sense."""
        # One factorisation gives all of them, at a small part of what a singular value decomposition costs.
        factors = self._factors(points, along)
        last = np.zeros_like(points)
        last[:, -1] = 1.0
        normal = factors.solve(last)
        tangent = normal / np.linalg.norm(normal, axis=1)[:, None]
        second = 2.0 * self.residual_coefficient([points, tangent, np.zeros_like(points)])
        curvature = -factors.solve_across(second, tangent)
        return CurveFrame(tangent, curvature, factors.singular_value(tangent))

    def _factors(self, points: Array, row: Array) -> BorderedFactors:
        """Factors of the Jacobian at points (T, 3 n) with one row added below."""
        if self._pins is None:
            return BorderedFactors(_dense_solvers(self.bordered_jacobian(points, row)))
        return BorderedFactors(self._pins.solvers(points * self.scale, row))

    def start_point(self) -> Array:
        """The exact point (1, 3 n) near the mechanism's start poses, with the crank held."""
        equations = self._equations
        driven = np.zeros_like(self.scale)
        driven[3 * equations.crank + 2] = 1.0
        start_guess = equations.start_guess / self.scale
        found = self.correct_points(start_guess, driven)
        return equations.newton(equations.start_guess, np.zeros(1)) / self.scale if found is None else found


def _link_size(mechanism: Mechanism) -> float:
    """Largest distance [m] of a joint or a centre of gravity from its body's origin.

    The size of the whole mechanism would not do: in a long chain the motion of one link would count for little.
    """
    far = [math.hypot(*body.centre_of_gravity) for body in mechanism.bodies]
    for joint in mechanism.joints:
        # A cam has its shaft at its origin.
        second = joint.roller_centre if isinstance(joint, CamContact) else joint.point_b
        ends = ((joint.a, getattr(joint, "point_a", (0.0, 0.0))), (joint.b, second))
        far += [math.hypot(*point) for name, point in ends if name != GROUND]
    return max(far)


def without_whole_turns(mechanism: Mechanism, difference: Array) -> Array:
    """Return a difference of points with bodies' rotations reduced to [-pi, pi)."""
    rest = difference.copy()
    rest[..., 2::3] = np.remainder(rest[..., 2::3] + math.pi, REVOLUTION) - math.pi
    return np.asarray(rest)


def _dense_solvers(matrices: Array) -> list[Solver | None]:
    """Solvers of matrices (T, k, k) by their LU factors, for `BorderedFactors`."""
    from scipy.linalg.lapack import dgetrf, dgetrs  # slow to load

    def solver(lower_upper: Array, pivots: Array, singular: int) -> Solver | None:
        if singular:
            return None
        return lambda right, transposed: dgetrs(lower_upper, pivots, right, trans=int(transposed))[0]

    return [solver(*dgetrf(matrix)) for matrix in matrices]


POWER_STEPS = 4  # power iterations for the smallest singular value, of which a few digits suffice


class BorderedFactors:
    """Factors of bordered Jacobians (T, k, k); solutions are nan where a matrix is singular.

    Args:
        solvers: of each matrix, a function that solves for a right-hand side (k,); None where it is singular.
    """

    def __init__(self, solvers: list[Solver | None]) -> None:
        self._solvers = solvers

    def solve(self, right: Array, transposed: bool = False) -> Array:
        """Solutions (T, k) for right-hand sides (T, k)."""
        found = np.full(right.shape, np.nan)
        for k, solve in enumerate(self._solvers):
            if solve is not None:
                found[k] = solve(right[k], transposed)
        return found

    def solve_across(self, right: Array, tangent: Array) -> Array:
        """Solutions (T, k) of all rows but the last, for right sides (T, k - 1), orthogonal to the tangent."""
        found = self.solve(np.column_stack([right, np.zeros(len(right))]))
        return np.asarray(found - np.sum(found * tangent, axis=1)[:, None] * tangent)

    def singular_value(self, tangent: Array) -> Array:
        """Estimate the smallest singular value (T,) of all rows but the last, by power iteration on their inverse.

        The estimate is never below it, and near it if it is much smaller than the others.
        """
        guess = np.random.default_rng(0).standard_normal(tangent.shape[1] - 1)
        left = np.broadcast_to(guess / np.linalg.norm(guess), (len(tangent), len(guess)))
        size = np.ones((len(tangent), 1))
        for _ in range(POWER_STEPS):
            back = self.solve(self.solve_across(left, tangent), transposed=True)[:, :-1]
            size = np.linalg.norm(back, axis=1, keepdims=True)
            left = back / size
        return np.asarray(1.0 / np.sqrt(size[:, 0]))
