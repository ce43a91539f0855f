"""Coordinates that loads act along, as jets, with their gradients, and the loads' generalised forces."""

from __future__ import annotations

import math
from typing import assert_never

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.jet import Jet, square_root
from conrod.exact.joint_equations import PoseJet, pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import Coordinate, Displacement, Distance, Turn
from conrod.mechanism.mechanism import GROUND, Mechanism


def coordinate_jet(coordinate: Coordinate, poses: dict[str, PoseJet]) -> Jet:
    """The coordinate of a load along a motion: a distance, a relative rotation or a displacement."""
    match coordinate:
        case Distance():
            (ax, ay), (bx, by) = (
                poses[coordinate.a].point(coordinate.point_a),
                poses[coordinate.b].point(coordinate.point_b),
            )
            dx, dy = bx - ax, by - ay
            return square_root(dx * dx + dy * dy)
        case Turn():
            return poses[coordinate.b].phi - poses[coordinate.a].phi
        case Displacement():
            x, y = poses[coordinate.body].point(coordinate.point)
            return x * math.cos(coordinate.direction) + y * math.sin(coordinate.direction)
        case _:
            assert_never(coordinate)


def coordinate_gradient(coordinate: Coordinate, mechanism: Mechanism, poses: dict[str, PoseJet], samples: int) -> Array:
    """Derivative (T, 3 n) of a load's coordinate by the stacked poses."""
    result = np.zeros((samples, 3 * len(mechanism.bodies)))
    match coordinate:
        case Distance():
            (ax, ay), (bx, by) = (
                _point_place(poses, coordinate.a, coordinate.point_a),
                _point_place(poses, coordinate.b, coordinate.point_b),
            )
            dx, dy = bx - ax, by - ay
            length = np.hypot(dx, dy)
            _add_gradient(result, mechanism, poses, coordinate.b, (bx, by), (dx / length, dy / length))
            _add_gradient(result, mechanism, poses, coordinate.a, (ax, ay), (-dx / length, -dy / length))
        case Turn():
            for body, sign in ((coordinate.b, 1.0), (coordinate.a, -1.0)):
                if body != GROUND:
                    result[:, 3 * mechanism.body_index[body] + 2] += sign
        case Displacement():
            place = _point_place(poses, coordinate.body, coordinate.point)
            direction = (math.cos(coordinate.direction), math.sin(coordinate.direction))
            _add_gradient(result, mechanism, poses, coordinate.body, place, direction)
        case _:
            assert_never(coordinate)
    return result


def _point_place(
    poses: dict[str, PoseJet], body: str, point: tuple[float, float]
) -> tuple[Array | float, Array | float]:
    """Position (x, y) [m] of a body's point at the samples."""
    x, y = poses[body].point(point)
    return x.coefficients[0], y.coefficients[0]


def _add_gradient(
    result: Array,
    mechanism: Mechanism,
    poses: dict[str, PoseJet],
    body: str,
    place: tuple[Array | float, Array | float],
    direction: tuple[Array | float, Array | float],
) -> None:
    """Add the gradient of a point's displacement along a direction to rows (T, 3 n)."""
    if body == GROUND:
        return
    i = 3 * mechanism.body_index[body]
    rx, ry = place[0] - poses[body].x.coefficients[0], place[1] - poses[body].y.coefficients[0]
    result[:, i] += direction[0]
    result[:, i + 1] += direction[1]
    result[:, i + 2] += rx * direction[1] - ry * direction[0]


def load_forces(mechanism: Mechanism, poses: Array, rates: Array, times: Array) -> Array:
    """Generalised forces (T, 3 n) of all loads on the bodies, about the origins of their frames.

    Raises:
        InvalidInput: a force is not finite.
    """
    total = np.zeros_like(poses)
    if not mechanism.loads:
        return total
    bodies = pose_jets(mechanism, [poses, rates])
    for load in mechanism.loads:
        with np.errstate(divide="ignore", invalid="ignore"):  # what comes of it is refused below
            value, rate = coordinate_jet(load.along, bodies).coefficients
            force = load.law.force(np.asarray(value), np.asarray(rate), times)
            total += np.asarray(force)[:, None] * coordinate_gradient(load.along, mechanism, bodies, len(poses))
        if not np.isfinite(total).all():
            raise InvalidInput(f"{mechanism.name}: the force of {load.name} is not finite: do its two points meet?")
    return total
