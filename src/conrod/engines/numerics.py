"""Numerics that engines share: root finding, steps between crank angles, error bounds, centres of gravity."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Iterator

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, rotate_planar
from conrod.mechanism.mechanism import Body, Joint, Mechanism, to_world

MAX_SECANT_STEPS = 20


def secant_root(gap: Callable[[float], float], start: float, nudge: float, closed: float) -> float:
    """Find the root of a nearly linear function by secant iteration.

    Args:
        gap: the function; its last call is at the result.
        start: first guess.
        nudge: distance of the second guess from the first.
        closed: the iteration ends when |gap| is below this, or changes no more.
    """
    here, there = start, start + nudge
    gap_here, gap_there = gap(here), gap(there)
    for _ in range(MAX_SECANT_STEPS):
        if abs(gap_there) < closed or gap_there == gap_here:
            break
        here, there = there, there - gap_there * (there - here) / (gap_there - gap_here)
        gap_here, gap_there = gap_there, gap(there)
    return there


CRANK_SAMPLES = 720
# Reason why a linkage with a change point has no error bound: the motion of links per unit of joint gap is unbounded.
NO_BOUND_AT_CHANGE_POINT = "none at a change point: there any give of the joints, however small, leaves the motion open"


def largest_derivatives(kinematics: Kinematics, order: int) -> list[float]:
    """Largest k-th derivative of any observed point by the crank angle, over its travel L; k = 0..order."""
    points = kinematics.point_derivatives(kinematics.derivatives(kinematics.angles(CRANK_SAMPLES), order))
    sizes = [0.0] * (order + 1)
    for name, derivatives in points.items():
        length = kinematics.lengths[name]
        for k, values in enumerate(derivatives):
            sizes[k] = max(sizes[k], float(np.linalg.norm(values, axis=1).max()) / length)
    return sizes


def rounding_bound(kinematics: Kinematics, steps: int) -> float:
    """Bound on the position error over L that rounding alone can accumulate in a number of steps."""
    return float(np.finfo(float).eps) * steps * max(1.0, kinematics.size / kinematics.travel)


def phase_bound(steps: float, turns: float, start_angle: float = 0.0, ripple: float = 0.0) -> float:
    """Bound on the crank's deviation from its nominal angle [rad], in a run at a prescribed speed.

    It is eps steps (|start_angle| + 2 pi turns), as clock and angle are summed step by step, plus
    2 pi turns max(turns, 1) ripple, as each revolution may change the rate by the share `ripple`.

    Args:
        steps: number of steps of the whole run.
        turns: revolutions of the run.
        start_angle: [rad].
    """
    turned = 2.0 * math.pi * turns
    return float(np.finfo(float).eps) * steps * (abs(start_angle) + turned) + ripple * max(turns, 1.0) * turned


# Angles of kinematic mode are a degree apart; an iteration started from farther away may find another branch.
MAX_ANGLE_STEP = 0.05  # [rad]
# Within this distance [rad] of a change point, where branches meet, joints determine the pose badly. pymunk solves them
# one after the other, and the iterations it takes grow with the inverse square of the distance: 2000 of them leave 8e-9
# of a parallelogram's travel at half a degree, 2e-12 at three degrees, and only rounding at this distance.
NEAR_CHANGE_POINT = 0.08


def place_at_angles(
    kinematics: Kinematics, angles: Array, place: Callable[[float, Array | None], Array], always: bool = False
) -> Iterator[float]:
    """Place an engine at each crank angle (T,) [rad], through intermediate angles, and yield the angle.

    Intermediate angles next to a change point are left out.

    Args:
        place: places the engine at an angle [rad], starting from a state, or from the present one if it is None, and
            returns the state found. The state given is extrapolated from the last two, so that iterations started
            there pass a change point on their own branch.
        always: whether to extrapolate on machines without change points, too.
    """
    before, found, ahead = 0.0, list[tuple[float, Array]](), always or kinematics.change_angles.size > 0
    for angle in map(float, angles):
        way = np.linspace(before, angle, max(1, math.ceil(abs(angle - before) / MAX_ANGLE_STEP)) + 1)[1:]
        for theta in (*map(float, way[:-1][~kinematics.near_change(way[:-1], NEAR_CHANGE_POINT)]), angle):
            start = _extrapolate(theta, *found) if ahead and len(found) == 2 else None
            found = [*found[-1:], (theta, place(theta, start).copy())]
        yield angle
        before = angle


def _extrapolate(angle: float, before: tuple[float, Array], last: tuple[float, Array]) -> Array:
    """Extrapolate linearly through two states, each with its angle, to a third angle [rad]."""
    (first, start), (second, stop) = before, last
    return np.asarray(stop + (stop - start) * (angle - second) / (second - first))


# -- states of centres of gravity, which rigid-body engines integrate, and impulses that act on them -------------------


CentreState = tuple[float, float, float, float, float, float]


def centre_state(body: Body, pose: Array, rate: Array) -> CentreState:
    """Position [m], angle [rad] and their rates of a body's centre of gravity, from its pose (3,) and rates (3,)."""
    x, y, phi = pose
    vx, vy, spin = rate
    gx, gy = to_world((x, y, phi), body.centre_of_gravity)
    return gx, gy, float(phi), vx - spin * (gy - y), vy + spin * (gx - x), float(spin)


