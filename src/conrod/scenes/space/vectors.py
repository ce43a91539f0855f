"""Vectors in space that move: a jet of shape (T, 3) is a vector, one of shape (T, 1) a number.

So the formulas of a spatial machine are written once, and their derivatives to any order follow by `Jet`'s arithmetic.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from conrod.exact.jet import Jet, sine_cosine
from conrod.exact.motion import Array

Vector: TypeAlias = Jet | Array  # moving (T, 3), or fixed (3,)

DEGREE = math.pi / 180.0
X, Y, Z = np.eye(3)


def unit(vector: Array) -> Array:
    """Direction of a fixed vector."""
    return np.asarray(vector / np.linalg.norm(vector))


def rotated(vector: Array, axis: Array, angle: float) -> Array:
    """A fixed vector turned about a unit axis by a fixed angle [rad]."""
    return np.asarray(turned(vector, axis, Jet([np.full(1, angle)])).coefficients[0])


def turned(vector: Vector, axis: Array, angle: Jet) -> Jet:
    """A vector turned about a fixed unit axis by a moving angle [rad] (Rodrigues' formula)."""
    sine, cosine = sine_cosine(angle)
    moving = 0.0 * angle + vector
    along = dot(moving, axis) * axis
    return cosine * (moving - along) - sine * cross(moving, axis) + along


def dot(a: Jet, b: Vector) -> Jet:
    """Inner product (T, 1)."""
    return Jet([np.sum(c, axis=-1, keepdims=True) for c in (a * b).coefficients])


def cross(a: Jet, b: Vector) -> Jet:
    """Vector product a x b."""
    return _rolled(a, 1) * _shifted(b, 2) - _rolled(a, 2) * _shifted(b, 1)


def _rolled(vector: Jet, places: int) -> Jet:
    return Jet([np.roll(c, -places, axis=-1) for c in vector.coefficients])


def _shifted(vector: Vector, places: int) -> Vector:
    return _rolled(vector, places) if isinstance(vector, Jet) else np.roll(vector, -places)
