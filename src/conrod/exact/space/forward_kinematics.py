"""Forward kinematics of a machine in space, at many samples at once, as Taylor series in time.

A series is a list of coefficients f^(k)/k!, missing ones being zero; each has its samples last: a vector is (3, T), a
rotation (3, 3, T). What does not move has one sample. Rotations of balls follow R' = R [w]x, w in the body's frame
(Featherstone, Rigid Body Dynamics Algorithms, 2008, equation 2.36), coefficient by coefficient.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from conrod.exact.jet import Jet, sine_cosine
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialJoint, SpatialPoint, SpatialTree

Series: TypeAlias = list[Array]


def cross_matrix(vector: Array) -> Array:
    """The matrix (3, 3, ...) [v]x, with [v]x u = v x u, of vectors (3, ...)."""
    x, y, z = vector
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])


def rotation_matrices(quaternion: Array) -> Array:
    """Rotation matrices (3, 3, T) of unit quaternions (4, T), scalar first."""
    w, v = quaternion[0], quaternion[1:]
    skew = cross_matrix(v)
    return np.asarray(np.eye(3)[:, :, None] + 2.0 * (w * skew + _matrix_product(skew, skew)))


def _matrix_product(a: Array, b: Array) -> Array:
    """Product of two rotations or matrices (3, 3, ...)."""
    return np.asarray(np.einsum("ij...,jk...->ik...", a, b))


def multiply_series(
    a: Series, b: Series, order: int, times: Callable[[Array, Array], Array] = _matrix_product
) -> Series:
    """Product of two series up to an order; of rotations unless another product is given."""
    made = []
    for k in range(min(order, len(a) + len(b) - 2) + 1):
        terms = [times(a[i], b[k - i]) for i in range(max(0, k - len(b) + 1), min(k + 1, len(a)))]
        made.append(sum(terms[1:], terms[0]))
    return made


def rotate_series(turn: Series, vector: Array) -> Series:
    """A vector (3,), or one for each sample (3, T), fixed in a rotating frame, in the ground's directions."""
    product = "ijt,j->it" if vector.ndim == 1 else "ijt,jt->it"
    return [np.einsum(product, one, vector) for one in turn]


def place_beside(place: Series, turn: Series, vector: Array) -> Series:
    """Position of a point at a vector (3,) or (3, T) from the origin of a moving frame."""
    return add_series(place, rotate_series(turn, vector)) if any(vector.tolist()) else place


def add_series(*terms: Series) -> Series:
    """Sum of several series."""
    made = []
    for k in range(max(map(len, terms))):
        first, *others = [term[k] for term in terms if k < len(term)]
        # From 0.0 on: no sum is -0.0.
        made.append(sum(others, first) + 0.0)
    return made


def scale_series(series: Series, by: Series, order: int) -> Series:
    """Product of a series of vectors or numbers with one of numbers, each (T,), up to an order."""
    return multiply_series(series, by, order, operator.mul)


@dataclass(frozen=True, eq=False)
class Poses:
    """Positions and rotations of all bodies, and of the joints' axes, at T samples.

    Attributes:
        places, turns: Taylor series of the bodies' positions (3, T) [m] and rotation matrices (3, 3, T).
        anchors: position (3, T) [m] of each joint; the key is the index of its first rate.
        frames: rotation (3, 3, T) of the frame in which a joint's axes are fixed; keys as in `anchors`.
        scalars: Taylor series (T,) of the coordinates of hinges and slides; keys as in `anchors`.
    """

    tree: SpatialTree
    places: list[Series]
    turns: list[Series]
    anchors: dict[int, Array]
    frames: dict[int, Array]
    scalars: dict[int, Series]

    def point(self, point: SpatialPoint) -> Series:
        """Position of a point that is fixed to a body, as a series."""
        return place_beside(self.places[point.body], self.turns[point.body], point.offset)

    def axes(self, joint: SpatialJoint) -> Array:
        """Axes (3, n, T) of a joint's n rates; of a free joint the axes of rotation alone."""
        frame = self.frames[joint.rate]
        if joint.kind in ("ball", "free"):
            return frame
        return rotate_series([frame], joint.axis)[0][:, None]


