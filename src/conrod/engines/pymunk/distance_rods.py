"""Links that carry nothing but two pins, as distance joints: without a body, pins held apart by the link's length.

The engine then knows neither the link's motion nor its mass. The motion is reported from that of the two pins.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conrod.engines.numerics import joint_rows
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, rotate_planar
from conrod.mechanism.loads import Displacement, Load
from conrod.mechanism.mechanism import (
    GROUND,
    INERTIA_RANGE,
    MASS_RANGE,
    Body,
    Mechanism,
    Point,
    Revolute,
    joint_partner,
)

NO_ROD = "no link carries nothing but two pins to other moving links"


@dataclass(frozen=True)
class DistanceRod:
    """A link without a body: `point_a` of body `a` and `point_b` of body `b` keep their distance.

    Attributes:
        link: name of the link.
        pin_a, pin_b: the same two points in the link's frame [m].
    """

    link: str
    a: str
    b: str
    point_a: Point
    point_b: Point
    pin_a: Point
    pin_b: Point

    @property
    def length(self) -> float:
        """Distance of the pins [m]."""
        return math.dist(self.pin_a, self.pin_b)

    def columns(self, whole: Mechanism) -> slice:
        """Columns of the link in states (..., 3 n) of all links of a mechanism."""
        i = 3 * whole.body_index[self.link]
        return slice(i, i + 3)


def find_rods(mechanism: Mechanism) -> tuple[DistanceRod, ...]:
    """Links that can be distance joints; of two that are pinned to each other the first alone."""
    found: list[DistanceRod] = []
    partners: set[str] = set()
    for body in mechanism.bodies:
        rod = _as_rod(mechanism, body.name)
        if rod is not None and body.name not in partners:
            found.append(rod)
            partners |= {rod.a, rod.b}
    return tuple(found)


def _as_rod(mechanism: Mechanism, link: str) -> DistanceRod | None:
    """The distance joint that can replace a link; None if the link has other joints, a force, or drives."""
    joints = mechanism.joints_on(link)
    loaded = set(mechanism.constant_forces).union(*(_loaded_bodies(load) for load in mechanism.loads))
    if len(joints) != 2 or link == mechanism.crank or link in loaded:
        return None
    ends = [joint_partner(joint, link) for joint in joints if isinstance(joint, Revolute)]
    if len(ends) != 2 or GROUND in (ends[0][0], ends[1][0]) or ends[0][0] == ends[1][0]:
        return None
    (a, point_a, pin_a), (b, point_b, pin_b) = ends
    # What rolls off counts against the link between its wheels; two pins in one place hold nothing apart.
    if any({mesh.a, mesh.b} == {a, b} for mesh in mechanism.meshes) or pin_a == pin_b:
        return None
    return DistanceRod(link, a, b, point_a, point_b, pin_a, pin_b)


def _loaded_bodies(load: Load) -> set[str]:
    """Names of the bodies that a load acts on."""
    return {load.along.body} if isinstance(load.along, Displacement) else {load.along.a, load.along.b}


def without_rods(mechanism: Mechanism, rods: Sequence[DistanceRod]) -> Mechanism:
    """The mechanism without rods, their pins, and the points observed on rods."""
    gone = {rod.link for rod in rods}
    return replace(
        mechanism,
        bodies=tuple(body for body in mechanism.bodies if body.name not in gone),
        joints=tuple(joint for joint in mechanism.joints if not {joint.a, joint.b} & gone),
        poses={name: pose for name, pose in mechanism.poses.items() if name not in gone},
        observed=tuple(point for point in mechanism.observed if point.body not in gone),
    )


LIGHT_SHARE = 1e-3  # of a rod's mass and moment, where it is a light body


def with_light_rods(mechanism: Mechanism) -> Mechanism:
    """The mechanism with rods of a thousandth of their mass, as links without mass are modelled by bodies."""
    light = {rod.link for rod in find_rods(mechanism)}
    bodies = tuple(_light_copy(body) if body.name in light else body for body in mechanism.bodies)
    return replace(mechanism, bodies=bodies)


def _light_copy(body: Body) -> Body:
    """Return a body with a thousandth of its mass and moment, but not below the least allowed."""
    mass, inertia = max(LIGHT_SHARE * body.mass, MASS_RANGE[0]), max(LIGHT_SHARE * body.inertia, INERTIA_RANGE[0])
    return replace(body, mass=mass, inertia=inertia)


def body_columns(whole: Mechanism, bodies: Mechanism) -> list[int]:
    """Columns that the bodies of a mechanism without rods have in states (..., 3 n) of all links."""
    return [3 * whole.body_index[body.name] + k for body in bodies.bodies for k in range(3)]


def eliminate_rods(
    kinematics: Kinematics, rods: Sequence[DistanceRod], jacobian: Array, free: NDArray[np.int_], rows: list[slice]
) -> tuple[Array, list[slice], Array]:
    """Replace the pins of rods in a Jacobian by one distance equation for each rod.

    With J_r the derivatives of a rod's four pin equations by its own coordinates, and J_o by all others, the distance
    joint is z' J_o q_o = 0 where z' J_r = 0, and the rod moves by q_r = -pinv(J_r) J_o q_o.

    Args:
        jacobian: derivatives (S, m, 3 n) of all joint equations.
        free: columns of the bodies that move freely.
        rows: rows of each constraint.

    Returns:
        Derivatives (S, m + r, f) by the free coordinates, with a last row for each rod; rows of the constraints; and
        the motion (S, 3 n, f) of the rods per motion of the free coordinates.
    """
    mechanism, gone, distances = kinematics.mechanism, set[int](), list[Array]()
    moved = np.zeros((len(jacobian), jacobian.shape[2], len(free)))
    for rod in rods:
        own = rod.columns(mechanism)
        starts = [taken.start for joint, taken in joint_rows(kinematics) if rod.link in (joint.a, joint.b)]
        pins = [row + k for row in starts for k in (0, 1)]
        of_rod, of_others = jacobian[:, pins, own], jacobian[:, pins][:, :, free]
        unmoved = np.linalg.svd(of_rod)[0][:, :, 3]
        distances.append((unmoved[:, None, :] @ of_others)[:, 0])
        moved[:, own] = -np.linalg.pinv(of_rod) @ of_others
        gone |= set(starts)
    first = jacobian.shape[1]
    kept = [one for one in rows if one.start not in gone]
    kept += [slice(first + k, first + k + 1) for k in range(len(rods))]
    return np.concatenate([jacobian[:, :, free], np.stack(distances, axis=1)], axis=1), kept, moved


def add_rod_states(
    whole: Mechanism,
    bodies: Mechanism,
    rods: Sequence[DistanceRod],
    states: tuple[Array, Array],
    ahead: float,
    near: Sequence[float],
) -> tuple[Array, Array]:
    """Add the states of rods to bodies' states: centres of gravity (T, 3 n) [m, m, rad], and rates.

    A rod lies along the line of its pins, its middle in theirs: with d = p_b - p_a and w = v_b - v_a its rate is
    (d x w) / |d|^2. Rates belong to a time `ahead` after the sample (`SampleInstants`), to which the pins are
    extrapolated.

    Args:
        whole: the mechanism with all its links.
        bodies: the mechanism without the rods.
        states: centres of gravity (T, 3 m) of the bodies, and their rates.
        ahead: time from a sample to the instant of its rates [s].
        near: rotation of each rod [rad] at the first sample but for whole turns.
    """
    columns, (centres, rates) = body_columns(whole, bodies), states
    full, speeds = np.zeros((2, len(centres), 3 * len(whole.bodies)))
    full[:, columns], speeds[:, columns] = centres, rates
    later = full + ahead * speeds
    for rod, start in zip(rods, near, strict=True):
        own = rod.columns(whole)
        here = _pins(whole, rod, full, speeds)
        turn = _unwrap_rotations(_direction(rod, here), start)
        full[:, own] = np.column_stack([_centre(whole, rod, here, turn)[0], turn])
        there = _pins(whole, rod, later, speeds)
        (first, second), (slow, fast) = there
        d, w = second - first, fast - slow
        spin = (d[:, 0] * w[:, 1] - d[:, 1] * w[:, 0]) / (d * d).sum(axis=1)
        arm = _centre(whole, rod, there, _direction(rod, there))[1]
        carried = 0.5 * (slow + fast) + np.column_stack([-spin * arm[:, 1], spin * arm[:, 0]])
        speeds[:, own] = np.column_stack([carried, spin])
    return full, speeds


Pins = tuple[tuple[Array, Array], tuple[Array, Array]]  # positions (T, 2) [m] of both, and velocities (T, 2) [m/s]


def _pins(whole: Mechanism, rod: DistanceRod, centres: Array, rates: Array) -> Pins:
    """Positions and velocities of a rod's two pins, from states of the bodies that hold them."""
    places, speeds = list[Array](), list[Array]()
    for body, point in ((rod.a, rod.point_a), (rod.b, rod.point_b)):
        i, (cx, cy) = 3 * whole.body_index[body], whole.body(body).centre_of_gravity
        x, y = rotate_planar((point[0] - cx, point[1] - cy), centres[:, i + 2])
        spin = rates[:, i + 2]
        places.append(centres[:, i : i + 2] + np.column_stack([x, y]))
        speeds.append(rates[:, i : i + 2] + np.column_stack([-spin * y, spin * x]))
    return (places[0], places[1]), (speeds[0], speeds[1])


