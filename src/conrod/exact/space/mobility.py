"""Mobility of a closed machine in space from the rank of its closures' Jacobian, and its forces along the exact motion.

The rank gives the freedoms that closures take, redundant closures, and what the drives determine. Driving torques and
closure reactions follow from the Newton-Euler equations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialPoint, SpatialTree
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.exact.space.forward_kinematics import Poses, Series, forward_kinematics
from conrod.exact.space.loop_closure import antisymmetric, jacobian, point_jacobian
from conrod.exact.space.motion import DrivenTree, SpatialMotion

MIN_MOTION = 1e-6  # velocity of a point that a freedom moves, over its largest
POSES_EXAMINED = 7  # along the motion
MIN_REACTION_SHARE = 1e-6  # of a reaction component that is indeterminate


@dataclass(frozen=True)
class Mobility:
    """Degrees of freedom of a machine, from ranks at a closed pose and along the motion.

    Attributes:
        freedom: degrees of freedom of all joints that are not held.
        rows, rank: scalar equations of the closures, and how many are independent.
        redundant: number of equations of each closure that the closures before it imply.
        undetermined: observed points that the drives do not determine.
        rigid: points that closures cannot move, because they are rigid with driven or held bodies.
        idle: joints that remaining freedoms move, such as a rod's spin about its axis.
        margin: smallest singular value within the rank over the largest, least along the motion.
        margin_time: time of the least margin [s].
    """

    freedom: int
    rows: int
    rank: int
    redundant: Mapping[str, int]
    undetermined: tuple[str, ...]
    idle: tuple[str, ...]
    margin: float
    margin_time: float
    rigid: tuple[str, ...] = ()

    @property
    def remaining_dof(self) -> int:
        """Degrees of freedom that the closures leave."""
        return self.freedom - self.rank


class TooManyDrivesError(InvalidInput):
    """Drives that the closures do not allow to move independently, or at all.

    Attributes:
        stuck: whether none of them can move the machine.
    """

    stuck = False


def check_drives(machine: DrivenTree, start: Array) -> None:
    """Refuse too few or too many drives for a closed pose (nq, 1).

    Raises:
        InvalidInput: names the drives that are missing or too many.
    """
    found = forward_kinematics(machine.tree, start)
    matrix, columns = _scaled_jacobian(machine, found)
    rank, left = numerical_rank(matrix), len(columns) - numerical_rank(matrix)
    names, driven = list(machine.laws), len(machine.laws)
    loops = f"its closures take {rank} of {len(columns)} degrees of freedom"
    if over := rank - numerical_rank(matrix[:, driven:]):
        can = f"give {driven - over} of {', '.join(names)}" if driven > over else "it cannot move"
        much = f"{over} of its {driven} drives {'is' if over == 1 else 'are'} too many"
        error = TooManyDrivesError(f"{loops}, which leaves {left}; {much}: {can}")
        error.stuck = driven <= over
        raise error
    left_free = null_space(matrix[:, driven:])
    number, missing = drives_to_add(machine, found, left_free) if left_free.shape[1] else (0, [])
    if not number:
        return
    others = [name for name in machine.most_moved_joints(left_free) if name not in missing][:3]
    instead = f", or in their place {', '.join(others)}" if others else ""
    hold = f"drive {number} more, or hold them (JOINT=hold): {', '.join(missing)}{instead}"
    idle = f", {left_free.shape[1] - number} of them idle" if left_free.shape[1] > number else ""
    raise InvalidInput(
        f"{loops}, which leaves {left}{idle}, and {driven} {'is' if driven == 1 else 'are'} driven: "
        f"{hold if missing else f'{others[0]} moves, and no law drives it'}; at a dead centre start from another pose"
    )


def drives_to_add(
    machine: DrivenTree, found: Poses, free_directions: Array, preferred: Sequence[str] = ()
) -> tuple[int, list[str]]:
    """Count free directions (free, k) that move joints or pins of the loops; choose joints that would hold them.

    Other directions, such as a rod's spin about its axis, are idle; where no pin moves, as in Cardan's joint, those
    that turn what a weld holds are not. Joints with springs come first, as they have a rest.

    Args:
        preferred: names of joints that come before, in this order.
    """
    tree = machine.tree
    pins = [point for closure in tree.closures for point in closure.points]
    pins += [SpatialPoint(joint.body, joint.anchor) for joint in tree.loop_joints if joint.kind != "free"]
    moved = [_point_velocity(machine, found, pin, free_directions) for pin in pins]
    moved += [free_directions[machine.free == rate] for closure in tree.closures for s in closure.sums for rate in s]
    values, directions = np.linalg.svd(np.concatenate(moved))[1:]
    if values.max(initial=0.0) <= MIN_MOTION and (turned := list(_points_beside_welds(tree))):
        moved = [_point_velocity(machine, found, point, free_directions) for point in turned]
        values, directions = np.linalg.svd(np.concatenate(moved))[1:]
    seen = free_directions @ directions[: int(np.sum(values > MIN_MOTION))].T
    chosen, rows = list[str](), seen[:0]
    places = {name: place for place, name in enumerate(preferred)}
    joints = [joint for joint in tree.joints if joint.kind in ("hinge", "slide")]
    for joint in sorted(joints, key=lambda j: (places.get(j.name, len(places)), not j.stiffness)):
        more = np.concatenate([rows, seen[machine.free == joint.rate]])
        if more.size and np.linalg.matrix_rank(more, MIN_MOTION) > len(rows):
            rows, chosen = more, [*chosen, joint.name]
    return seen.shape[1], chosen


def _points_beside_welds(tree: SpatialTree) -> Iterator[SpatialPoint]:
    """Yield points of welded bodies, an extent beside the weld: whatever turns these bodies moves one of them."""
    for closure in tree.closures:
        for point in closure.points if closure.kind == "weld" else ():
            yield from (SpatialPoint(point.body, point.offset + tree.extent * axis) for axis in np.eye(3))


def count_mobility(machine: DrivenTree) -> Mobility:
    """Count the degrees of freedom of a machine along its tracked motion."""
    start = machine.knots[0]
    matrix, columns = _scaled_jacobian(machine, forward_kinematics(machine.tree, start.coordinates))
    redundant, before = {}, 0
    for name, rows in machine.tree.rows.items():
        after = numerical_rank(matrix[: rows.stop])
        if spare := rows.stop - rows.start - (after - before):
            redundant[name] = spare
        before = after
    undetermined, idle = dict[str, None](), dict[str, None]()
    for k in _examined_knots(machine):
        left_free, found = (
            free_directions(machine, machine.knots[k].coordinates),
            forward_kinematics(machine.tree, machine.knots[k].coordinates),
        )
        idle |= dict.fromkeys(machine.most_moved_joints(left_free)) if left_free.shape[1] else {}
        for name, point in machine.tree.points.items() if left_free.shape[1] else ():
            if np.abs(_point_velocity(machine, found, point, left_free)).max() > MIN_MOTION:
                undetermined[name] = None
    rank = start.rows.shape[1]
    margins = [knot.values[rank - 1] / knot.values[0] if rank else 1.0 for knot in machine.knots]
    least = int(np.argmin(margins))
    return Mobility(
        len(columns), len(matrix), before, redundant, tuple(undetermined), tuple(idle), float(margins[least]),
        machine.knots[least].time, rigid_points(machine, machine.tree.points),
    )  # fmt: skip


def rigid_points(machine: DrivenTree, points: Mapping[str, SpatialPoint]) -> tuple[str, ...]:
    """Names of points that no loop can move, because they are rigid with driven or held bodies."""
    directions, looked_at = np.eye(len(machine.free)), _examined_knots(machine)
    every = [forward_kinematics(machine.tree, machine.knots[k].coordinates) for k in looked_at]

    def is_moved(point: SpatialPoint) -> bool:
        return any(
            np.abs(_point_velocity(machine, found, point, directions)).max(initial=0.0) > MIN_MOTION for found in every
        )

    return tuple(name for name, point in points.items() if not is_moved(point))


def _examined_knots(machine: DrivenTree) -> list[int]:
    """Indices of a few knots of the motion, evenly spread."""
    return [int(k) for k in dict.fromkeys(np.linspace(0, len(machine.knots) - 1, POSES_EXAMINED).round())]


def _scaled_jacobian(machine: DrivenTree, found: Poses) -> tuple[Array, list[int]]:
    """Jacobian (rows, columns) of the closures by the joint rates, and each column's joint rate.

    The driven joints' columns come first, then the free rates'. Rotations are weighed by the machine's extent [m].
    """
    columns = [*(joint.rate for joint in machine.driven), *machine.free.tolist()]
    weights = [1.0 / machine.tree.extent if joint.unit == "rad" else 1.0 for joint in machine.driven]
    return jacobian(found, 1)[0][:, columns] * np.array([*weights, *machine.weights]), columns


def numerical_rank(matrix: Array) -> int:
    """Numerical rank of a matrix: singular values above `RANK_TOLERANCE` times the largest."""
    values = np.linalg.svd(matrix, compute_uv=False) if matrix.size else np.zeros(1)
    return int(np.sum(values > RANK_TOLERANCE * values[0]))


def free_directions(machine: DrivenTree, coordinates: Array) -> Array:
    """Basis (free, k) of the motions that closures allow at a pose (nq, 1) with its drives held."""
    return null_space(machine.scaled_jacobian(forward_kinematics(machine.tree, coordinates)))


def null_space(matrix: Array) -> Array:
    """Basis of a matrix's null space, as columns."""
    if not matrix.size:
        return np.eye(matrix.shape[1])
    return np.asarray(np.linalg.svd(matrix)[2][numerical_rank(matrix) :].T)


