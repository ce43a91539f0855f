"""Coordinates of a machine in space, and movements by its joint rates."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from conrod.exact.motion import Array
from conrod.exact.space.tree import SpatialJoint, SpatialTree


def lengths(tree: SpatialTree, joint: SpatialJoint, numbers: Mapping[str, int]) -> Array:
    """For each of a joint's coordinates or rates: 1 of a length, the extent [m] of a turn."""
    straight = {"slide": 1, "free": 3}.get(joint.kind, 0)
    return np.array([1.0] * straight + [tree.extent] * (numbers[joint.kind] - straight))


def moved(tree: SpatialTree, coordinates: Array, way: Array) -> Array:
    """Coordinates (nq, T) after a movement (nv, T) of all joints, balls by the turn that it is in their own frame."""
    made = np.array(coordinates)
    for joint in tree.joints:
        q, v = joint.coordinate, joint.rate
        if joint.kind == "free":
            made[q : q + 3] += way[v : v + 3]
            q, v = q + 3, v + 3
        if joint.kind in ("free", "ball"):
            made[q : q + 4] = _turned_by(made[q : q + 4], way[v : v + 3])
        else:
            made[q] += way[v]
    return made


def _turned_by(quaternion: Array, way: Array) -> Array:
    """Unit quaternions (4, T) after turns by vectors (3, T) in their own frame."""
    angle = np.linalg.norm(way, axis=0)
    b, c = np.cos(0.5 * angle), 0.5 * np.sinc(angle / (2.0 * np.pi)) * way
    a, v = quaternion[0], quaternion[1:]
    made = np.concatenate([(a * b - (v * c).sum(axis=0))[None], a * c + b * v + np.cross(v, c, axis=0)])
    return np.asarray(made / np.linalg.norm(made, axis=0))
