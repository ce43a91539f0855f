"""Exact rotation of the links: angle, angular velocity and angular acceleration at given crank angles."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from conrod.exact.kinematics import SAMPLES_TOGETHER, Kinematics
from conrod.exact.motion import Array, Side, cache_blocks

ROTATIONS = ("rotation", "angular_velocity", "angular_acceleration")  # of a link, that engines are compared in
ROTATION_UNITS = dict(zip(ROTATIONS, ("rad", "rad/s", "rad/s^2"), strict=True))
ROTATION_COLUMNS = dict(zip(ROTATIONS, ("angle", "omega", "alpha"), strict=True))  # of tables, as in `omega_rod`
MIN_ROTATION = 1e-6  # [rad] over a revolution; a link that rotates less is guided so that it does not rotate


def link_rotations(
    kinematics: Kinematics,
    angle: ArrayLike,
    speed: ArrayLike,
    acceleration: ArrayLike = 0.0,
    side: Side = "right",
    order: int = 2,
) -> tuple[Array, ...]:
    """Rotation phi, angular velocity omega and angular acceleration alpha of all links, in `Mechanism.bodies`' order.

    With derivatives phi', phi'' by the crank angle, its rate w and its angular acceleration a, the chain rule gives
    omega = phi' w and alpha = phi'' w^2 + phi' a. Rotations are counter-clockwise and count on over whole turns.

    Args:
        angle: crank angles (T,) [rad].
        speed: crank speed w [rad/s], a number or (T,).
        acceleration: angular acceleration a of the crank [rad/s^2], a number or (T,).
        side: the limit to take where the angular acceleration jumps, seen along increasing crank angle.
        order: highest derivative in time.

    Returns:
        The first `order` + 1 of phi [rad], omega [rad/s] and alpha [rad/s^2], (T, n) each.
    """
    theta = np.atleast_1d(np.asarray(angle, dtype=float))
    w, a = (np.broadcast_to(np.asarray(one, dtype=float), theta.shape)[:, None] for one in (speed, acceleration))
    blocks = [
        [derivative[:, 2::3] for derivative in kinematics.derivatives(theta[rows], order, side)]
        for rows in cache_blocks(len(theta), SAMPLES_TOGETHER)
    ]
    by_angle = [np.concatenate(parts) for parts in zip(*blocks, strict=True)]
    if order > 1:
        by_angle[2] = by_angle[2] * w**2 + by_angle[1] * a
    if order > 0:
        by_angle[1] = by_angle[1] * w
    return tuple(by_angle)


def rotating_links(kinematics: Kinematics) -> tuple[str, ...]:
    """Names of the driven links that rotate; the crank is none, since its rotation is the crank angle."""
    crank = kinematics.mechanism.crank
    return tuple(name for name, size in kinematics.rotation_ranges.items() if name != crank and size > MIN_ROTATION)


def rotation_scales(kinematics: Kinematics) -> dict[str, float]:
    """Size [rad] over which errors of each driven link's rotation are taken: its range R, or 1 rad if it has none.

    Angular velocities are over omega R and angular accelerations over omega^2 R, with the crank speed omega.
    """
    crank = kinematics.mechanism.crank
    return {
        name: size if size > MIN_ROTATION else 1.0 for name, size in kinematics.rotation_ranges.items() if name != crank
    }


def largest_rotation(kinematics: Kinematics, rotations: Array) -> float:
    """Largest of rotations (T, n), or of their derivatives by the crank angle, over the scales of the driven links."""
    index, scales = kinematics.mechanism.body_index, rotation_scales(kinematics)
    return max((float(np.abs(rotations[:, index[name]]).max()) / scale for name, scale in scales.items()), default=0.0)