def _point_velocity(machine: DrivenTree, found: Poses, point: SpatialPoint, free_directions: Array) -> Array:
    """Velocity (3, k) of a point in directions (free, k)."""
    displacement = np.zeros((machine.tree.freedom, free_directions.shape[1]))
    displacement[machine.free] = machine.weights[:, None] * free_directions
    linear, _ = point_jacobian(found, point)
    return sum(
        (np.einsum("int,nk->ik", block, displacement[rates]) for rates, block in linear),
        np.zeros((3, free_directions.shape[1])),
    )


# -- forces ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class SpatialForces:
    """Driving forces and closure reactions at T times.

    Attributes:
        drives: torque or force of each driven joint (T,) [N m or N].
        reactions: force (T, 3) [N] of each connect and weld on its first body, in the ground's directions; nan in
            components that redundant closures leave indeterminate.
        least: the reactions with the smallest norm, where they are indeterminate.
    """

    drives: Mapping[str, Array]
    reactions: Mapping[str, Array]
    least: Mapping[str, Array]

    @property
    def indeterminate(self) -> tuple[str, ...]:
        """Closures whose reaction, or a component of it, redundant closures leave indeterminate."""
        return tuple(name for name, force in self.reactions.items() if np.isnan(force).any())


def forces(machine: DrivenTree, motion: SpatialMotion) -> SpatialForces:
    """Compute driving forces and closure reactions of a machine along its exact motion.

    With the joints' equations tau = J' f + drives, the closures' forces f are the shortest solution of those rows that
    are not driven (Penrose, Proc. Cambridge Phil. Soc. 52, 1956).
    """
    tree, samples = machine.tree, len(motion.times)
    found = forward_kinematics(tree, motion.coordinates, motion.rates[:2])
    needed = required_forces(found, motion)
    matrix = jacobian(found, samples)
    transposed = np.swapaxes(matrix[:, :, machine.free] * machine.weights, 1, 2)
    inverse = np.linalg.pinv(transposed, rcond=RANK_TOLERANCE)
    carried = np.einsum("tmf,ft->tm", inverse, machine.weights[:, None] * needed[machine.free])
    open_rows = np.eye(matrix.shape[1]) - inverse @ transposed
    left = needed - np.einsum("tmn,tm->nt", matrix, carried)
    begins = {closure.name: tree.rows[closure.name].start for closure in tree.closures if closure.points}
    known = np.where(np.abs(open_rows).max(axis=(0, 2)) > MIN_REACTION_SHARE, np.nan, carried)
    return SpatialForces(
        {joint.name: left[joint.rate] for joint in machine.driven},
        {name: known[:, row : row + 3] for name, row in begins.items()},
        {name: carried[:, row : row + 3] for name, row in begins.items()},
    )


