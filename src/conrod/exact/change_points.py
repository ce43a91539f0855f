"""Change points: crank angles where assemblies meet, and the one motion that goes on smoothly through them.

There the equations are singular and the poses' derivatives are 0/0, not infinite as at a dead centre. What the
equations of an order leave open of the poses' Taylor coefficient, its part in the Jacobian's null space, those of the
next order determine (the reduction of Lyapunov and Schmidt; Govaerts, Numerical Methods for Bifurcations of Dynamical
Equilibria, chapter 6): so the smooth motion has a Taylor series that rounding does not hurt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.equations import Equations
from conrod.exact.motion import Array

# Of the series that looks ahead, and of that at a change point.
AHEAD, ORDER = 8, 16
# A look ahead is trusted while its last term is this small (lengths against the size); a dead centre lets it grow.
TRUSTED = 1e-3
# The change point is narrowed down by looking at so many places, so often.
PLACES, LOOKS = 33, 3
# Poses beside a change point that determine it: between these parts of the way there, so many on either side.
NEAREST, BESIDE = 0.2, 6
WIDE = 0.05  # [rad]: what is nearer loses digits by its distance
SETTLED = 3  # corrections of its angle, each of which squares the error
# What rounding leaves at a change point: of the equations, and of the Jacobian's vanishing singular values.
CLOSED, VANISHED = 1e-11, 1e-8
# The series is used this near to the change point [rad], or nearer: as far as it gives the poses and slopes that
# Newton iteration does there.
WINDOW, LEAST_WINDOW = 0.08, 1e-3
SAME_POSE, SAME_SLOPE = 1e-12, 1e-9


@dataclass(frozen=True)
class ChangePoint:
    """A change point and the smooth motion near it."""

    angle: float  # crank angle [rad]
    coefficients: Array  # Taylor coefficients of the poses by the crank angle there, (K + 1, 3 n)
    window: float  # how near to it [rad] the series holds to rounding
    freedoms: int = 0  # that the linkage gains there; 1 but where several loops have it at once

    def near(self, angle: Array) -> NDArray[np.bool_]:
        """At which angles (T,) the series is to be used."""
        return np.abs(angle - self.angle) < self.window

    def series(self, angle: Array, order: int) -> list[Array]:
        """Taylor coefficients of the poses at angles (T,) up to an order; each (T, 3 n)."""
        way = (angle - self.angle)[:, None]
        result = []
        for k in range(order + 1):
            total = np.zeros((len(angle), self.coefficients.shape[1]))
            for j in range(len(self.coefficients) - 1, k - 1, -1):
                total = total * way + math.comb(j, k) * self.coefficients[j]
            result.append(total)
        return result


def crossing(equations: Equations, angle: float, poses: Array, way: float) -> tuple[ChangePoint, float, Array] | None:
    """The first change point on a way [rad] from poses (1, 3 n) at a crank angle; None if there is none.

    A place where the motion does not go on smoothly is none, nor is one of a mechanism with cams: their arcs have no
    series through a joint. With it the angle and the poses on its other side, as far from it.
    """
    if equations.mechanism.cam_contacts:
        return None
    ahead = np.concatenate(equations.series(poses, np.array([angle]), AHEAD))
    if not np.isfinite(ahead).all():
        return None
    here = ChangePoint(angle, ahead, math.inf)
    away = _vanishing(equations, here, way)
    try:
        # Seen from nearby first, then from far enough for all digits.
        change = None if away is None else _fitted(equations, here, here.angle + away, abs(away))
        if change is not None and away is not None and abs(away) < WIDE:
            change = _fitted(equations, change, change.angle, WIDE) or change
        change = None if change is None else _checked(equations, change)
        if change is None:
            return None
        beyond = np.array([2.0 * change.angle - angle])
        guess = here.series(beyond, 0)[0]
        poses = change.series(beyond, 0)[0] if change.near(beyond)[0] else equations.newton(guess, beyond)
        return change, float(beyond[0]), poses
    except (InvalidInput, np.linalg.LinAlgError):  # no poses beside it, or no one way to go on: it is none
        return None


def _vanishing(equations: Equations, here: ChangePoint, way: float) -> float | None:
    """Way [rad] to where the Jacobian becomes singular first, by the series ahead."""
    # Closer places where the way begins, which may be next to it.
    ways = way * np.linspace(0.0, 1.0, PLACES) ** 2
    values = _least_singular(equations, here, ways)
    for k in range(1, PLACES - 1):
        if values[k] > min(values[k - 1], values[k + 1]):
            continue
        found, least = _narrowed(equations, here, ways[k - 1], ways[k + 1])
        last_term = np.abs(here.coefficients[-1] / equations.scale).max() * abs(2.0 * found) ** AHEAD
        if last_term > TRUSTED:
            return None
        if least < TRUSTED:
            return found
    return None


def _narrowed(equations: Equations, here: ChangePoint, low: float, high: float) -> tuple[float, float]:
    """The way between two ways ahead at which the least singular value is least, and that value."""
    found, least = low, math.inf
    for _ in range(LOOKS):
        ways = np.linspace(low, high, PLACES)
        values = _least_singular(equations, here, ways)
        k = int(values.argmin())
        found, least = float(ways[k]), float(values[k])
        low, high = ways[max(k - 1, 0)], ways[min(k + 1, PLACES - 1)]
    return found, least


def _least_singular(equations: Equations, here: ChangePoint, ways: Array) -> Array:
    poses = here.series(here.angle + ways, 0)[0]
    return np.asarray(np.linalg.svd(equations.scaled_jacobian(poses), compute_uv=False)[:, -1])


def _fitted(equations: Equations, known: ChangePoint, middle: float, width: float) -> ChangePoint | None:
    """The change point near an angle, from exact poses within a width [rad] on both sides, near a series known."""
    rows = NEAREST + (1.0 - NEAREST) * 0.5 * (1.0 - np.cos(np.pi * (np.arange(BESIDE) + 0.5) / BESIDE))
    beside = np.concatenate([-rows[::-1], rows])
    guess = known.series(middle + width * beside, 0)[0]
    poses = equations.newton(guess, middle + width * beside)
    if equations.distance(poses, guess).max() > TRUSTED:
        return None
    fitted = chebyshev.chebfit(beside, poses, len(beside) - 1)
    jacobians = _jacobians(equations, poses)
    at = 0.0
    for _ in range(SETTLED):
        left, values, right = np.linalg.svd(_jacobians(equations, _value(fitted, at)[None])[0])
        nullity = int((values < TRUSTED * width).sum())
        if not nullity:
            return None
        held = np.einsum("ik,tij,lj->tkl", left[:, -nullity:], jacobians, right[-nullity:])
        entries = chebyshev.chebfit(beside, held.reshape(len(beside), -1), len(beside) - 1)
        value, slope = _value(entries, at), _value(chebyshev.chebder(entries), at)
        at -= float(value @ slope / (slope @ slope))
        if abs(at) > NEAREST:
            return None
    rise = _value(chebyshev.chebder(fitted), at) / width
    coefficients = _series(equations, middle + width * at, _value(fitted, at), rise)
    return None if coefficients is None else ChangePoint(middle + width * at, coefficients, WINDOW, nullity)


def _value(fitted: NDArray[np.floating[Any]], at: float) -> Array:
    return np.asarray(chebyshev.chebval(at, fitted))


def _jacobians(equations: Equations, poses: Array) -> Array:
    """Jacobians (T, 3 n, 3 n) of the equations over theirs by the poses over their scale."""
    return np.asarray(equations.jacobian(poses) * equations.scale / equations.rows[:, None])


def _series(equations: Equations, angle: float, poses: Array, slope: Array) -> Array | None:
    """Taylor coefficients (K + 1, 3 n) at a change point, from its poses (3 n,) and about their slope (3 n,)."""
    scale = equations.scale
    left, values, right = np.linalg.svd(_jacobians(equations, poses[None])[0])
    kept = values > VANISHED * values[0]
    if kept.all():
        return None
    free, open_rows = right[~kept] * scale, left[:, ~kept]
    inverse = (right[kept].T / values[kept]) @ left[:, kept].T * scale[:, None]

    def residual(coefficients: list[Array]) -> Array:
        rows = equations.residual([c[None] for c in coefficients], np.array([angle]))
        return np.asarray([float(np.ravel(row)[0]) for row in rows] / equations.rows)

    poses = poses - inverse @ residual([poses])
    if np.abs(residual([poses])).max() > CLOSED * equations.size / equations.unit:
        return None
    zero = np.zeros_like(poses)
    known = -inverse @ residual([poses, zero])
    known = known + free.T @ np.linalg.lstsq(free.T / scale[:, None], (slope - known) / scale, rcond=None)[0]
    # How the second-order equations answer to the part of the slope that the first-order ones leave open.
    answer = 0.5 * np.column_stack(
        [open_rows.T @ (residual([poses, known + f, zero]) - residual([poses, known - f, zero])) for f in free]
    )
    for _ in range(SETTLED):
        known = known - free.T @ np.linalg.solve(answer, open_rows.T @ residual([poses, known, zero]))
    coefficients = [poses, known]
    while len(coefficients) <= ORDER:
        following = -inverse @ residual([*coefficients, zero])
        missing = open_rows.T @ residual([*coefficients, following, zero])
        coefficients.append(following - free.T @ np.linalg.solve(answer, missing))
    return np.array(coefficients)


def _checked(equations: Equations, change: ChangePoint) -> ChangePoint | None:
    """The change point, with the window in which its series meets the poses and the slopes on both sides."""
    while change.window >= LEAST_WINDOW:
        sides = change.angle + change.window * np.array([-1.0, 1.0])
        guess, slope = change.series(sides, 1)
        try:
            poses = equations.newton(guess, sides)
        except InvalidInput:
            return None
        off = equations.distance(poses, guess).max()
        if off < SAME_POSE and equations.distance(equations.slope(poses), slope).max() < SAME_SLOPE:
            return change
        change = replace(change, window=0.5 * change.window)
    return None
