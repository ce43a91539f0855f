"""Change points: crank angles where assembly branches meet, and the series of the motion that passes smoothly.

At a change point the equations are singular: the poses' derivatives are 0/0, where a dead centre makes them infinite.
The part of a Taylor coefficient in the Jacobian's null space, which the equations of its order leave open, follows from
the equations of the next order (the reduction of Lyapunov and Schmidt; Govaerts, Numerical Methods for Bifurcations of
Dynamical Equilibria, chapter 6). So the smooth motion has a Taylor series that does not suffer from rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.equations import Equations
from conrod.exact.motion import Array

SEARCH_ORDER, SERIES_ORDER = 8, 16  # of the series used to search ahead, and of the series at a change point
# The search series is trusted while its last term is smaller (lengths against the size); at a dead centre it grows.
MAX_LAST_TERM = 1e-3
SEARCH_PLACES, SEARCH_ROUNDS = 33, 3  # places per round at which the smallest singular value is evaluated
# A change point is fitted to `FIT_NODES` poses on either side, from `FIT_INNER` of the width to all of it.
FIT_INNER, FIT_NODES = 0.2, 6
FIT_WIDTH = 0.05  # [rad]: a narrower fit loses digits
ANGLE_CORRECTIONS = 3  # Newton steps for the angle, each of which squares the error
# Rounding at a change point: of the equations, and of the Jacobian's vanishing singular values.
RESIDUAL_ROUNDING, SINGULAR_ROUNDING = 1e-11, 1e-8
# Limits [rad] of the window in which the series is used, as far as it agrees with Newton iteration to the tolerances.
MAX_WINDOW, MIN_WINDOW = 0.08, 1e-3
POSE_TOLERANCE, DERIVATIVE_TOLERANCE = 1e-12, 1e-9


@dataclass(frozen=True)
class ChangePoint:
    """A change point and the Taylor series of the smooth motion near it."""

    angle: float  # crank angle [rad]
    coefficients: Array  # Taylor coefficients of the poses by the crank angle there, (K + 1, 3 n)
    window: float  # how near to it [rad] the series holds to rounding
    gained_freedoms: int = 0  # that the linkage gains there; 1 but where several loops have it at once

    def covers(self, angle: Array) -> NDArray[np.bool_]:
        """Mask (T,) of crank angles [rad] at which the series holds to rounding."""
        return np.abs(angle - self.angle) < self.window

    def series(self, angle: Array, order: int) -> list[Array]:
        """Taylor coefficients of the poses about angles (T,) [rad] up to an order; each (T, 3 n)."""
        distance = (angle - self.angle)[:, None]
        result = []
        for k in range(order + 1):
            total = np.zeros((len(angle), self.coefficients.shape[1]))
            for j in range(len(self.coefficients) - 1, k - 1, -1):
                total = total * distance + math.comb(j, k) * self.coefficients[j]
            result.append(total)
        return result


def find_change_point(
    equations: Equations, angle: float, poses: Array, distance: float
) -> tuple[ChangePoint, float, Array] | None:
    """Search for the first change point ahead of a pose; return it with the angle and the poses beyond, else None.

    The point beyond lies as far behind the change point as the given pose lies before it. None also where the motion
    cannot continue smoothly, and for mechanisms with cams, whose arcs have no series through a joint.

    Args:
        angle: crank angle [rad] of the pose.
        poses: exact poses there (1, 3 n).
        distance: angle to search through [rad], negative backwards.
    """
    if equations.mechanism.cam_contacts:
        return None
    ahead = np.concatenate(equations.series(poses, np.array([angle]), SEARCH_ORDER))
    if not np.isfinite(ahead).all():
        return None
    here = ChangePoint(angle, ahead, math.inf)
    away = _distance_to_singularity(equations, here, distance)
    try:
        # A first fit from nearby, then one from far enough for all digits.
        change = None if away is None else _fit_change_point(equations, here, here.angle + away, abs(away))
        if change is not None and away is not None and abs(away) < FIT_WIDTH:
            change = _fit_change_point(equations, change, change.angle, FIT_WIDTH) or change
        change = None if change is None else _verify_window(equations, change)
        if change is None:
            return None
        beyond = np.array([2.0 * change.angle - angle])
        guess = here.series(beyond, 0)[0]
        poses = change.series(beyond, 0)[0] if change.covers(beyond)[0] else equations.newton(guess, beyond)
        return change, float(beyond[0]), poses
    except (InvalidInput, np.linalg.LinAlgError):  # no poses on both sides, or no unique continuation
        return None


def _distance_to_singularity(equations: Equations, here: ChangePoint, distance: float) -> float | None:
    """Distance [rad] to the first singular Jacobian along the series from here; None if none is near."""
    # Denser near the start, which may lie next to the change point.
    distances = distance * np.linspace(0.0, 1.0, SEARCH_PLACES) ** 2
    values = _min_singular_values(equations, here, distances)
    for k in range(1, SEARCH_PLACES - 1):
        if values[k] > min(values[k - 1], values[k + 1]):
            continue
        found, least = _refine_minimum(equations, here, distances[k - 1], distances[k + 1])
        last_term = np.abs(here.coefficients[-1] / equations.scale).max() * abs(2.0 * found) ** SEARCH_ORDER
        if last_term > MAX_LAST_TERM:
            return None
        if least < MAX_LAST_TERM:
            return found
    return None


def _refine_minimum(equations: Equations, here: ChangePoint, low: float, high: float) -> tuple[float, float]:
    """Distance [rad] between two limits at which the smallest singular value is least, and that value."""
    found, least = low, math.inf
    for _ in range(SEARCH_ROUNDS):
        distances = np.linspace(low, high, SEARCH_PLACES)
        values = _min_singular_values(equations, here, distances)
        k = int(values.argmin())
        found, least = float(distances[k]), float(values[k])
        low, high = distances[max(k - 1, 0)], distances[min(k + 1, SEARCH_PLACES - 1)]
    return found, least


def _min_singular_values(equations: Equations, here: ChangePoint, distances: Array) -> Array:
    """Smallest singular values (T,) of the Jacobian at distances (T,) [rad] along a series."""
    poses = here.series(here.angle + distances, 0)[0]
    return np.asarray(np.linalg.svd(equations.scaled_jacobian(poses), compute_uv=False)[:, -1])


def _fit_change_point(equations: Equations, known: ChangePoint, middle: float, width: float) -> ChangePoint | None:
    """Locate the change point near an angle from poses on both its sides, and compute its series; None if it fails.

    Args:
        known: a series from which poses are guessed.
        middle: approximate crank angle [rad] of the change point.
        width: half the interval [rad] from which poses are taken.
    """
    rows = FIT_INNER + (1.0 - FIT_INNER) * 0.5 * (1.0 - np.cos(np.pi * (np.arange(FIT_NODES) + 0.5) / FIT_NODES))
    beside = np.concatenate([-rows[::-1], rows])
    guess = known.series(middle + width * beside, 0)[0]
    poses = equations.newton(guess, middle + width * beside)
    if equations.pose_distance(poses, guess).max() > MAX_LAST_TERM:
        return None
    fitted = np.polynomial.chebyshev.chebfit(beside, poses, len(beside) - 1)
    jacobians = _scaled_jacobians(equations, poses)
    at = 0.0
    for _ in range(ANGLE_CORRECTIONS):
        left, values, right = np.linalg.svd(_scaled_jacobians(equations, _chebyshev_value(fitted, at)[None])[0])
        nullity = int((values < MAX_LAST_TERM * width).sum())
        if not nullity:
            return None
        held = np.einsum("ik,tij,lj->tkl", left[:, -nullity:], jacobians, right[-nullity:])
        entries = np.polynomial.chebyshev.chebfit(beside, held.reshape(len(beside), -1), len(beside) - 1)
        value, derivative = (
            _chebyshev_value(entries, at),
            _chebyshev_value(np.polynomial.chebyshev.chebder(entries), at),
        )
        at -= float(value @ derivative / (derivative @ derivative))
        if abs(at) > FIT_INNER:
            return None
    rise = _chebyshev_value(np.polynomial.chebyshev.chebder(fitted), at) / width
    coefficients = _series_at(equations, middle + width * at, _chebyshev_value(fitted, at), rise)
    return None if coefficients is None else ChangePoint(middle + width * at, coefficients, MAX_WINDOW, nullity)


def _chebyshev_value(fitted: NDArray[np.floating[Any]], at: float) -> Array:
    """Value of a Chebyshev series at a place in [-1, 1]."""
    return np.asarray(np.polynomial.chebyshev.chebval(at, fitted))


def _scaled_jacobians(equations: Equations, poses: Array) -> Array:
    """Jacobians (T, 3 n, 3 n) without units: equations over their scale by poses over theirs."""
    return np.asarray(equations.jacobian(poses) * equations.scale / equations.rows[:, None])


def _series_at(equations: Equations, angle: float, poses: Array, derivative: Array) -> Array | None:
    """Taylor coefficients (K + 1, 3 n) at a change point, from its poses (3 n,) and their approximate derivative."""
    scale = equations.scale
    left, values, right = np.linalg.svd(_scaled_jacobians(equations, poses[None])[0])
    kept = values > SINGULAR_ROUNDING * values[0]
    if kept.all():
        return None
    free, open_rows = right[~kept] * scale, left[:, ~kept]
    inverse = (right[kept].T / values[kept]) @ left[:, kept].T * scale[:, None]

    def residual(coefficients: list[Array]) -> Array:
        rows = equations.residual([c[None] for c in coefficients], np.array([angle]))
        return np.asarray([float(np.ravel(row)[0]) for row in rows] / equations.rows)

    poses = poses - inverse @ residual([poses])
    if np.abs(residual([poses])).max() > RESIDUAL_ROUNDING * equations.size / equations.unit:
        return None
    zero = np.zeros_like(poses)
    known = -inverse @ residual([poses, zero])
    known = known + free.T @ np.linalg.lstsq(free.T / scale[:, None], (derivative - known) / scale, rcond=None)[0]
    # Derivative of the second-order equations by the part of dq/dtheta that the first-order equations leave open.
    answer = 0.5 * np.column_stack(
        [open_rows.T @ (residual([poses, known + f, zero]) - residual([poses, known - f, zero])) for f in free]
    )
    for _ in range(ANGLE_CORRECTIONS):
        known = known - free.T @ np.linalg.solve(answer, open_rows.T @ residual([poses, known, zero]))
    coefficients = [poses, known]
    while len(coefficients) <= SERIES_ORDER:
        following = -inverse @ residual([*coefficients, zero])
        missing = open_rows.T @ residual([*coefficients, following, zero])
        coefficients.append(following - free.T @ np.linalg.solve(answer, missing))
    return np.array(coefficients)


def _verify_window(equations: Equations, change: ChangePoint) -> ChangePoint | None:
    """Shrink the window until the series agrees with Newton iteration at both ends; None if it never does."""
    while change.window >= MIN_WINDOW:
        sides = change.angle + change.window * np.array([-1.0, 1.0])
        guess, derivative = change.series(sides, 1)
        try:
            poses = equations.newton(guess, sides)
        except InvalidInput:
            return None
        off = equations.pose_distance(poses, guess).max()
        if (
            off < POSE_TOLERANCE
            and equations.pose_distance(equations.pose_derivative(poses), derivative).max() < DERIVATIVE_TOLERANCE
        ):
            return change
        change = replace(change, window=0.5 * change.window)
    return None
