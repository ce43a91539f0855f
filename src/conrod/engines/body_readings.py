"""What is read from bodies in maximal coordinates: motion of points, and how far joints are open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.engines.space import SpatialStart
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialTree
from conrod.exact.space.forward_kinematics import rotation_matrices


@dataclass(frozen=True, eq=False)
class BodyReadings:
    """An engine's bodies after a step, in single precision; a body's number is one less than in the tree.

    Attributes:
        poses: (B, 7) place of the frame and quaternion x, y, z, w.
        rates: (B, 6) velocity of the centre of gravity and angular velocity, in the world.
        accelerations: (B, 6) likewise, of the state before the step; None where the solver has none.
    """

    poses: Array
    rates: Array
    accelerations: Array | None


def body_frames(poses: Array) -> tuple[Array, Array]:
    """Places (3, T) [m] and rotations (3, 3, T) of a body's poses (T, 7)."""
    quaternions = poses[:, [6, 3, 4, 5]].T
    return poses[:, :3].T, rotation_matrices(quaternions / np.linalg.norm(quaternions, axis=0))


def motion_of_points(
    start: SpatialStart, read: Mapping[int, BodyReadings], samples: Sequence[int], own: bool
) -> dict[str, Array]:
    """Position, velocity and acceleration (3, T, 3) of the observed points.

    Args:
        read: readings by the number of the step: of each sample, and of its neighbours.
        samples: numbers of the steps of the samples.
        own: whether accelerations are the engine's own, or differences of velocities.
    """
    velocities = {k: _positions_and_velocities(start, read, [max(0, n + k) for n in samples]) for k in (-1, 0, 1)}
    found = dict[str, Array]()
    for name, point in start.points.items():
        place, velocity = velocities[0][name]
        if point.body == 0:
            acceleration = np.zeros_like(place)
        elif own:
            acceleration = _own_accelerations(start, read, samples, name)
        else:
            acceleration = (velocities[1][name][1] - velocities[-1][name][1]) / (2.0 * start.step)
            if samples and samples[0] == 0 and 2 in read:
                # To the same order at the start, where there is nothing before.
                first, second = (_positions_and_velocities(start, read, [k])[name][1][0] for k in (1, 2))
                acceleration[0] = (4.0 * first - second - 3.0 * velocity[0]) / (2.0 * start.step)
        found[name] = np.array([place, velocity, acceleration])
    return found


def _positions_and_velocities(
    start: SpatialStart, read: Mapping[int, BodyReadings], samples: Sequence[int]
) -> dict[str, tuple[Array, Array]]:
    """Positions and velocities (T, 3) of the observed points at some steps."""
    found = dict[str, tuple[Array, Array]]()
    for name, point in start.points.items():
        if point.body == 0:
            found[name] = (np.tile(point.offset, (len(samples), 1)), np.zeros((len(samples), 3)))
            continue
        place, arm, rates = _arms(start, read, samples, name)
        found[name] = (place, rates[:, :3] + np.cross(rates[:, 3:], arm))
    return found


def _arms(
    start: SpatialStart, read: Mapping[int, BodyReadings], samples: Sequence[int], name: str
) -> tuple[Array, Array, Array]:
    """Positions (T, 3) of a point, arms (T, 3) to it from its body's centre of gravity, and the body's rates (T, 6)."""
    if not samples:  # a run that breaks off at once
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 6))
    point = start.points[name]
    poses, rates = (
        np.array([getattr(read[k], kind)[point.body - 1] for k in samples], dtype=float) for kind in ("poses", "rates")
    )
    origin, turn = body_frames(poses)
    centre = start.tree.bodies[point.body].centre
    place = origin + np.einsum("ijt,j->it", turn, point.offset)
    return place.T, np.einsum("ijt,j->it", turn, point.offset - centre).T, rates


def _own_accelerations(
    start: SpatialStart, read: Mapping[int, BodyReadings], samples: Sequence[int], name: str
) -> Array:
    """Accelerations (T, 3) of a point by the engine's own of its body; a step reports those of the state before it."""
    _, arm, rates = _arms(start, read, samples, name)
    body = start.points[name].body - 1
    given = [read[k + 1].accelerations for k in samples]
    own = np.array([one[body] for one in given if one is not None], dtype=float).reshape(-1, 6)
    spin = rates[:, 3:]
    return np.asarray(own[:, :3] + np.cross(own[:, 3:], arm) + np.cross(spin, np.cross(spin, arm)))


def joint_openings(tree: SpatialTree, read: BodyReadings) -> dict[str, float]:
    """How far each joint of the tree is open [m], which it can be in maximal coordinates.

    Ends of arms as long as the tree's extent are compared, too: along the axis of a hinge, and all three of a slide.
    """
    places, turns = body_frames(np.asarray(read.poses, dtype=float))
    found = dict[str, float]()
    for number, body in enumerate(tree.bodies[1:]):
        arms = np.vstack([np.zeros((1, 3)), tree.extent * _held_directions(body)])
        near = body.joints[0].anchor + arms
        far = body.place + near @ body.turn.T
        if body.parent:
            above = body.parent - 1
            far = places[:, above] + far @ turns[:, :, above].T
        gaps = places[:, number] + near @ turns[:, :, number].T - far
        for joint in body.joints:
            if joint.kind == "slide":
                axis = body.turn @ joint.axis
                axis = turns[:, :, body.parent - 1] @ axis if body.parent else axis
                gaps = gaps - np.outer(gaps @ axis, axis)
        found[body.joints[0].name] = float(np.linalg.norm(gaps, axis=1).max())
    return found


def _held_directions(body: SpatialBody) -> Array:
    """Directions (N, 3) in a body's frame that its only joint keeps as they are in the parent's."""
    if len(body.joints) > 1 or body.joints[0].kind == "ball":
        return np.zeros((0, 3))
    return np.eye(3) if body.joints[0].kind == "slide" else body.joints[0].axis[None]
