"""Positions, velocities and accelerations of a model's points, noted sample by sample and computed for all at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.loading import NO_GRAVITY, FoundPoint

PLACES = {"site": "site_xpos", "body": "xpos", "geom": "geom_xpos"}


def point_noter(model: mujoco.MjModel, points: Sequence[FoundPoint]) -> Callable[[mujoco.MjData], Array]:
    """Return a function that notes what `point_motions` needs of points (P, 18), after `mj_rnePostConstraint`."""
    bodies = np.array([point.body for point in points], dtype=int)
    roots, of_kind = model.body_rootid[bodies], list[tuple[str, list[int], list[int]]]()
    for kind, name in PLACES.items():
        if at := [k for k, point in enumerate(points) if point.kind == kind]:
            of_kind.append((name, at, [points[k].index for k in at]))

    beside = [k for k, point in enumerate(points) if any(point.offset)]

    def note(data: mujoco.MjData) -> Array:
        noted = np.empty((len(bodies), 18))
        for name, at, indices in of_kind:
            noted[at, :3] = getattr(data, name)[indices]
        for k in beside:
            noted[k, :3] = points[k].position(data)
        noted[:, 3:6] = data.subtree_com[roots]
        noted[:, 6:12], noted[:, 12:] = data.cvel[bodies], data.cacc[bodies]
        return noted

    return note


def point_motions(model: mujoco.MjModel, noted: Array) -> Array:
    """Position, velocity and acceleration (T, P, 3, 3) of noted points (T, P, 18), as `FoundPoint.motion` has them.

    MuJoCo keeps velocities and accelerations of bodies at the centre of gravity c of their tree: with the arm r from c
    to the point, v = v_c + w x r, and a = a_c + w' x r + w x v (`mj_objectAcceleration`).
    """
    place, centre, turning, linear, gain, change = (noted[..., 3 * k : 3 * k + 3] for k in range(6))
    # An accelerometer's: what rests reads the reaction to gravity.
    fall = 0.0 if model.opt.disableflags & NO_GRAVITY else model.opt.gravity
    with np.errstate(invalid="ignore", over="ignore"):  # of a run that ended with numbers that are none
        arm = place - centre
        velocity = linear - _cross(arm, turning)
        acceleration = (change - _cross(arm, gain)) + _cross(turning, velocity)
        return np.stack([place, velocity, acceleration + fall], axis=-2)


def _cross(a: Array, b: Array) -> Array:
    """Cross products of vectors (..., 3), each component with MuJoCo's operations."""
    return np.stack(
        [
            a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1],
            a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
            a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0],
        ],
        axis=-1,
    )
