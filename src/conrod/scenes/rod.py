"""The one radical that every closed form here is made of: a rod (or an arm) of fixed length, seen along an axis."""

from __future__ import annotations

import numpy as np

from conrod.exact.motion import Array, Derivatives


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
    # In place, because this is most of what an exact motion costs.
    back = -w
    w1 = u * u1
    w1 /= back
    w2 = u1 * u1
    w2 += u * u2
    w2 += w1 * w1
    w2 /= back
    w3 = u1 * u2
    w3 += w1 * w2
    w3 *= 3.0
    w3 += u * u3
    w3 /= back
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
        if isinstance(total, float) and total == 0.0:
            total = values if weight == 1.0 else weight * values
        elif weight == -1.0:
            total = total - values
        elif not (isinstance(values, float) and values == 0.0):
            total = total + (values if weight == 1.0 else weight * values)
    return total