def forward_kinematics(tree: SpatialTree, coordinates: Array, rates: Array | None = None) -> Poses:
    """Compute the poses of all bodies from joint coordinates and rates.

    Args:
        coordinates: (nq, T).
        rates: Taylor coefficients of the rates (K, nv, T); the poses have one more. None for positions alone.
    """
    return _ForwardRecursion(tree, coordinates, np.zeros((0, tree.freedom, 1)) if rates is None else rates).run()


class _ForwardRecursion:
    """Recursion from the ground outwards, body by body."""

    def __init__(self, tree: SpatialTree, coordinates: Array, rates: Array) -> None:
        self.q, self.rates, self.order = coordinates, rates, len(rates)
        ground_place, ground_turn = np.zeros((3, 1)), np.eye(3)[:, :, None]
        self.poses = Poses(tree, [[ground_place]], [[ground_turn]], {}, {}, {})

    def run(self) -> Poses:
        """Compute the poses of all bodies."""
        for body in self.poses.tree.bodies[1:]:
            self._add_body(body)
        return self.poses

    def _add_body(self, body: SpatialBody) -> None:
        """Compute the pose of one body from its parent's."""
        above = self.poses.turns[body.parent]
        place = place_beside(self.poses.places[body.parent], above, body.place)
        turn = [np.einsum("ijt,jk->ikt", one, body.turn) for one in above] if body.is_turned else above
        for joint in body.joints:
            place, turn = self._move_by_joint(joint, place, turn)
        if body.joints and (len(place) < len(turn) or place[0].shape[1] < self.q.shape[1]):
            # An origin on its joint's axis does not move, and still has a place at each instant.
            resting = np.zeros((3, self.q.shape[1]))
            place = [place[0] + resting, *place[1:], *[resting] * (len(turn) - len(place))]
        self.poses.places.append(place)
        self.poses.turns.append(turn)

    def _move_by_joint(self, joint: SpatialJoint, place: Series, turn: Series) -> tuple[Series, Series]:
        """Move a frame by a joint, and record the joint's anchor and the frame of its axes."""
        at, frames, anchors = joint.coordinate, self.poses.frames, self.poses.anchors
        if joint.kind == "free":
            linear = [self.rates[k, joint.rate : joint.rate + 3] / (k + 1) for k in range(self.order)]
            # + 0.0: no place is -0.0.
            place, turn = [one + 0.0 for one in (self.q[at : at + 3], *linear)], self._ball(at + 3, joint.rate + 3)
            anchors[joint.rate], frames[joint.rate] = place[0], turn[0]
            return place, turn
        anchor = place_beside(place, turn, joint.anchor)
        anchors[joint.rate] = anchor[0]
        if joint.kind == "ball":
            turn = multiply_series(turn, self._ball(at, joint.rate), self.order)
            frames[joint.rate] = turn[0]
            return place_beside(anchor, turn, -joint.anchor), turn
        value = [self.q[at] - joint.reference, *(self.rates[k, joint.rate] / (k + 1) for k in range(self.order))]
        self.poses.scalars[joint.rate] = [self.q[at], *value[1:]]
        frames[joint.rate] = turn[0]
        if joint.kind == "slide":
            return add_series(place, scale_series(rotate_series(turn, joint.axis), value, self.order)), turn
        turn = multiply_series(turn, _hinge_rotation(joint, value), self.order)
        return place_beside(anchor, turn, -joint.anchor), turn

    def _ball(self, at: int, rate: int) -> Series:
        """Rotation of a quaternion, with derivatives from rates in the rotated frame."""
        made = [rotation_matrices(self.q[at : at + 4] / np.linalg.norm(self.q[at : at + 4], axis=0))]
        spins = [cross_matrix(one) for one in self.rates[:, rate : rate + 3]]
        for k in range(self.order):
            terms = [_matrix_product(made[i], spins[k - i]) for i in range(k + 1)]
            made.append(sum(terms[1:], terms[0]) / (k + 1))
        return made


def _hinge_rotation(joint: SpatialJoint, angle: Series) -> Series:
    """Rotations about a hinge's axis by a series of angles (Rodrigues' formula)."""
    skew, square, unturned = joint.rodrigues
    if len(angle) == 1:
        return [skew * np.sin(angle[0]) - square * np.cos(angle[0]) + unturned]
    sine, cosine = (one.coefficients for one in sine_cosine(Jet(angle)))
    made = [skew * s - square * c for s, c in zip(sine, cosine, strict=True)]
    made[0] = made[0] + unturned
    return made