def frames_from_centres(mechanism: Mechanism, centres: Array, rates: Array) -> tuple[Array, Array]:
    """Poses and rates of the body frames, given centres of gravity and their rates; (T, 3 n) [m, m, rad]."""
    return _shift_reference_points(mechanism, centres, rates, -1.0)


def centres_from_frames(mechanism: Mechanism, poses: Array, rates: Array) -> tuple[Array, Array]:
    """Centres of gravity and their rates, given poses and rates of the body frames; (T, 3 n) [m, m, rad]."""
    return _shift_reference_points(mechanism, poses, rates, 1.0)


def _shift_reference_points(mechanism: Mechanism, states: Array, rates: Array, sign: float) -> tuple[Array, Array]:
    """Move each body's reference point by `sign` times the arm from its frame to its centre of gravity."""
    poses, speeds = states.copy(), rates.copy()
    shift_to_frames(mechanism, poses, speeds, sign)
    return poses, speeds


def shift_to_frames(mechanism: Mechanism, poses: Array, speeds: Array, sign: float = -1.0) -> None:
    """Replace centres of gravity and their rates (T, 3 n) by poses and rates of the body frames; +1 for the reverse."""
    for i, body in enumerate(mechanism.bodies):
        if body.centre_of_gravity == (0.0, 0.0):
            continue
        x, y = rotate_planar(body.centre_of_gravity, poses[:, 3 * i + 2])
        spin = speeds[:, 3 * i + 2]
        poses[:, 3 * i] += sign * x
        poses[:, 3 * i + 1] += sign * y
        speeds[:, 3 * i] -= sign * (spin * y)
        speeds[:, 3 * i + 1] += sign * (spin * x)


def poses_by_centres(mechanism: Mechanism, poses: Array) -> Array:
    """Derivatives (S, 3 n, 3 n) of the poses by positions of the centres of gravity and body angles."""
    found = np.tile(np.eye(poses.shape[1]), (len(poses), 1, 1))
    for i, body in enumerate(mechanism.bodies):
        (x, y), turn = body.centre_of_gravity, poses[:, 3 * i + 2]
        found[:, 3 * i, 3 * i + 2] = np.sin(turn) * x + np.cos(turn) * y
        found[:, 3 * i + 1, 3 * i + 2] = np.sin(turn) * y - np.cos(turn) * x
    return found


def inverse_masses(mechanism: Mechanism, translating: Container[str] = ()) -> Array:
    """Inverse masses and inertias of all bodies (3 n,) [1/kg, 1/kg, 1/(kg m^2)]; 0 for the driven crank.

    Args:
        translating: names of the bodies that a slide keeps from rotating.
    """
    found = []
    for body in mechanism.bodies:
        turning = 0.0 if body.name in translating else 1.0 / body.inertia
        moves = body.name != mechanism.crank
        found += [1.0 / body.mass, 1.0 / body.mass, turning] if moves else [0.0, 0.0, 0.0]
    return np.array(found)


def joint_rows(kinematics: Kinematics) -> Iterator[tuple[Joint, slice]]:
    """Yield each joint except the driven one, with the slice of its rows among all joint equations."""
    first = 0
    for joint in kinematics.mechanism.joints:
        rows = slice(first, first + kinematics.equations_of(joint))
        first = rows.stop
        if joint.name != kinematics.mechanism.driver.joint:
            yield joint, rows


def iteration_matrix(jacobian: Array, inverse: Array, constraints: Iterable[slice]) -> Array:
    """Matrices T (S, n, n) by which one iteration of sequential impulses multiplies a velocity error.

    T is the product over joints i, in order, of the projections I - M^-1 J_i' (J_i M^-1 J_i')^-1 J_i.

    Args:
        jacobian: J, derivatives of all joint equations by the free coordinates of the centres of gravity (S, m, n).
        inverse: diagonal of M^-1 in these coordinates (n,).
        constraints: rows of J that are solved together, in the order in which the engine solves them.
    """
    product = np.broadcast_to(np.eye(len(inverse)), (len(jacobian), len(inverse), len(inverse)))
    for rows in constraints:
        along = jacobian[:, rows]
        impulse = inverse[:, None] * np.swapaxes(along, 1, 2)
        product = product - impulse @ np.linalg.solve(along @ impulse, along @ product)
    return product
