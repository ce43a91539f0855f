"""The curve of configurations as Chebyshev series in its exact arc length, piece by piece."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from conrod.exact.curve_walk import CurvePoint
from conrod.exact.joint_curve import Frame, JointCurve
from conrod.exact.motion import Array, hermite

DEGREE = 24
NODES = -np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)  # Chebyshev-Lobatto, in [-1, 1]
# Values at the nodes to coefficients; a discrete cosine transform by its matrix, since it is small.
TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(NODES, DEGREE))
KEPT = 0.15  # of the largest nearness on a piece: nodes below it lose too many digits to a crossing of branches
MOST_LOST = 3  # nodes of a piece
LOST_ORDERS = 2  # of its series for each of them, so that what is left determines it well
ENOUGH, AWAY = 5, 0.35  # places on a piece, and of their largest nearness the least, where no branch crosses
FITS = 1e-11  # what the smooth continuation may leave of the joints' equations, without units
ROUNDING = 2e-16  # in the joints' equations
TAIL = 1e-12  # of the last coefficients, against the curvature that they give: the series has converged


@dataclass(frozen=True)
class Samples:
    """Exact points of a piece at its nodes, with tangents and curvatures; each (DEGREE + 1, 3 n)."""

    start: float
    stop: float
    arcs: dict[str, int]  # of cams, that their rollers are on
    points: Array
    tangents: Array
    curvatures: Array
    crossing: float | None = None  # arc length where branches cross on the piece, if they do
    noise: float = 0.0  # what rounding leaves of the curvatures where branches come close to each other
    degree: int = DEGREE  # of the series that was fitted where nodes near a crossing were left out

    def series(self, values: Array) -> Array:
        """Chebyshev coefficients over the piece of values (DEGREE + 1, ...) at its nodes."""
        return np.asarray(np.tensordot(TO_COEFFICIENTS, values, axes=1))


def sampled(curve: JointCurve, places: list[CurvePoint], start: float) -> Samples | None:
    """A piece through neighbouring places, from the first to the last; None where these are too few, or too many."""
    curve = curve.on(places[0].arcs)
    first, last = places[0], places[-1]
    chord = last.point - first.point
    span = float(np.linalg.norm(chord))
    direction = chord / span
    guess = _Guess(places, direction)
    smooth = len(places) >= ENOUGH and min(p.nearness for p in places) > AWAY * max(p.nearness for p in places)
    found = _followed(curve, guess, direction, 0.5 * span * (NODES + 1.0), smooth)
    if found is None:
        return None
    _, frame, good = found
    # Arc length over the distance along the chord, by integrating its exact derivative.
    rates = _fitted(NODES[good], 1.0 / np.sum(frame.tangent * direction, axis=1))
    integral = np.asarray(chebyshev.chebint(rates, lbnd=-1.0) * 0.5 * span, dtype=float)
    length = float(chebyshev.chebval(1.0, integral))
    local = _inverted(integral, rates, span, 0.5 * length * (NODES + 1.0))
    found = _followed(curve, guess, direction, 0.5 * span * (local + 1.0), smooth)
    if found is None:
        return None
    points, frame, good = found
    noise = float(ROUNDING / frame.nearness.min() ** 2)
    if good.all():
        return Samples(start, start + length, first.arcs, points, frame.tangent, frame.curvature, noise=noise)
    some = (points, frame.tangent, frame.curvature)
    points, tangents, curvatures = (chebyshev.chebvander(NODES, DEGREE) @ _fitted(NODES[good], f) for f in some)
    if float(np.abs(curve.coefficient([points])).max()) > FITS:
        return None
    crossing, degree = start + 0.5 * length * (1.0 + _crossing(good, frame.nearness)), _degree(int(good.sum()))
    return Samples(start, start + length, first.arcs, points, tangents, curvatures, crossing, noise, degree)


def _followed(
    curve: JointCurve, guess: _Guess, direction: Array, distances: Array, smooth: bool
) -> tuple[Array, Frame, NDArray[np.bool_]] | None:
    """Points in planes at distances along a chord, where these exist, and which do; None if too few are."""
    good = np.full(len(distances), True) if smooth else _digits_kept(curve, guess, direction, distances)
    points = None if good is None else curve.corrected(guess(distances[good]), direction)
    if good is None or points is None:
        return None
    with np.errstate(all="ignore"):
        frame = curve.frame(points, direction)
    return (points, frame, good) if np.isfinite(frame.curvature).all() else None


def _digits_kept(curve: JointCurve, guess: _Guess, direction: Array, distances: Array) -> NDArray[np.bool_] | None:
    """Mask of nodes far enough from a crossing of branches; None if too many are not, or one at an end.

    Next to a crossing the joints' equations hardly distinguish the branches: derivatives lose digits with powers of the
    distance. What lies there follows from the smooth continuation of what lies before and behind.
    """
    with np.errstate(all="ignore"):
        nearness = curve.frame(guess(distances), direction).nearness
    good = nearness >= KEPT * np.nanmax(nearness)
    inside = good[0] and good[-1] and np.count_nonzero(~good) <= MOST_LOST
    return np.asarray(good) if inside else None


def _crossing(good: NDArray[np.bool_], nearness: Array) -> float:
    """Place on a piece, from -1 to 1, where branches cross: nearness, with the sign of the side, goes through 0."""
    nodes, middle = NODES[good], float(NODES[~good].mean())
    signed = np.where(nodes < middle, -nearness, nearness)
    beside = np.searchsorted(nodes, middle) + np.arange(-2, 2)
    inside = beside[(beside >= 0) & (beside < len(nodes))]
    # Its inverse is interpolated, of which only the value at 0 is wanted.
    return float(np.polyfit(signed[inside], nodes[inside], len(inside) - 1)[-1])


def _degree(nodes: int) -> int:
    return DEGREE - LOST_ORDERS * (DEGREE + 1 - nodes)


def _fitted(nodes: Array, values: Array) -> Array:
    """Chebyshev coefficients (DEGREE + 1, ...) of values at some nodes; without the highest orders if not at all."""
    degree = _degree(len(nodes))
    low = np.linalg.lstsq(chebyshev.chebvander(nodes, degree), values, rcond=None)[0]
    return np.concatenate([low, np.zeros((DEGREE - degree, *values.shape[1:]))])


def _inverted(integral: Array, rates: Array, span: float, lengths: Array) -> Array:
    """Places on the chord, from -1 to 1, at which arc lengths are reached."""
    local = NODES.copy()
    for _ in range(8):
        local = local - (chebyshev.chebval(local, integral) - lengths) / (0.5 * span * chebyshev.chebval(local, rates))
    local[0], local[-1] = -1.0, 1.0
    return local


class _Guess:
    """Points between places by Hermite interpolation, by their distance along a chord."""

    def __init__(self, places: list[CurvePoint], direction: Array) -> None:
        self._points = np.concatenate([p.point for p in places])
        slopes = np.concatenate([p.tangent for p in places])
        along = np.sum(slopes * direction, axis=1)[:, None]
        self._slopes = slopes / along
        self._at = np.sum((self._points - self._points[:1]) * direction, axis=1)

    def __call__(self, distances: Array) -> Array:
        return hermite(self._at, self._points, self._slopes, distances)
