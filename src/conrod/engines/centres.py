"""States of centres of gravity, which engines of rigid bodies integrate, and impulses that act on them by turns."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, turned
from conrod.mechanism.mechanism import Body, Joint, Mechanism, to_world

CentreState = tuple[float, float, float, float, float, float]


def centre_state(body: Body, pose: Array, rate: Array) -> CentreState:
    """Place [m], turn [rad] and their rates of a body's centre of gravity, from the pose (3,) and rates (3,) of it."""
    x, y, phi = pose
    vx, vy, spin = rate
    gx, gy = to_world((x, y, phi), body.centre_of_gravity)
    return gx, gy, float(phi), vx - spin * (gy - y), vy + spin * (gx - x), float(spin)


def body_states(mechanism: Mechanism, centres: Array, rates: Array, back: float = 1.0) -> tuple[Array, Array]:
    """Poses and rates of the body frames from those of the centres of gravity; with `back` -1 the other way round."""
    poses, speeds = centres.copy(), rates.copy()
    for i, body in enumerate(mechanism.bodies):
        if body.centre_of_gravity == (0.0, 0.0):
            continue
        x, y = turned(body.centre_of_gravity, centres[:, 3 * i + 2])
        spin = rates[:, 3 * i + 2]
        poses[:, 3 * i] -= back * x
        poses[:, 3 * i + 1] -= back * y
        speeds[:, 3 * i] += back * (spin * y)
        speeds[:, 3 * i + 1] -= back * (spin * x)
    return poses, speeds


def by_centres(mechanism: Mechanism, poses: Array) -> Array:
    """Change of poses (S, 3 n, 3 n) by the coordinates of the centres of gravity and the turns."""
    found = np.tile(np.eye(poses.shape[1]), (len(poses), 1, 1))
    for i, body in enumerate(mechanism.bodies):
        (x, y), turn = body.centre_of_gravity, poses[:, 3 * i + 2]
        found[:, 3 * i, 3 * i + 2] = np.sin(turn) * x + np.cos(turn) * y
        found[:, 3 * i + 1, 3 * i + 2] = np.sin(turn) * y - np.cos(turn) * x
    return found


def inverse_masses(mechanism: Mechanism, straight: Container[str] = ()) -> Array:
    """By the coordinates of all centres of gravity and turns (3 n,), 0 of what cannot be moved: the crank.

    Args:
        straight: names of bodies that cannot turn.
    """
    found = []
    for body in mechanism.bodies:
        turning = 0.0 if body.name in straight else 1.0 / body.inertia
        moves = body.name != mechanism.crank
        found += [1.0 / body.mass, 1.0 / body.mass, turning] if moves else [0.0, 0.0, 0.0]
    return np.array(found)


def equations(kinematics: Kinematics) -> Iterator[tuple[Joint, slice]]:
    """Each joint but the driven one, with its rows among all joint equations."""
    first = 0
    for joint in kinematics.mechanism.joints:
        rows = slice(first, first + kinematics.equations_of(joint))
        first = rows.stop
        if joint.name != kinematics.mechanism.driver.joint:
            yield joint, rows


def one_iteration(jacobian: Array, inverse: Array, constraints: Iterable[slice]) -> Array:
    """Product T (S, n, n) of the projections by which one iteration of sequential impulses changes velocities.

    Args:
        jacobian: of all joint equations by the free coordinates of the centres of gravity (S, m, n).
        inverse: masses and inertias by these coordinates (n,).
        constraints: equations that are solved together, in the order in which they are.
    """
    product = np.broadcast_to(np.eye(len(inverse)), (len(jacobian), len(inverse), len(inverse)))
    for rows in constraints:
        along = jacobian[:, rows]
        impulse = inverse[:, None] * np.swapaxes(along, 1, 2)
        product = product - impulse @ np.linalg.solve(along @ impulse, along @ product)
    return product
