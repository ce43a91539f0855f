"""A pose that is outside the joints' ranges, as reference poses often are, and the nearest closed pose inside them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialJoint, SpatialTree, displace
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.exact.space.mobility import free_directions, null_space
from conrod.exact.space.motion import DrivenTree

RANDOM_POSES = 60  # poses at random inside the ranges, where the start moved into them leads to no closed pose inside
RANGE_TOLERANCE = 1e-9  # [rad or m], by which a joint may be beyond its range: rounding
MAX_STEPS_NEARER = 60
STEP_NEARER = 1e-9  # of the extent: a step that is no longer is the last


def joints_outside(tree: SpatialTree, coordinates: Array) -> Iterator[SpatialJoint]:
    """Joints of loops whose coordinates (nq,) are outside their ranges."""
    for joint in tree.loop_joints:
        if joint.range is not None and joint.kind in ("hinge", "slide"):
            low, high = joint.range
            if not low - RANGE_TOLERANCE <= coordinates[joint.coordinate] <= high + RANGE_TOLERANCE:
                yield joint


def outside_words(tree: SpatialTree, pose: str) -> str:
    """Describe joints that start outside their ranges; empty if the start is inside all ranges.

    Args:
        pose: pose that the machine is assembled from, in words.
    """
    said = []
    for joint in joints_outside(tree, tree.start):
        factor, unit = (float(np.degrees(1.0)), "deg") if joint.unit == "rad" else (1.0, "m")
        low, high = (factor * end for end in joint.range or ())
        value = factor * float(tree.start[joint.coordinate])
        said.append(f"{joint.name} at {value:.4g} {unit}, outside its range {low:.4g} to {high:.4g} {unit}")
    return f"{pose} has {', '.join(said)}" if said else ""


def is_folded(machine: DrivenTree, inside: Array) -> bool:
    """True if the closures have a lower rank in the start pose than in a closed pose (nq, 1) inside the ranges."""

    def rank(coordinates: Array) -> int:
        values = np.linalg.svd(machine.scaled_jacobian(forward_kinematics(machine.tree, coordinates)), compute_uv=False)
        return int(np.sum(values > RANK_TOLERANCE * values[0]))

    return rank(machine.tree.start[:, None]) < rank(inside)


def closed_pose_inside(machine: DrivenTree) -> Array | None:
    """The closed pose (nq, 1) at time 0 nearest the start with loop joints in their ranges; None if impossible."""
    tree, random, found = machine.tree, np.random.default_rng(1), list[Array]()
    clamped = tree.start[:, None].copy()
    for joint in joints_outside(tree, tree.start):
        clamped[joint.coordinate] = np.clip(clamped[joint.coordinate], *joint.range or ())
    for k in range(RANDOM_POSES):
        guess = clamped.copy()
        for joint in tree.loop_joints if k else ():
            if joint.kind in ("hinge", "slide"):
                turn = np.pi if joint.kind == "hinge" else 0.0
                around = float(clamped[joint.coordinate, 0])
                guess[joint.coordinate] = random.uniform(*(joint.range or (around - turn, around + turn)))
        try:
            pose = machine.close_loops(guess, 0.0)[0]
        except InvalidInput:
            continue
        if next(joints_outside(tree, pose[:, 0]), None) is None:
            found.append(pose)
            if k == 0:
                break
    if not found:
        return None
    return nearest_pose(machine, min(found, key=lambda pose: _distance(machine, pose, clamped)), clamped)


def _distance(machine: DrivenTree, pose: Array, other: Array) -> float:
    """Distance [m] of two poses (nq, 1): the root of the sum of squares of their coordinates' displacements."""
    return float(np.linalg.norm(machine.coordinate_sizes * (pose - other)))


def nearest_pose(machine: DrivenTree, pose: Array, wanted: Array) -> Array:
    """Move a closed pose (nq, 1) inside its ranges as near a wanted pose as loops and ranges allow.

    Each step is the difference from the wanted pose, projected on the motions that the closures allow; a joint that
    comes to an end of its range stays there (Rosen's gradient projection method).
    """
    tree, stopped = machine.tree, list[SpatialJoint]()
    limited = [one for one in tree.loop_joints if one.range is not None and one.kind in ("hinge", "slide")]
    for _ in range(MAX_STEPS_NEARER):
        step, share = _step_towards(machine, pose, wanted, stopped), 1.0
        end: SpatialJoint | None = None
        for joint in limited:
            value, move = float(pose[joint.coordinate, 0]), float(step[joint.rate, 0])
            low, high = joint.range or (0.0, 0.0)
            room = max(high - value if move > 0.0 else value - low, 0.0)
            if joint not in stopped and abs(move) * share > room:
                share, end = room / abs(move), joint
        while share > STEP_NEARER:
            try:
                moved = machine.close_loops(displace(tree, pose, share * step), 0.0)[0]
            except InvalidInput:
                moved = pose
            nearer = _distance(machine, moved, wanted) < _distance(machine, pose, wanted)
            if nearer and next(joints_outside(tree, moved[:, 0]), None) is None:
                pose = moved
                break
            share *= 0.5
        if end is not None:
            stopped.append(end)
        elif np.abs(machine.rate_sizes[:, None] * share * step).max(initial=0.0) <= STEP_NEARER * tree.extent:
            break
    return pose


def _step_towards(machine: DrivenTree, pose: Array, wanted: Array, stopped: list[SpatialJoint]) -> Array:
    """Step (nv, 1) from a closed pose towards another (nq, 1) that closures allow, without the stopped joints."""
    difference = np.zeros(machine.tree.freedom)
    for joint in machine.tree.joints:
        if joint.kind in ("hinge", "slide"):
            difference[joint.rate] = (wanted - pose)[joint.coordinate, 0]
    basis = free_directions(machine, pose)
    basis = basis @ null_space(basis[np.isin(machine.free, [joint.rate for joint in stopped])])
    step = np.zeros((machine.tree.freedom, 1))
    step[machine.free, 0] = machine.weights * (basis @ (basis.T @ (machine.rate_sizes * difference)[machine.free]))
    return step
