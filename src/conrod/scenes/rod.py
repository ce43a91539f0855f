"""The one radical that every closed form here is made of: a rod (or an arm) of fixed length, seen along an axis."""

from __future__ import annotations

import numpy as np

from conrod.motion import Array

Derivatives = tuple[Array, Array, Array, Array]


def projection(length: Array | float, across: Derivatives) -> Derivatives:
    """w = sqrt(length^2 - u^2) and its first three derivatives, from u = `across` and its own.

    From w^2 = l^2 - u^2, differentiated: w w' = -u u'; w'^2 + w w'' = -(u'^2 + u u'');
    3 w' w'' + w w''' = -(3 u' u'' + u u''').

    Args:
        length: l [m], with |u| < l.
        across: u, u', u'', u''' [m], the rod's extent across the axis.
    """
    u, u1, u2, u3 = across
    w = np.sqrt((length - u) * (length + u))
    w1 = -u * u1 / w
    w2 = -(u1 * u1 + u * u2 + w1 * w1) / w
    w3 = -(3.0 * (u1 * u2 + w1 * w2) + u * u3) / w
    return w, w1, w2, w3


def circular(radius: Array | float, sine: Array, cosine: Array) -> tuple[Derivatives, Derivatives]:
    """radius x cos t and radius x sin t with their first three derivatives by t."""
    x, y = radius * cosine, radius * sine
    return (x, -y, -x, y), (y, x, -y, -x)


def combine(*terms: tuple[float, Derivatives]) -> Derivatives:
    """Weighted sum of functions with their derivatives."""
    w, x, y, z = (sum(weight * values[k] for weight, values in terms) for k in range(4))
    return np.asarray(w), np.asarray(x), np.asarray(y), np.asarray(z)


def planar(x: Derivatives, y: Derivatives) -> Derivatives:
    """Coordinates x and y as (T, 2) arrays, derivative by derivative."""
    a, b, c, d = (np.column_stack([x[k], y[k]]) for k in range(4))
    return a, b, c, d
