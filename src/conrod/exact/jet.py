"""Truncated Taylor series of functions of one variable, for exact derivatives of joint equations.

A `Jet` holds the coefficients f^(k)/k!, k = 0..order, each an array of any one shape. Arithmetic on jets
is arithmetic on truncated series (Griewank and Walther, Evaluating Derivatives, 2nd ed., section 13.2), so an
expression written once gives its value and its derivatives, to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from conrod.exact.motion import Array

Scalar: TypeAlias = float | Array


class Jet:
    """A truncated Taylor series; combine with other jets of the same order, floats and arrays."""

    __slots__ = ("coefficients",)
    # numpy must leave `array * jet` to the jet, instead of building an array of objects.
    __array_ufunc__ = None

    def __init__(self, coefficients: Sequence[Scalar]) -> None:
        self.coefficients: tuple[Scalar, ...] = tuple(coefficients)

    def __add__(self, other: Jet | Scalar) -> Jet:
        if isinstance(other, Jet):
            return Jet([a + b for a, b in zip(self.coefficients, other.coefficients, strict=True)])
        return Jet((self.coefficients[0] + other, *self.coefficients[1:]))

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet([-a for a in self.coefficients])

    def __sub__(self, other: Jet | Scalar) -> Jet:
        if isinstance(other, Jet):
            return Jet([a - b for a, b in zip(self.coefficients, other.coefficients, strict=True)])
        return Jet((self.coefficients[0] - other, *self.coefficients[1:]))

    def __rsub__(self, other: Scalar) -> Jet:
        return (-self) + other

    def __mul__(self, other: Jet | Scalar) -> Jet:
        if not isinstance(other, Jet):
            return Jet([a * other for a in self.coefficients])
        a, b = self.coefficients, other.coefficients
        return Jet([_convolve(a, b, k, 0, k) for k in range(len(a))])

    __rmul__ = __mul__


def _convolve(a: Sequence[Scalar], b: Sequence[Scalar], k: int, first: int, last: int) -> Scalar:
    """Sum of a[j] b[k - j] over j = first..last; 0 if first > last."""
    if last < first:
        return 0.0
    total = a[first] * b[k - first]
    for j in range(first + 1, last + 1):
        total = total + a[j] * b[k - j]
    return total


def sine_cosine(angle: Jet) -> tuple[Jet, Jet]:
    """Sine and cosine of a jet in radians, by the recurrences k s_k = sum j a_j c_(k-j) and its twin."""
    a = angle.coefficients
    sine: list[Scalar] = [np.sin(a[0])]
    cosine: list[Scalar] = [np.cos(a[0])]
    scaled = [0.0, *(j * a[j] for j in range(1, len(a)))]
    for k in range(1, len(a)):
        sine.append(_convolve(scaled, cosine, k, 1, k) / k)
        cosine.append(-_convolve(scaled, sine, k, 1, k) / k)
    return Jet(sine), Jet(cosine)


def square_root(square: Jet) -> Jet:
    """Square root of a jet with a positive value, from (sqrt f)^2 = f term by term."""
    a = square.coefficients
    root: list[Scalar] = [np.sqrt(a[0])]
    for k in range(1, len(a)):
        root.append((a[k] - _convolve(root, root, k, 1, k - 1)) / (2.0 * root[0]))
    return Jet(root)


def reciprocal(jet: Jet) -> Jet:
    """1 / f of a jet whose value is not 0, from f (1 / f) = 1 term by term."""
    a = jet.coefficients
    inverse: list[Scalar] = [1.0 / a[0]]
    for k in range(1, len(a)):
        inverse.append(-_convolve(a, inverse, k, 1, k) / a[0])
    return Jet(inverse)


def direction(x: Jet, y: Jet) -> Jet:
    """Direction [rad] of a vector (x, y), within half a turn of +x, from (x^2 + y^2) f' = x y' - y x' term by term."""
    a, b = x.coefficients, y.coefficients
    square = (x * x + y * y).coefficients
    angle: list[Scalar] = [np.arctan2(b[0], a[0])]
    for k in range(1, len(a)):
        # k-th coefficients of both sides, each derivative's (j + 1) f_(j+1) at place j.
        turned: Scalar = 0.0
        for j in range(1, k + 1):
            turned = turned + j * (a[k - j] * b[j] - b[k - j] * a[j])
        known: Scalar = 0.0
        for j in range(1, k):
            known = known + j * angle[j] * square[k - j]
        angle.append((turned - known) / (k * square[0]))
    return Jet(angle)
