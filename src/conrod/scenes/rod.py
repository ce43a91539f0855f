"""The one radical that every closed form here is made of: a rod (or an arm) of fixed length, seen along an axis."""

from __future__ import annotations

import numpy as np

from conrod.motion import Array, Derivatives


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
    back_x, back_y = -x, -y
    return (x, back_y, back_x, y), (y, x, back_y, back_x)


def constant(value: float) -> Derivatives:
    """A number with its derivatives, which are none."""
    return value, 0.0, 0.0, 0.0


def combine(*terms: tuple[float, Derivatives]) -> Derivatives:
    """Weighted sum of functions with their derivatives."""
    w, x, y, z = (_weighted_sum([(weight, values[k]) for weight, values in terms]) for k in range(4))
    return w, x, y, z


def _weighted_sum(terms: list[tuple[float, Array | float]]) -> Array | float:
    """The sum, in as few passes over the samples as it takes."""
    total: Array | float = 0.0
    for weight, values in terms:
        if isinstance(values, float) and values == 0.0:
            continue
        if weight == -1.0 and not isinstance(total, float):
            total = total - values
            continue
        term = values if weight == 1.0 else weight * values
        total = term if isinstance(total, float) and total == 0.0 else total + term
    return total
