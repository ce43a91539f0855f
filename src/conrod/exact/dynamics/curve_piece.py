"""One piece of the configuration curve as Chebyshev series in its exact arc length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from conrod.exact.arc_length_continuation import CurvePoint
from conrod.exact.configuration_curve import ConfigurationCurve, CurveFrame
from conrod.exact.motion import Array, hermite_interpolation

DEGREE = 24
NODES = -np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)  # Chebyshev-Lobatto, in [-1, 1]
# Values at the nodes to coefficients; a discrete cosine transform by its matrix, since it is small.
TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(NODES, DEGREE))
MIN_SINGULAR_VALUE_SHARE = (
    0.15  # of the largest singular value on a piece: nodes below it lose too many digits to a crossing of branches
)
MAX_NODES_LEFT_OUT = 3  # of one piece, near a crossing of branches
ORDERS_PER_NODE = 2  # orders of the series left out with each node, so that the other nodes determine it well
SMOOTH_POINTS, SMOOTH_SHARE = (
    5,
    0.35,
)  # places on a piece, and of their largest singular value the least, where no branch crosses
RESIDUAL_TOLERANCE = 1e-11  # of the joints' equations on the smooth continuation, without units
ROUNDING = 2e-16  # of the joints' equations, without units
TAIL_TOLERANCE = 1e-12  # of a converged series' last coefficients, over the curvature


@dataclass(frozen=True)
class CurvePiece:
    """A piece of the configuration curve: points, tangents and curvatures (DEGREE + 1, 3 n) at Chebyshev nodes."""

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


def fit_piece(curve: ConfigurationCurve, places: list[CurvePoint], start: float) -> CurvePiece | None:
    """Fit a piece through neighbouring points, from the first to the last; None if it cannot be fitted."""
    curve = curve.with_arcs(places[0].arcs)
    first, last = places[0], places[-1]
    chord = last.point - first.point
    span = float(np.linalg.norm(chord))
    direction = chord / span
    guess = _Guess(places, direction)
    smooth = len(places) >= SMOOTH_POINTS and min(p.singular_value for p in places) > SMOOTH_SHARE * max(
        p.singular_value for p in places
    )
    found = _points_along_chord(curve, guess, direction, 0.5 * span * (NODES + 1.0), smooth)
    if found is None:
        return None
    _, frame, good = found
    # Arc length over the distance along the chord, by integrating its exact derivative.
    rates = _fit_series(NODES[good], 1.0 / np.sum(frame.tangent * direction, axis=1))
    integral = np.asarray(chebyshev.chebint(rates, lbnd=-1.0) * 0.5 * span, dtype=float)
    length = float(chebyshev.chebval(1.0, integral))
    local = _invert_arc_length(integral, rates, span, 0.5 * length * (NODES + 1.0))
    found = _points_along_chord(curve, guess, direction, 0.5 * span * (local + 1.0), smooth)
    if found is None:
        return None
    points, frame, good = found
    noise = float(ROUNDING / frame.singular_value.min() ** 2)
    if good.all():
        return CurvePiece(start, start + length, first.arcs, points, frame.tangent, frame.curvature, noise=noise)
    some = (points, frame.tangent, frame.curvature)
    points, tangents, curvatures = (chebyshev.chebvander(NODES, DEGREE) @ _fit_series(NODES[good], f) for f in some)
    if float(np.abs(curve.residual_coefficient([points])).max()) > RESIDUAL_TOLERANCE:
        return None
    crossing, degree = (
        start + 0.5 * length * (1.0 + _crossing_place(good, frame.singular_value)),
        _degree_for(int(good.sum())),
    )
    return CurvePiece(start, start + length, first.arcs, points, tangents, curvatures, crossing, noise, degree)


def _points_along_chord(
    curve: ConfigurationCurve, guess: _Guess, direction: Array, distances: Array, smooth: bool
) -> tuple[Array, CurveFrame, NDArray[np.bool_]] | None:
    """Curve points in planes across a chord at given distances, their frame, and a mask of usable nodes."""
    good = np.full(len(distances), True) if smooth else _digits_kept(curve, guess, direction, distances)
    points = None if good is None else curve.correct_points(guess(distances[good]), direction)
    if good is None or points is None:
        return None
    with np.errstate(all="ignore"):
        frame = curve.frame(points, direction)
    return (points, frame, good) if np.isfinite(frame.curvature).all() else None


def _digits_kept(
    curve: ConfigurationCurve, guess: _Guess, direction: Array, distances: Array
) -> NDArray[np.bool_] | None:
    """Mask of nodes far enough from a crossing of branches; None if too many are too close, or one at an end.

    Next to a crossing the joints' equations hardly distinguish the branches: derivatives lose digits with powers of the
    distance. The smooth continuation of the nodes on both sides gives the curve there.
    """
    with np.errstate(all="ignore"):
        singular_value = curve.frame(guess(distances), direction).singular_value
    good = singular_value >= MIN_SINGULAR_VALUE_SHARE * np.nanmax(singular_value)
    inside = good[0] and good[-1] and np.count_nonzero(~good) <= MAX_NODES_LEFT_OUT
    return np.asarray(good) if inside else None


def _crossing_place(good: NDArray[np.bool_], singular_value: Array) -> float:
    """Place in [-1, 1] on a piece where branches cross: there the signed singular value passes through 0."""
    nodes, middle = NODES[good], float(NODES[~good].mean())
    signed = np.where(nodes < middle, -singular_value, singular_value)
    beside = np.searchsorted(nodes, middle) + np.arange(-2, 2)
    inside = beside[(beside >= 0) & (beside < len(nodes))]
    # Its inverse is interpolated, of which only the value at 0 is wanted.
    return float(np.polyfit(signed[inside], nodes[inside], len(inside) - 1)[-1])


def _degree_for(nodes: int) -> int:
    """Degree of the series that a number of usable nodes determines well."""
    return DEGREE - ORDERS_PER_NODE * (DEGREE + 1 - nodes)


def _fit_series(nodes: Array, values: Array) -> Array:
    """Chebyshev coefficients (DEGREE + 1, ...) of values at some nodes, the highest 0 if nodes are missing."""
    degree = _degree_for(len(nodes))
    low = np.linalg.lstsq(chebyshev.chebvander(nodes, degree), values, rcond=None)[0]
    return np.concatenate([low, np.zeros((DEGREE - degree, *values.shape[1:]))])


def _invert_arc_length(integral: Array, rates: Array, span: float, lengths: Array) -> Array:
    """Places in [-1, 1] on the chord at which given arc lengths are reached, by Newton iteration."""
    local = NODES.copy()
    for _ in range(8):
        local = local - (chebyshev.chebval(local, integral) - lengths) / (0.5 * span * chebyshev.chebval(local, rates))
    local[0], local[-1] = -1.0, 1.0
    return local


class _Guess:
    """Hermite interpolation of curve points by their distance along a chord."""

    def __init__(self, places: list[CurvePoint], direction: Array) -> None:
        self._points = np.concatenate([p.point for p in places])
        derivatives = np.concatenate([p.tangent for p in places])
        along = np.sum(derivatives * direction, axis=1)[:, None]
        self._derivatives = derivatives / along
        self._at = np.sum((self._points - self._points[:1]) * direction, axis=1)

    def __call__(self, distances: Array) -> Array:
        return hermite_interpolation(self._at, self._points, self._derivatives, distances)
