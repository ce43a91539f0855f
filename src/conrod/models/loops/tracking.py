"""The motion of a machine by its drives, tracked from its start, or from a pose inside its joints' ranges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import QUANTITIES, Array, PointMotion
from conrod.exact.space.immobility import describe_corrections, explain_immobility, removable_words
from conrod.exact.space.link_points import telling_points, with_telling_points
from conrod.exact.space.mobility import Mobility, TooManyDrivesError, check_drives, count_mobility
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.loading import FoundPoint
from conrod.mjcf.loop_results import LoopRequest
from conrod.mjcf.reading import judged_points
from conrod.mjcf.start import pose_words
from conrod.models.loops.ranges import closed_pose_inside, is_folded, joints_outside, outside_words

MAX_SEARCHED_JOINTS = 14  # of loops, up to which it is tried for each whether it is off


def _check_drives(machine: DrivenTree, start: Array, explained: bool) -> None:
    """Refuse too few or too many drives at a closed pose (nq, 1), and name the axis that blocks motion.

    Args:
        explained: whether differences of the model are known already; then no blocking axis is searched for.
    """
    try:
        check_drives(machine, start)
    except TooManyDrivesError as error:
        if explained:
            raise
        searched = len(machine.tree.loop_joints) <= MAX_SEARCHED_JOINTS
        spare = removable_words(machine, start)
        found = explain_immobility(machine.tree, machine.laws, machine.held, start) if searched and not spare else []
        # Where some of the drives can stay they are simply too many.
        words = f"; {describe_corrections(found)}" if found or (searched and error.stuck) else ""
        raise InvalidInput(f"{error}{spare or words}") from None


def track_motion(machine: DrivenTree, seconds: float, pose: str, explained: bool) -> str:
    """Assemble a machine and track its motion; if its start is outside joint ranges, perhaps from inside.

    Args:
        pose: pose that the machine is assembled from, in words.
        explained: see `_check_drives`.

    Returns:
        Why it was assembled from another pose; empty where it was not.

    Raises:
        InvalidInput: the drives are too few or too many, or the loops block their motion.
    """
    outside, refused = outside_words(machine.tree, pose), None
    try:
        start = machine.assemble_start()
        _check_drives(machine, start, explained)
        machine.track_branch(start, seconds)
    except InvalidInput as error:
        refused = error
    stays_outside = refused is None and any(joints_outside(machine.tree, machine.knots[0].coordinates[:, 0]))
    if not outside or not (refused or stays_outside):
        if refused:
            raise refused
        return ""
    knots, misfit = machine.knots, machine.misfit
    try:
        return f"{outside}{_track_from_inside(machine, seconds, explained)}"
    except InvalidInput as error:
        if refused:
            raise InvalidInput(f"{refused}; {outside}, {error}") from None
    machine.knots, machine.misfit = knots, misfit
    return ""


def _track_from_inside(machine: DrivenTree, seconds: float, explained: bool) -> str:
    """Track a machine's motion from the closed pose inside its joints' ranges nearest to its start.

    Returns:
        The pose, in words.

    Raises:
        InvalidInput: no such pose exists, or the loops block the motion from it.
    """
    if (inside := closed_pose_inside(machine)) is None:
        raise InvalidInput("and no pose inside closes its loops")
    folded, nearest = ", and is folded" if is_folded(machine, inside) else "", f'qpos="{pose_words(inside[:, 0])}"'
    try:
        _check_drives(machine, inside, explained)
        machine.track_branch(inside, seconds)
    except InvalidInput as error:
        raise InvalidInput(f"and from {nearest}, the nearest pose inside, {error}; --keyframe for another") from None
    return f"{folded}: the motion starts from the nearest closed pose inside, {nearest} (--keyframe for another)"


def choose_points(
    model: mujoco.MjModel, machine: DrivenTree, question: LoopRequest
) -> tuple[Mobility, tuple[FoundPoint, ...]]:
    """Count the mobility of a tracked machine, and choose the points to judge.

    Where none that was chosen tells of the loops, and none was asked for, others do: bodies, or points of links, which
    the tree of the machine then has too.
    """
    freedom = count_mobility(machine)
    points = judged_points(model, machine.tree, freedom, question)
    if question.points or question.machine is not None:
        return freedom, points
    telling = telling_points(machine, freedom)
    if telling.intersection(point.name for point in points):
        return freedom, points
    machine.tree = with_telling_points(machine, telling)
    freedom = count_mobility(machine)
    return freedom, judged_points(model, machine.tree, freedom, question)


def moved_points(
    model: mujoco.MjModel, machine: DrivenTree, freedom: Mobility, question: LoopRequest
) -> tuple[str, ...]:
    """Names of points that loops move, if all requested points are rigid with driven or held bodies."""
    if not question.points or any(name not in freedom.rigid for name in question.points):
        return ()
    others = judged_points(model, machine.tree, freedom, replace(question, points=()))
    return tuple(one.name for one in others if one.name not in freedom.rigid)


def motion_scales(points: Sequence[PointMotion]) -> dict[str, float]:
    """Largest range of motion [m], speed and acceleration [SI] of points."""
    apart = (np.linalg.norm(p.position[:, None] - p.position[None], axis=2).max() for p in points)
    rates = {q: max(float(np.linalg.norm(getattr(p, q), axis=1).max()) for p in points) for q in QUANTITIES[1:]}
    return {QUANTITIES[0]: max(map(float, apart)), **rates}
