"""Constraint violations of a machine's closures at given poses, as Taylor series, and their Jacobian."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from conrod.exact.motion import Array
from conrod.exact.space import SpatialClosure, SpatialPoint, SpatialTree
from conrod.exact.space.forward_kinematics import Poses, Series, add_series, multiply_series, scale_series


def residuals(found: Poses, order: int) -> Array:
    """Taylor coefficients of all closures' constraint violations (order + 1, rows, T) [m].

    Angles are weighed by the machine's extent. A weld's angles are the antisymmetric part of the remaining rotation.
    """
    tree = found.tree
    every = [series for closure in tree.closures for series in _closure_residual(found, closure, order)]
    samples = max((one.shape[-1] for series in every for one in series), default=1)
    made = np.zeros((order + 1, sum(c.rows for c in tree.closures), samples))
    row = 0
    for series in every:
        height = 1 if series[0].ndim == 1 else len(series[0])
        for k, one in enumerate(series[: order + 1]):
            made[k, row : row + height] = one
        row += height
    return made


def _closure_residual(found: Poses, closure: SpatialClosure, order: int) -> list[Series]:
    """Violations of one closure as series of vectors (3, T) or numbers (T,)."""
    if not closure.points:
        return [_coupling_residual(found, closure, order)]
    first, second = (found.point(point) for point in closure.points)
    made = [add_series(first, [-one for one in second])]
    if closure.turn is not None:
        made.append(
            [found.tree.extent * antisymmetric(one) for one in _remaining_rotation(found, closure, closure.turn, order)]
        )
    return made


def _remaining_rotation(found: Poses, closure: SpatialClosure, turn: Array, order: int) -> Series:
    """Rotation from the second frame to the place that the first gives it; the unit matrix if closed."""
    one, two = (found.turns[point.body] for point in closure.points)
    placed = [np.einsum("ijt,jk->ikt", part, turn) for part in one]
    return multiply_series([np.swapaxes(part, 0, 1) for part in two], placed, order)


def antisymmetric(matrix: Array) -> Array:
    """Vector (3, T) w of the antisymmetric part of a matrix, with [w]x = (R - R^T) / 2."""
    return 0.5 * np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]])


def _coordinate_sum(found: Poses, factors: dict[int, float], reference: float) -> Series:
    """Weighted sum of joint coordinates less a reference, as a series."""
    return add_series([np.array([-reference])], *([f * one for one in found.scalars[j]] for j, f in factors.items()))


def _coupling_residual(found: Poses, closure: SpatialClosure, order: int) -> Series:
    """Residual y - (c_0 + c_1 x + c_2 x^2 + ..) of a coupling, a series up to an order in time.

    x and y are the weighted sums of its independent and dependent joint coordinates. The polynomial is evaluated by
    Horner's rule, and all is multiplied by `coupling_length`.
    """
    length = coupling_length(found.tree, closure)
    dependent = _coordinate_sum(found, closure.sums[0], closure.references[0])
    value: Series = [np.array([closure.polynomial[-1]])]
    if closure.sums[1]:
        independent = _coordinate_sum(found, closure.sums[1], closure.references[1])
        for factor in closure.polynomial[-2::-1]:
            value = add_series(scale_series(value, independent, order), [np.array([factor])])
    else:
        value = [np.array([closure.polynomial[0]])]
    return [length * one for one in add_series(dependent, [-one for one in value])]


def coupling_length(tree: SpatialTree, closure: SpatialClosure) -> float:
    """Factor on a coupling's residual: the extent [m] if it couples angles, otherwise 1; 1 for connects and welds."""
    joints = {joint.rate: joint for joint in tree.joints}
    return 1.0 if closure.points or any(joints[rate].unit == "m" for rate in closure.sums[0]) else tree.extent


def jacobian(found: Poses, samples: int) -> Array:
    """Jacobian (T, rows, nv) of the residuals by the joint rates; rows of a weld hold where it is closed."""
    tree = found.tree
    made = np.zeros((sum(c.rows for c in tree.closures), tree.freedom, samples))
    for closure in tree.closures:
        block = made[tree.rows[closure.name]]
        if not closure.points:
            _add_coupling_rows(found, closure, block)
            continue
        for point, sign in zip(closure.points, (1.0, -1.0), strict=True):
            linear, angular = point_jacobian(found, point)
            for rates, along in linear:
                block[:3, rates] += sign * along
            if closure.turn is not None:
                back = found.turns[closure.points[1].body][0]
                for rates, about in angular:
                    block[3:, rates] += sign * tree.extent * np.einsum("jit,jnt->int", back, about)
    return np.moveaxis(made, 2, 0)


def _add_coupling_rows(found: Poses, closure: SpatialClosure, block: Array) -> None:
    """Add the derivatives of a coupling by its joints' rates to its rows of the Jacobian."""
    length = coupling_length(found.tree, closure)
    for rate, factor in closure.sums[0].items():
        block[0, rate] += length * factor
    if closure.sums[1]:
        independent = _coordinate_sum(found, closure.sums[1], closure.references[1])[0]
        slope = np.polynomial.Polynomial(closure.polynomial).deriv()(independent)
        for rate, factor in closure.sums[1].items():
            block[0, rate] -= length * slope * factor


Blocks: TypeAlias = list[tuple[slice, Array]]  # of a Jacobian: places among the rates, and columns (3, n, T)


def point_jacobian(found: Poses, point: SpatialPoint) -> tuple[Blocks, Blocks]:
    """Derivatives of a point's position and its body's rotation by the rates of the joints above it."""
    place, linear, angular = found.point(point)[0], list[tuple[slice, Array]](), list[tuple[slice, Array]]()
    for joint in found.tree.joints_above[point.body]:
        axes = found.axes(joint)
        if joint.kind == "slide":
            linear.append((joint.rates, axes))
            continue
        turning = joint.rates
        if joint.kind == "free":
            linear.append((slice(joint.rate, joint.rate + 3), np.eye(3)[:, :, None]))
            turning = slice(joint.rate + 3, joint.rate + 6)
        arm = place - found.anchors[joint.rate]
        linear.append((turning, _cross(axes, arm[:, None])))
        angular.append((turning, axes))
    return linear, angular


def _cross(a: Array, b: Array) -> Array:
    """Cross product of vectors (3, ...)."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
