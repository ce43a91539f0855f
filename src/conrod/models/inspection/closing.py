"""Does it close? How far each loop is open in each pose, and where it would be closed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialTree, displace
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.exact.space.mobility import free_directions
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.anchors import parts_apart
from conrod.mjcf.equalities import closure_name, constraint_violations, handle_indices, handle_words, inactive_words
from conrod.mjcf.loading import OWN_POSE, data_at_start, names_of, names_or_numbers, start_words
from conrod.mjcf.reading import tree_of
from conrod.mjcf.start import open_start, pose_words
from conrod.mjcf.unit_of_length import coordinate_powers
from conrod.models.inspection.results import Closing, PoseOpening
from conrod.models.loops.ranges import closed_pose_inside, is_folded, outside_words

MAX_KEYFRAMES = 20  # that are looked at; simulations save hundreds of them
NUDGE = 0.05  # [rad, or m over the extent]: how far beside a pose it is looked whether the closures allow less there


def examine_closing(model: mujoco.MjModel, keyframe: str | None, unit: float = 1.0) -> Closing:
    """Measure how far the loops are open where the file starts, in its reference pose and in each keyframe.

    Args:
        unit: unit of the file's lengths [m], in which poses are written.
    """
    start = data_at_start(model, keyframe)[1]
    numbers = dict.fromkeys((start, None, *range(min(model.nkey, MAX_KEYFRAMES))))
    tree = tree_at(model, model.qpos0)
    extent = float(model.stat.extent) if tree is None or not tree.closures else tree.extent
    apart = list(parts_apart(model))
    remarks = (inactive_words(model), handle_words(model, handle_indices(model)))
    return Closing(
        extent,
        tuple(_pose_opening(model, number, extent, unit, is_start=number == start) for number in numbers),
        (*filter(None, remarks), *(f"{one.words}: {one.cure}" for one in apart)),
        bool(apart),
    )


def tree_at(model: mujoco.MjModel, pose: Array) -> SpatialTree | None:
    """Spatial tree of a model in a pose (nq,), without mouse handles; None if it has no such tree.

    A weld to a mocap body drags a part after the mouse, and is no loop that a pose has to close.
    """
    try:
        tree = tree_of(model, pose)
    except InvalidInput:
        return None
    handles = {closure_name(model, k) for k in handle_indices(model)}
    return replace(tree, closures=tuple(one for one in tree.closures if one.name not in handles))


def _pose_opening(
    model: mujoco.MjModel, keyframe: int | None, extent: float, unit: float, *, is_start: bool
) -> PoseOpening:
    """Measure the closures' opening in a keyframe, or in the reference pose."""
    name = OWN_POSE if keyframe is None else names_or_numbers(names_of(model, "key"))[keyframe]
    data, _ = data_at_start(model, name)
    words = start_words(model, keyframe)
    with silence_warnings():
        mujoco.mj_fwdPosition(model, data)
    found, dragged = constraint_violations(model, data, extent), handle_indices(model)
    acting = [k for k in range(model.neq) if data.eq_active[k] and k not in dragged]
    gaps = {closure_name(model, k): float(found[k]) for k in acting}
    ajar, scale = open_start(model, data, extent, words), unit ** -coordinate_powers(model)
    closed = "" if ajar is None or not ajar.closed else pose_words(scale * np.array(ajar.closed.split(), dtype=float))
    tree = tree_at(model, np.array(data.qpos))
    if tree is None or not tree.closures:
        return PoseOpening(words, gaps, closed)
    outside, inside = outside_words(tree, words), None
    machine = DrivenTree(tree, {})
    if outside and is_start:
        inside = closed_pose_inside(machine)
    return PoseOpening(
        words,
        gaps,
        closed,
        outside,
        "" if inside is None else pose_words(scale * inside[:, 0]),
        is_start and (is_singular(machine, tree.start[:, None]) if inside is None else is_folded(machine, inside)),
    )


def is_singular(machine: DrivenTree, pose: Array) -> bool:
    """True if the closures' Jacobian has a lower rank in a closed pose (nq, 1) than near it."""
    here = closure_rank(machine, pose)
    return any(closure_rank(machine, beside) > here for beside in _nearby_poses(machine, pose))


def closure_rank(machine: DrivenTree, coordinates: Array) -> int:
    """Rank of the closures' scaled Jacobian in a pose (nq, 1)."""
    matrix = machine.scaled_jacobian(forward_kinematics(machine.tree, coordinates))
    values = np.linalg.svd(matrix, compute_uv=False)
    return int(np.sum(values > RANK_TOLERANCE * values[0])) if values.size else 0


def _nearby_poses(machine: DrivenTree, pose: Array) -> Iterator[Array]:
    """Yield closed poses (nq, 1) near a closed pose, along some motions that the closures allow."""
    directions = free_directions(machine, pose)
    for direction in directions.T[:6]:
        step = np.zeros((machine.tree.freedom, 1))
        step[machine.free, 0] = machine.weights * direction * NUDGE * machine.tree.extent
        try:
            yield machine.close_loops(displace(machine.tree, pose, step), 0.0)[0]
        except InvalidInput:
            continue
