"""The curve of configurations that the joints alone, without a driver, leave to a mechanism of mobility one."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Self

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs
from threadpoolctl import ThreadpoolController

from conrod.exact.equations import Arcs, Equations
from conrod.exact.joint_equations import active_arcs, pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Mechanism

NEWTON_STEPS, NEWTON_DONE = 12, 1e-9  # after a step this small its square is left


_libraries = cache(ThreadpoolController)


@contextmanager
def one_thread() -> Iterator[None]:
    """Solve for points of curves in one thread while it is open.

    Threads cost more than they save on matrices this small: 46 s of CPU time in place of 3 s for a chain of 20
    four-bars. With one, last digits do not depend on the number of cores either.
    """
    with _libraries().limit(limits=1, user_api="blas"):
        yield


@dataclass(frozen=True)
class Frame:
    """Direction and curvature of the curve at points of it.

    Attributes:
        nearness: about the smallest singular value (T,) of the joints' Jacobian but for the tangent's: 0 where a
            freedom more is gained.
    """

    tangent: Array  # of unit length (T, 3 n)
    curvature: Array  # its derivative by the arc length (T, 3 n)
    nearness: Array


class JointCurve:
    """Points of the curve are poses with lengths in units of the mechanism's size, (T, 3 n), so that all are angles.

    Attributes:
        mechanism: of mobility one.
        scale: (3 n,) [m, m, 1], of the coordinates.
        unit: arc length that n bodies add together when each turns by one radian.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._equations = Equations(mechanism)
        size = _link_size(mechanism) or self._equations.size
        self.scale = np.tile([size, size, 1.0], len(mechanism.bodies))
        self.unit = math.sqrt(len(mechanism.bodies))
        self._lengths = self._equations.row_lengths(size)
        self._held: dict[str, int] = {}

    def on(self, arcs: dict[str, int]) -> Self:
        """The curve that it would be if the rollers stayed on given arcs of their cams, smooth beyond their joints."""
        held = copy.copy(self)
        held._held = dict(arcs)
        return held

    def arcs(self, point: Array) -> dict[str, int]:
        """The arcs of cams that their rollers are on, at one point (1, 3 n)."""
        contacts = self.mechanism.cam_contacts
        bodies = pose_jets(self.mechanism, [point * self.scale]) if contacts else {}
        return {joint.name: int(np.ravel(active_arcs(joint, bodies))[0]) for joint in contacts}

    def _arcs(self, samples: int) -> Arcs:
        return {name: np.full(samples, arc, dtype=np.intp) for name, arc in self._held.items()}

    def jacobian(self, points: Array) -> Array:
        """Derivative of the joints' equations by the coordinates (T, 3 n - 1, 3 n), without units."""
        full = self._equations.jacobian(points * self.scale, self._arcs(len(points)))[:, :-1, :]
        return np.asarray(full * self.scale / self._lengths[:, None])

    def coefficient(self, coefficients: list[Array]) -> Array:
        """Taylor coefficient (T, 3 n - 1) of the joints' equations along Taylor coefficients of points."""
        samples = len(coefficients[0])
        rows = self._equations.residual([c * self.scale for c in coefficients], np.zeros(samples), self._arcs(samples))
        return np.stack([np.broadcast_to(row, samples) for row in rows[:-1]], axis=1) / self._lengths

    def bordered(self, points: Array, row: Array) -> Array:
        """The Jacobian with one row below it; (T, 3 n, 3 n)."""
        below = np.broadcast_to(row, points.shape)[:, None, :]
        return np.concatenate([self.jacobian(points), below], axis=1)

    def corrected(self, guess: Array, row: Array, done: float = NEWTON_DONE) -> Array | None:
        """Points of the curve in planes through guesses (T, 3 n) at right angles to rows; None without convergence."""
        points, rows = guess.copy(), np.broadcast_to(row, guess.shape)
        for _ in range(NEWTON_STEPS):
            within = np.sum(rows * (points - guess), axis=1)[:, None]
            left = np.concatenate([self.coefficient([points]), within], axis=1)
            try:
                step = np.linalg.solve(self.bordered(points, rows), left[:, :, None])[:, :, 0]
            except np.linalg.LinAlgError:
                return None
            points = points - step
            if not np.isfinite(step).all():
                return None
            if np.abs(step).max() <= done:
                return np.asarray(points)
        return None

    def frame(self, points: Array, along: Array) -> Frame:
        """Tangents in the sense of given rows, which no tangent is at right angles to, and what goes with them."""
        # One factorisation gives all of them, at a small part of what a singular value decomposition costs.
        factors = Factors(self.bordered(points, along))
        last = np.zeros_like(points)
        last[:, -1] = 1.0
        normal = factors.solve(last)
        tangent = normal / np.linalg.norm(normal, axis=1)[:, None]
        bend = 2.0 * self.coefficient([points, tangent, np.zeros_like(points)])
        curvature = -factors.across(bend, tangent)
        return Frame(tangent, curvature, factors.nearness(tangent))

    def start(self) -> Array:
        """The exact point (1, 3 n) near the mechanism's start poses, the crank held."""
        equations = self._equations
        driven = np.zeros_like(self.scale)
        driven[3 * equations.crank + 2] = 1.0
        approximate = equations.approximate / self.scale
        found = self.corrected(approximate, driven)
        return equations.newton(equations.approximate, np.zeros(1)) / self.scale if found is None else found


