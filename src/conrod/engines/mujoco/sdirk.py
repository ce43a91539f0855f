"""Linear motion with coefficients that change in time, by a method that no stiffness upsets."""

from __future__ import annotations

import math

import numpy as np

from conrod.motion import Array


def integrated(step: float, matrix: Array, pull: Array) -> Array:
    """x of x' = A x + b from x = 0, A (T, m, m) and b (T, m) given at instants a step apart.

    The singly diagonally implicit Runge-Kutta method of order 2 that is L-stable (Alexander, 1977), because a closure
    may be far stiffer than the samples are close.
    """
    g = 1.0 - math.sqrt(0.5)
    one = np.eye(matrix.shape[1])
    early, early_pull = matrix[:-1] + g * np.diff(matrix, axis=0), pull[:-1] + g * np.diff(pull, axis=0)
    late, late_pull = matrix[1:], pull[1:]
    solve_early, solve_late = (np.linalg.inv(one - g * step * a) for a in (early, late))
    # The stages as k = K x + c, and with them the whole step as x -> P x + p.
    k1, c1 = solve_early @ early, (solve_early @ early_pull[:, :, None])[:, :, 0]
    reached = one + (1.0 - g) * step * k1
    k2 = solve_late @ late @ reached
    drawn = late_pull + (1.0 - g) * step * (late @ c1[:, :, None])[:, :, 0]
    c2 = (solve_late @ drawn[:, :, None])[:, :, 0]
    advance, shift = one + step * ((1.0 - g) * k1 + g * k2), step * ((1.0 - g) * c1 + g * c2)
    states = np.zeros_like(pull)
    for i in range(len(advance)):
        states[i + 1] = advance[i] @ states[i] + shift[i]
    return states
