"""Numerics of engines: ways between crank angles, roots, derivatives, ranks, centres of gravity and impulses."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Iterator

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, turned
from conrod.mechanism.mechanism import Body, Joint, Mechanism, to_world

SECANT_STEPS = 20


def close_gap(gap: Callable[[float], float], start: float, nudge: float, closed: float) -> float:
    """The argument at which a nearly linear function vanishes, by secant iteration.

    Args:
        gap: the function; called last at the result.
        start: first guess.
        nudge: distance of the second guess from it.
        closed: the iteration ends where |gap| is below this, or changes no more.
    """
    here, there = start, start + nudge
    gap_here, gap_there = gap(here), gap(there)
    for _ in range(SECANT_STEPS):
        if abs(gap_there) < closed or gap_there == gap_here:
            break
        here, there = there, there - gap_there * (there - here) / (gap_there - gap_here)
        gap_here, gap_there = gap_there, gap(there)
    return there


SAMPLES = 720
# Why there are no bounds for a linkage with a change point: there is no largest motion of links per gap of a joint.
UNDETERMINED = "none at a change point: there any give of the joints, however small, leaves the motion open"


def largest_derivatives(kinematics: Kinematics, order: int) -> list[float]:
    """Largest k-th derivative by the crank angle of any observed point, over its L; k = 0..order."""
    points = kinematics.point_derivatives(kinematics.derivatives(kinematics.angles(SAMPLES), order))
    sizes = [0.0] * (order + 1)
    for name, derivatives in points.items():
        length = kinematics.lengths[name]
        for k, values in enumerate(derivatives):
            sizes[k] = max(sizes[k], float(np.linalg.norm(values, axis=1).max()) / length)
    return sizes


def rounding(kinematics: Kinematics, steps: int) -> float:
    """Bound on the position error, over L, that rounding alone can sum up to in so many steps."""
    return float(np.finfo(float).eps) * steps * max(1.0, kinematics.size / kinematics.travel)


def phase_bound(steps: float, turns: float, start_angle: float = 0.0, ripple: float = 0.0) -> float:
    """Bound on the crank's deviation from its nominal angle [rad], in a run at a prescribed speed.

    A clock and an angle that are summed step by step round by eps of themselves at each; a rate that every turn may
    change by `ripple` is off by that of each turn before.

    Args:
        steps: of the whole run.
        start_angle: [rad].
    """
    turned = 2.0 * math.pi * turns
    return float(np.finfo(float).eps) * steps * (abs(start_angle) + turned) + ripple * max(turns, 1.0) * turned


# A kinematic mode's own angles are a degree apart; an iteration begun farther off may find another assembly.
LONGEST_STEP = 0.05  # [rad]
# So near [rad] to a change point, where assemblies meet, joints hardly tell the pose. pymunk solves them one after the
# other, and takes rounds by the square of this; its 2000 leave 8e-9 of a parallelogram's travel at half a degree, 2e-12
# at three, and nothing but rounding here.
MEETING = 0.08


def approached(
    kinematics: Kinematics, angles: Array, place: Callable[[float, Array | None], Array], always: bool = False
) -> Iterator[float]:
    """Crank angles (T,) [rad], each as soon as an engine is placed there, and at what lies between, from angle 0 on.

    What lies next to a change point is stepped over.

    Args:
        place: at an angle, begun from a state ahead if there is one, on the line through the last two: an iteration
            begun there goes through a change point. Returns the state that it found.
        always: whether it begins there where there is no change point, too.
    """
    before, found, ahead = 0.0, list[tuple[float, Array]](), always or kinematics.change_angles.size > 0
    for angle in map(float, angles):
        way = np.linspace(before, angle, max(1, math.ceil(abs(angle - before) / LONGEST_STEP)) + 1)[1:]
        for theta in (*map(float, way[:-1][~kinematics.near_change(way[:-1], MEETING)]), angle):
            start = _straight_ahead(theta, *found) if ahead and len(found) == 2 else None
            found = [*found[-1:], (theta, place(theta, start).copy())]
        yield angle
        before = angle


def _straight_ahead(angle: float, before: tuple[float, Array], last: tuple[float, Array]) -> Array:
    (first, start), (second, stop) = before, last
    return np.asarray(stop + (stop - start) * (angle - second) / (second - first))


# -- states of centres of gravity, which rigid-body engines integrate, and impulses that act on them -------------------


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
