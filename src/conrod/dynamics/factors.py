"""Factors of the joints' Jacobian with a row below it, which is solved with several times."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

from conrod.motion import Array

POWER_STEPS = 4  # of the iteration for a smallest singular value, which is only compared


class Factors:
    """Of matrices (T, k, k), the last row of each at right angles to no tangent; of a singular one they tell nan."""

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
        return _at_right_angles(self.solve(np.column_stack([right, np.zeros(len(right))])), tangent)

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


def _at_right_angles(vectors: Array, tangent: Array) -> Array:
    return np.asarray(vectors - np.sum(vectors * tangent, axis=1)[:, None] * tangent)