def required_forces(found: Poses, motion: SpatialMotion) -> Array:
    """Joint forces (nv, T) of inertia and weight, and of the joints' springs, dampers and armatures."""
    tree, samples = found.tree, len(motion.times)
    needed = np.zeros((tree.freedom, samples))
    for joint in tree.joints:
        needed[joint.rates] += joint.armature * motion.rates[1, joint.rates]
        needed[joint.rates] += joint.damping * motion.rates[0, joint.rates]
        if joint.kind in ("hinge", "slide"):
            needed[joint.rate] += joint.stiffness * (motion.coordinates[joint.coordinate] - joint.spring)
    for number, body in enumerate(tree.bodies):
        if number == 0 or not tree.joints_above[number] or not (body.mass or np.any(body.inertia)):
            continue
        force, torque = _inertia_wrench(found, number, body)
        linear, angular = point_jacobian(found, SpatialPoint(number, body.centre))
        for rates, block in linear:
            needed[rates] += np.einsum("int,it->nt", block, force - body.mass * tree.gravity[:, None])
        for rates, block in angular:
            needed[rates] += np.einsum("int,it->nt", block, torque)
    return needed


def _inertia_wrench(found: Poses, number: int, body: SpatialBody) -> tuple[Array, Array]:
    """Force (3, T) and torque about the centre of gravity (3, T) that accelerate a body."""
    turn, centre = found.turns[number], found.point(SpatialPoint(number, body.centre))
    spin, gain = _angular_velocity(turn, 1), _angular_velocity(turn, 2)
    inertia = np.einsum("ijt,jk,lkt->ilt", turn[0], body.inertia, turn[0])
    momentum = np.einsum("ijt,jt->it", inertia, spin)
    acceleration = 2.0 * centre[2] if len(centre) > 2 else np.zeros_like(centre[0])
    return body.mass * acceleration, np.einsum("ijt,jt->it", inertia, gain) + np.cross(spin, momentum, axis=0)


def _angular_velocity(turn: Series, order: int) -> Array:
    """Angular velocity (3, T) of a rotation for order 1, acceleration for 2: antisymmetric part of R^(k) R'."""
    if len(turn) <= order:
        return np.zeros((3, turn[0].shape[2]))
    matrix = order * np.einsum("ijt,kjt->ikt", turn[order], turn[0])
    return antisymmetric(matrix)