def _direction(rod: DistanceRod, pins: Pins) -> Array:
    """Rotation (T,) of a rod [rad] but for whole turns."""
    d = pins[0][1] - pins[0][0]
    own = math.atan2(rod.pin_b[1] - rod.pin_a[1], rod.pin_b[0] - rod.pin_a[0])
    return np.asarray(np.arctan2(d[:, 1], d[:, 0]) - own)


def _unwrap_rotations(turn: Array, near: float) -> Array:
    """Unwrap rotations (T,) [rad]; the first comes within half a turn of `near`."""
    # Whole turns are counted, so that the same bits come of a run wherever it is cut.
    return np.asarray(turn - 2.0 * np.pi * np.cumsum(np.rint(np.diff(turn, prepend=near) / (2.0 * np.pi))))


def _centre(whole: Mechanism, rod: DistanceRod, pins: Pins, turn: Array) -> tuple[Array, Array]:
    """Centre of gravity (T, 2) of a rod [m], and the arm (T, 2) from the middle of its pins to it."""
    (cx, cy), own = whole.body(rod.link).centre_of_gravity, (rod.pin_a, rod.pin_b)
    middle = [0.5 * (p + q) for p, q in zip(*own, strict=True)]
    arm = np.column_stack(rotate_planar((cx - middle[0], cy - middle[1]), turn))
    return 0.5 * (pins[0][0] + pins[0][1]) + arm, arm
