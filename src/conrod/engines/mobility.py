"""Rank of a Jacobian whose rows and columns may be in different units."""

from __future__ import annotations

import numpy as np

from conrod.exact.motion import Array

# Singular values below this share of the largest are zero: what is left of rounding is 1e-15 of it, a linkage a
# thousandth of a degree from a singular pose has 1e-5.
RANK_TOLERANCE = 1e-9


def jacobian_rank(jacobian: Array) -> int:
    """Rank of a Jacobian (rows, coordinates) whose rows and columns may be in different units."""
    if not jacobian.size:
        return 0
    singular = np.linalg.svd(_scaled(jacobian), compute_uv=False)
    return int(np.sum(singular > RANK_TOLERANCE * singular[0])) if singular[0] > 0.0 else 0


def _scaled(jacobian: Array) -> Array:
    # A column in metres beside one in radians must not decide what is small.
    scale = np.linalg.norm(jacobian, axis=0)
    return np.asarray(jacobian / np.where(scale > 0.0, scale, 1.0))


def independent_rows(jacobian: Array) -> list[bool]:
    """Of each row, whether it says something that no row before it says."""
    found, before = [], 0
    for i in range(len(jacobian)):
        rank = jacobian_rank(jacobian[: i + 1])
        found.append(rank > before)
        before = max(rank, before)
    return found
