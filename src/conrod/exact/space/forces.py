"""Driving torques and reactions at the closures of a machine in space, from its exact motion (Newton and Euler)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.exact.space.closing import antisymmetric, jacobian, point_jacobian
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.exact.space.poses import Poses, Series, poses
from conrod.exact.space.tree import SpatialBody, SpatialPoint

SEEN = 1e-6  # of a reaction: below this share of it, none of it is open


@dataclass(frozen=True, eq=False)
class SpatialForces:
    """Forces at T times.

    Attributes:
        drives: torque or force of each driven joint (T,) [N m or N].
        reactions: of each connect and weld: force (T, 3) [N], seen from the ground, on its first body; components that
            redundant closures leave open are not numbers.
        least: the same, the least of those possible where they are open.
    """

    drives: Mapping[str, Array]
    reactions: Mapping[str, Array]
    least: Mapping[str, Array]

    @property
    def ambiguous(self) -> tuple[str, ...]:
        """Closures whose reaction redundant ones leave open, or a component of it."""
        return tuple(name for name, force in self.reactions.items() if np.isnan(force).any())


def forces(machine: DrivenTree, motion: SpatialMotion) -> SpatialForces:
    """Driving forces of a machine along its exact motion, and those that its closures carry.

    With the joints' equations tau = J' f + drives, the closures' forces f are the shortest solution of those rows that
    are not driven (Penrose, Proc. Cambridge Phil. Soc. 52, 1956).
    """
    tree, samples = machine.tree, len(motion.times)
    found = poses(tree, motion.coordinates, motion.rates[:2])
    needed = needed_forces(found, motion)
    matrix = jacobian(found, samples)
    transposed = np.swapaxes(matrix[:, :, machine.free] * machine.weights, 1, 2)
    inverse = np.linalg.pinv(transposed, rcond=RANK_TOLERANCE)
    carried = np.einsum("tmf,ft->tm", inverse, machine.weights[:, None] * needed[machine.free])
    open_rows = np.eye(matrix.shape[1]) - inverse @ transposed
    left = needed - np.einsum("tmn,tm->nt", matrix, carried)
    begins = {closure.name: tree.rows[closure.name].start for closure in tree.closures if closure.points}
    known = np.where(np.abs(open_rows).max(axis=(0, 2)) > SEEN, np.nan, carried)
    return SpatialForces(
        {joint.name: left[joint.rate] for joint in machine.driven},
        {name: known[:, row : row + 3] for name, row in begins.items()},
        {name: carried[:, row : row + 3] for name, row in begins.items()},
    )


def needed_forces(found: Poses, motion: SpatialMotion) -> Array:
    """Along all joints (nv, T), of inertia and weight and the joints' springs, dampers and armatures."""
    tree, samples = found.tree, len(motion.times)
    needed = np.zeros((tree.freedom, samples))
    for joint in tree.joints:
        needed[joint.rates] += joint.armature * motion.rates[1, joint.rates]
        needed[joint.rates] += joint.damping * motion.rates[0, joint.rates]
        if joint.kind in ("hinge", "slide"):
            needed[joint.rate] += joint.stiffness * (motion.coordinates[joint.coordinate] - joint.spring)
    for number, body in enumerate(tree.bodies):
        if number == 0 or not tree.above[number] or not (body.mass or np.any(body.inertia)):
            continue
        force, torque = _inertial(found, number, body)
        linear, angular = point_jacobian(found, SpatialPoint(number, body.centre))
        for rates, block in linear:
            needed[rates] += np.einsum("int,it->nt", block, force - body.mass * tree.gravity[:, None])
        for rates, block in angular:
            needed[rates] += np.einsum("int,it->nt", block, torque)
    return needed


def _inertial(found: Poses, number: int, body: SpatialBody) -> tuple[Array, Array]:
    """Force (3, T) and torque about the centre of gravity (3, T) that accelerate a body."""
    turn, centre = found.turns[number], found.point(SpatialPoint(number, body.centre))
    spin, gain = _spin(turn, 1), _spin(turn, 2)
    inertia = np.einsum("ijt,jk,lkt->ilt", turn[0], body.inertia, turn[0])
    momentum = np.einsum("ijt,jt->it", inertia, spin)
    acceleration = 2.0 * centre[2] if len(centre) > 2 else np.zeros_like(centre[0])
    return body.mass * acceleration, np.einsum("ijt,jt->it", inertia, gain) + np.cross(spin, momentum, axis=0)


def _spin(turn: Series, order: int) -> Array:
    """Angular velocity (3, T) of a turn for order 1, acceleration for 2: the antisymmetric part of R^(k) R'."""
    if len(turn) <= order:
        return np.zeros((3, turn[0].shape[2]))
    matrix = order * np.einsum("ijt,kjt->ikt", turn[order], turn[0])
    return antisymmetric(matrix)
