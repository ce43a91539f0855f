"""The curve of configurations as Chebyshev series in its exact arc length, piece by piece."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from conrod.dynamics.constraint import JointCurve
from conrod.dynamics.path import CROSSING, Place
from conrod.motion import Array

DEGREE = 24
NODES = -np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)  # Chebyshev-Lobatto, in [-1, 1]
# Values at the nodes to coefficients; a discrete cosine transform by its matrix, since it is small.
TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(NODES, DEGREE))
TAIL = 1e-12  # of the last coefficients, against the curvature that they tell: the series has converged


@dataclass(frozen=True)
class Samples:
    """Exact points of a piece at its nodes, with tangents and curvatures; each (DEGREE + 1, 3 n)."""

    start: float
    stop: float
    points: Array
    tangents: Array
    curvatures: Array

    def series(self, values: Array) -> Array:
        """Chebyshev coefficients over the piece of values (DEGREE + 1, ...) at its nodes."""
        return np.asarray(np.tensordot(TO_COEFFICIENTS, values, axes=1))


def sampled(curve: JointCurve, places: list[Place], start: float) -> Samples | None:
    """A piece through neighbouring places, from the first to the last; None where a node lies at a crossing."""
    first, last = places[0], places[-1]
    chord = last.point - first.point
    span = float(np.linalg.norm(chord))
    direction = chord / span
    guess = _Guess(places, direction)
    points, rates = _on_planes(curve, guess, direction, 0.5 * span * (NODES + 1.0))
    if rates is None:
        return None
    # Arc length over the distance along the chord, by integrating its exact derivative; then inverted at nodes in arc length.
    integral = chebyshev.chebint(TO_COEFFICIENTS @ rates, lbnd=-1.0) * 0.5 * span
    length = float(chebyshev.chebval(1.0, integral))
    wanted, local = 0.5 * length * (NODES + 1.0), NODES.copy()
    for _ in range(8):
        value = chebyshev.chebval(local, integral) - wanted
        local = local - value / (0.5 * span * chebyshev.chebval(local, TO_COEFFICIENTS @ rates))
    local[0], local[-1] = -1.0, 1.0
    points, again = _on_planes(curve, guess, direction, 0.5 * span * (local + 1.0))
    if again is None:
        return None
    tangents = curve.tangent(points, direction)
    if curve.nearness(points, tangents).min() < CROSSING:
        return None
    return Samples(start, start + length, points, tangents, curve.curvature(points, tangents))


def _on_planes(curve: JointCurve, guess: _Guess, direction: Array, distances: Array) -> tuple[Array, Array | None]:
    """Points at distances along the chord, and the arc length's derivative by it."""
    points = curve.corrected(guess(distances), direction)
    if points is None:
        return guess(distances), None
    with np.errstate(all="ignore"):
        rates = 1.0 / np.sum(curve.tangent(points, direction) * direction, axis=1)
    return points, rates if np.isfinite(rates).all() else None


class _Guess:
    """Points between places by Hermite interpolation, told by their distance along a chord."""

    def __init__(self, places: list[Place], direction: Array) -> None:
        self._points = np.concatenate([p.point for p in places])
        slopes = np.concatenate([p.tangent for p in places])
        along = np.sum(slopes * direction, axis=1)[:, None]
        self._slopes = slopes / along
        self._at = np.sum((self._points - self._points[:1]) * direction, axis=1)

    def __call__(self, distances: Array) -> Array:
        left = np.clip(np.searchsorted(self._at, distances, side="right") - 1, 0, len(self._at) - 2)
        width = (self._at[left + 1] - self._at[left])[:, None]
        t = (distances - self._at[left])[:, None] / width
        start, stop = self._points[left], self._points[left + 1]
        rise = stop - start
        a, b = width * self._slopes[left] - rise, rise - width * self._slopes[left + 1]
        return np.asarray(start + t * rise + t * (1.0 - t) * ((1.0 - t) * a + t * b))