def _link_size(mechanism: Mechanism) -> float:
    """Largest distance [m] of a body's joints, or of its centre of gravity, from its origin.

    Not the size of the whole: in a long chain the motion of one link would count for little.
    """
    far = [math.hypot(*body.centre_of_gravity) for body in mechanism.bodies]
    for joint in mechanism.joints:
        # A cam has its shaft at its origin.
        second = joint.roller_centre if isinstance(joint, CamContact) else joint.point_b
        ends = ((joint.a, getattr(joint, "point_a", (0.0, 0.0))), (joint.b, second))
        far += [math.hypot(*point) for name, point in ends if name != GROUND]
    return max(far)


def turned_alike(mechanism: Mechanism, difference: Array) -> Array:
    """A difference of points with whole turns of bodies taken out."""
    rest = difference.copy()
    rest[..., 2::3] = np.remainder(rest[..., 2::3] + math.pi, 2.0 * math.pi) - math.pi
    return np.asarray(rest)


POWER_STEPS = 4  # of the iteration for a smallest singular value, which is only compared


class Factors:
    """Factors of matrices (T, k, k), the last row of each at right angles to no tangent; nan of a singular one."""

    def __init__(self, matrices: Array) -> None:
        self._factors = [dgetrf(matrix) for matrix in matrices]

    def solve(self, right: Array, transposed: bool = False) -> Array:
        """Solutions (T, k) for right sides (T, k)."""
        found = np.full(right.shape, np.nan)
        for k, (lower_upper, pivots, singular) in enumerate(self._factors):
            if not singular:
                found[k], _ = dgetrs(lower_upper, pivots, right[k], trans=int(transposed))
        return found

    def across(self, right: Array, tangent: Array) -> Array:
        """Solutions (T, k) of all rows but the last, for right sides (T, k - 1), with no part along the tangent."""
        found = self.solve(np.column_stack([right, np.zeros(len(right))]))
        return np.asarray(found - np.sum(found * tangent, axis=1)[:, None] * tangent)

    def nearness(self, tangent: Array) -> Array:
        """About the smallest singular value (T,) of all rows but the last, by power iteration on their inverse.

        It is never below it, and near it where it is much smaller than the others.
        """
        guess = np.random.default_rng(0).standard_normal(tangent.shape[1] - 1)
        left = np.broadcast_to(guess / np.linalg.norm(guess), (len(tangent), len(guess)))
        size = np.ones((len(tangent), 1))
        for _ in range(POWER_STEPS):
            back = self.solve(self.across(left, tangent), transposed=True)[:, :-1]
            size = np.linalg.norm(back, axis=1, keepdims=True)
            left = back / size
        return np.asarray(1.0 / np.sqrt(size[:, 0]))
