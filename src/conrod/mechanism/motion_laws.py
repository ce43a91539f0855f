"""Motion laws of cams: how a follower goes from one height to another, and its derivatives to any order.

Each law is y(x), from y(0) = 0 to y(1) = 1 with slope 0 at both ends. A rise by h over a cam angle b lifts by
s = h y(theta / b), so that its k-th derivative by the cam angle is h / b^k times y's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from conrod.mechanism.cam import Array

DWELL, HARMONIC, CYCLOIDAL = "dwell", "simple-harmonic", "cycloidal"
# Coefficients of x^0, x^1, ...: the polynomials of least degree whose first two, or three, derivatives are 0 at the
# ends (Norton, Design of Machinery, chapter 8).
POLYNOMIALS = {
    "3-4-5": (0.0, 0.0, 0.0, 10.0, -15.0, 6.0),
    "4-5-6-7": (0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0),
}


def harmonic(x: Array, order: int) -> Array:
    """(1 - cos(pi x)) / 2: document 004, equations (3) to (5); the k-th derivative of it."""
    wave = -0.5 * math.pi**order * np.cos(math.pi * x + 0.5 * math.pi * order)
    return np.asarray(wave + 0.5 if order == 0 else wave)


def cycloidal(x: Array, order: int) -> Array:
    """x - sin(2 pi x) / (2 pi); the k-th derivative of it."""
    wave = -((2.0 * math.pi) ** (order - 1)) * np.sin(2.0 * math.pi * x + 0.5 * math.pi * order)
    return np.asarray(wave + (x if order == 0 else 1.0 if order == 1 else 0.0))


def polynomial(coefficients: tuple[float, ...], x: Array, order: int) -> Array:
    """A polynomial with y(1 - x) = 1 - y(x); the k-th derivative of it.

    The upper half comes from the lower one, where no digits are lost.
    """
    derived = np.polynomial.polynomial.polyder(coefficients, order)
    upper = x > 0.5
    lower = np.polynomial.polynomial.polyval(np.where(upper, 1.0 - x, x), derived)
    mirrored = 1.0 - lower if order == 0 else (-1.0) ** (order + 1) * lower
    return np.where(upper, mirrored, lower)


def _of(coefficients: tuple[float, ...]) -> Callable[[Array, int], Array]:
    return lambda x, order: polynomial(coefficients, x, order)


def dwell(x: Array, order: int) -> Array:
    """No motion."""
    return np.zeros(np.shape(x))


# Each gives the k-th derivative of y at x.
LAWS: dict[str, Callable[[Array, int], Array]] = {
    DWELL: dwell,
    HARMONIC: harmonic,
    CYCLOIDAL: cycloidal,
    **{name: _of(coefficients) for name, coefficients in POLYNOMIALS.items()},
}


@dataclass(frozen=True)
class Segment:
    """A part of the cam's turn in which one law holds."""

    law: str  # one of `LAWS`
    over: float  # [rad], cam angle
    lift: float  # [m], positive: away from the shaft

    def height(self, x: Array, order: int) -> Array:
        """Height above the segment's start and its derivatives by the cam angle, at a part x of the segment."""
        if self.law == DWELL:
            return np.zeros(np.shape(x))
        return self.lift / self.over**order * LAWS[self.law](x, order)
