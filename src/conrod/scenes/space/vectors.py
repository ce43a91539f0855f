"""Vectors in space that move: a jet of shape (T, 3) is a vector, one of shape (T, 1) a number.

So the formulas of a spatial machine are written once, and their derivatives to any order follow by `Jet`'s arithmetic.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from conrod.exact.jet import Jet, direction, reciprocal, sine_cosine, square_root
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


def length(vector: Jet) -> Jet:
    """Length (T, 1) of a vector that never vanishes."""
    return square_root(dot(vector, vector))


def hinge_angle(axis: Vector, before: Vector, after: Jet) -> Jet:
    """Angle [rad] about a unit axis from one vector to another, as seen along the axis."""
    across = cross(after, axis)
    return direction(-dot(cross(across, axis), before), dot(across, before))


def rod_angles(rod: Jet, axis: Array, zero: Array) -> tuple[Jet, Jet]:
    """Both angles [rad] of a universal joint that carries a rod.

    Args:
        axis: first hinge's unit axis, which keeps its direction; the second hinge is across it and the rod.
        zero: direction, across the axis, from which the first angle counts; the second counts from the plane across.
    """
    return hinge_angle(axis, zero, rod), direction(length(cross(rod, axis)), -dot(rod, axis))


def harmonic_root(a: Jet, b: Jet, c: Jet, branch: float) -> tuple[Jet, Jet]:
    """Cosine and sine of the angle with a cos + b sin = c; the branch, +1 or -1, is the side of (a, b) that it is on.

    The output angle of a four-bar obeys such an equation (McCarthy and Soh, Geometric Design of Linkages).
    """
    square = a * a + b * b
    root = branch * square_root(square - c * c)
    inverse = reciprocal(square)
    return (a * c - b * root) * inverse, (b * c + a * root) * inverse
