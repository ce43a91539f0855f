"""A pose that is outside the joints' ranges, as reference poses often are, and the nearest closed pose inside them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialJoint, SpatialTree
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.exact.space.motion import DrivenTree

RANDOM_POSES = 60  # poses at random inside the ranges, where the start moved into them leads to no closed pose inside
RANGE_TOLERANCE = 1e-9  # [rad or m], by which a joint may be beyond its range: rounding


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
    return min(found, key=lambda pose: float(np.abs(machine.coordinate_sizes * (pose - clamped)).max()), default=None)
