"""Forward kinematics of a machine in space, at many samples at once, as Taylor series in time.

A series is a list of coefficients f^(k)/k!, missing ones being zero; each has its samples last: a vector is (3, T), a
turn (3, 3, T). What does not move has one sample. Turns of balls follow R' = R [w]x, w in the body's frame
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
    """The matrix (3, 3, ...) that makes the cross product of a vector (3, ...) with another."""
    x, y, z = vector
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])


def turn_of(quaternion: Array) -> Array:
    """The turn (3, 3, T) of unit quaternions (4, T), the scalar first."""
    w, v = quaternion[0], quaternion[1:]
    skew = cross_matrix(v)
    return np.asarray(np.eye(3)[:, :, None] + 2.0 * (w * skew + _times(skew, skew)))


def _times(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij...,jk...->ik...", a, b))


def product(a: Series, b: Series, order: int, times: Callable[[Array, Array], Array] = _times) -> Series:
    """Coefficients up to an order of the product of two series, of turns unless another product is given."""
    made = []
    for k in range(min(order, len(a) + len(b) - 2) + 1):
        terms = [times(a[i], b[k - i]) for i in range(len(a)) if 0 <= k - i < len(b)]
        made.append(sum(terms[1:], terms[0]))
    return made


def turned(turn: Series, vector: Array) -> Series:
    """A vector (3,) fixed in a turning frame, seen from the ground."""
    return [np.einsum("ijt,j->it", one, vector) for one in turn]


def added(*terms: Series) -> Series:
    """Sum of series."""
    longest = max(map(len, terms))
    return [sum(t[k] for t in terms if k < len(t)) + np.zeros(1) for k in range(longest)]


def scaled(series: Series, by: Series, order: int) -> Series:
    """Product of a series of vectors or numbers with one of numbers, each (T,), up to an order."""
    return product(series, by, order, operator.mul)


@dataclass(frozen=True, eq=False)
class Poses:
    """Places and turns of all bodies, and of the joints' axes, at T samples.

    Attributes:
        places, turns: of the bodies' frames: series of (3, T) and (3, 3, T).
        anchors, axes: by the joint's first rate, at order 0: its anchor (3, T), and its rates' axes (3, n, T).
        scalars: coordinates of hinges and slides, by their rate: series of (T,).
    """

    tree: SpatialTree
    places: list[Series]
    turns: list[Series]
    anchors: dict[int, Array]
    axes: dict[int, Array]
    scalars: dict[int, Series]

    def point(self, point: SpatialPoint) -> Series:
        """Place of a point that is fixed to a body."""
        if not np.any(point.offset):
            return self.places[point.body]
        return added(self.places[point.body], turned(self.turns[point.body], point.offset))


def poses(tree: SpatialTree, coordinates: Array, rates: Array | None = None) -> Poses:
    """Poses of all bodies.

    Args:
        coordinates: (nq, T).
        rates: coefficients of the rates' series (K, nv, T); the poses' have one more. None for places alone.
    """
    return _Walk(tree, coordinates, np.zeros((0, tree.freedom, 1)) if rates is None else rates).made()


class _Walk:
    """Goes from the ground outwards, body by body."""

    def __init__(self, tree: SpatialTree, coordinates: Array, rates: Array) -> None:
        self.q, self.rates, self.order = coordinates, rates, len(rates)
        ground_place, ground_turn = np.zeros((3, 1)), np.eye(3)[:, :, None]
        self.poses = Poses(tree, [[ground_place]], [[ground_turn]], {}, {}, {})

    def made(self) -> Poses:
        for body in self.poses.tree.bodies[1:]:
            self._add(body)
        return self.poses

    def _add(self, body: SpatialBody) -> None:
        above = self.poses.turns[body.parent]
        place = added(self.poses.places[body.parent], turned(above, body.place))
        turn = [np.einsum("ijt,jk->ikt", one, body.turn) for one in above]
        for joint in body.joints:
            place, turn = self._moved(joint, place, turn)
        self.poses.places.append(place)
        self.poses.turns.append(turn)

    def _moved(self, joint: SpatialJoint, place: Series, turn: Series) -> tuple[Series, Series]:
        """A frame moved by a joint; keeps where the joint's anchor and axes are."""
        at, axes, anchors = joint.coordinate, self.poses.axes, self.poses.anchors
        if joint.kind == "free":
            linear = [self.rates[k, joint.rate : joint.rate + 3] / (k + 1) for k in range(self.order)]
            place, turn = [self.q[at : at + 3], *linear], self._ball(at + 3, joint.rate + 3)
            anchors[joint.rate], axes[joint.rate] = place[0], turn[0]
            return place, turn
        anchor = added(place, turned(turn, joint.anchor))
        anchors[joint.rate] = anchor[0]
        if joint.kind == "ball":
            turn = product(turn, self._ball(at, joint.rate), self.order)
            axes[joint.rate] = turn[0]
            return added(anchor, turned(turn, -joint.anchor)), turn
        value = [self.q[at] - joint.reference, *(self.rates[k, joint.rate] / (k + 1) for k in range(self.order))]
        self.poses.scalars[joint.rate] = [self.q[at], *value[1:]]
        axis = turned(turn, joint.axis)
        axes[joint.rate] = axis[0][:, None]
        if joint.kind == "slide":
            return added(place, scaled(axis, value, self.order)), turn
        turn = product(turn, _hinged(joint.axis, value), self.order)
        return added(anchor, turned(turn, -joint.anchor)), turn

    def _ball(self, at: int, rate: int) -> Series:
        """The turn of a quaternion, with its derivatives by rates in the turned frame."""
        made = [turn_of(self.q[at : at + 4] / np.linalg.norm(self.q[at : at + 4], axis=0))]
        spins = [cross_matrix(one) for one in self.rates[:, rate : rate + 3]]
        for k in range(self.order):
            terms = [_times(made[i], spins[k - i]) for i in range(k + 1)]
            made.append(sum(terms[1:], terms[0]) / (k + 1))
        return made


def _hinged(axis: Array, angle: Series) -> Series:
    """Turns about an axis (3,) by a series of angles (Rodrigues' formula)."""
    skew = cross_matrix(axis)
    sine, cosine = (one.coefficients for one in sine_cosine(Jet(angle)))
    made = [skew[:, :, None] * s - (skew @ skew)[:, :, None] * c for s, c in zip(sine, cosine, strict=True)]
    made[0] = made[0] + (np.eye(3) + skew @ skew)[:, :, None]
    return made
