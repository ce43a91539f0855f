"""A drive for a model of which none is given: which joint is driven, and by what law."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import mujoco
import numpy as np

from conrod.errors import InvalidInput, list_names
from conrod.exact.motion import Array
from conrod.exact.space import SpatialJoint, SpatialTree
from conrod.exact.space.drive_laws import DriveLaw, parse_drive_law
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.exact.space.mobility import check_drives, drives_to_add, free_directions
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.driven_runs import tendons_beyond_limits
from conrod.mjcf.equalities import closure_name, handle_indices
from conrod.mjcf.loading import OWN_POSE, name_or_number
from conrod.mjcf.reading import duration, tree_of
from conrod.models.inspection.results import UNEXPLAINED
from conrod.models.loops.ranges import joints_outside
from conrod.models.loops.tracking import track_motion

FULL_TURN, SWINGS = "60rpm", (20.0, 5.0)  # of a hinge without a range; amplitudes [deg] where it cannot turn fully
STROKE_SHARE = 0.05  # of the extent: amplitude of a slide without a range
RANGE_SHARE = 0.4  # of the room to the nearer end of a range: amplitude of a joint that has one
STILL_SHARE = 0.02  # of the way to the middle of its range, by which a joint moves that is to stay inside
ROOM_SHARE = 0.1  # of a range: a start with less room is moved to the middle


def choose_drives(model: mujoco.MjModel, start: Array, inside: Array | None = None) -> tuple[dict[str, str], str]:
    """Choose laws that drive a model's loops from a start (nq,), and say why no wider law can.

    Driven is a joint that has an actuator, or a hinge on the ground, or another joint of a loop, in this order; what
    else is free is held. Its law is the first that the loops and all limits allow: a full turn, then swings inside its
    range.

    Args:
        inside: the nearest closed pose (nq,) with all joints in their ranges, where the start is outside.

    Returns:
        The law of each driven joint, as text, and why a wider law is not allowed; no law, and the reason, where there
        is no loop or no law is allowed.
    """
    try:
        tree, there = tree_of(model, start), tree_of(model, start if inside is None else inside)
        handles = {closure_name(model, k) for k in handle_indices(model)}  # what a mouse drags is no loop
        if {one.name for one in tree.closures} <= handles or not tree.loop_joints:
            return {}, "it has no closed loop, which alone could open"
        joints = joints_to_drive(model, there)
    except InvalidInput as error:
        return {}, str(error)
    if not joints:
        return {}, why_nothing_moves(there, preferred_joints(model, there), is_free=has_free_motion(there))
    reason, beyond = "", dict[str, str]()
    for text in law_texts(joints[0], there, from_start=inside is None):
        laws = {joints[0].name: text, **{joint.name: _holding_law(joint, tree, there) for joint in joints[1:]}}
        try:
            left = exceeded_limits(model, track_laws(there, laws))
        except InvalidInput as error:
            reason = reason or f"driven by {joints[0].name}={text}: {error}"
            continue
        if not left:
            return laws, reason
        beyond = beyond or laws
        reason = reason or f"driven by {joints[0].name}={text}: {list_names(left)} would leave its limits"
    return beyond, reason  # no law keeps the limits


def exceeded_limits(model: mujoco.MjModel, machine: DrivenTree) -> list[str]:
    """Joints and tendons that leave their limits along a machine's tracked motion, by name."""
    poses, data = np.concatenate([knot.coordinates for knot in machine.knots], axis=1), mujoco.MjData(model)
    if model.opt.disableflags & (mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT):
        return []
    found = dict.fromkeys(joint.name for pose in poses.T for joint in joints_outside(machine.tree, pose))
    if not np.any(model.tendon_limited):
        return list(found)
    lengths = list[Array]()
    for pose in poses.T:
        data.qpos[:] = pose
        mujoco.mj_fwdPosition(model, data)
        lengths.append(np.array(data.ten_length))
    return [*found, *(f"tendon {name}" for name, _, _ in tendons_beyond_limits(model, np.array(lengths)))]


def _holding_law(joint: SpatialJoint, start: SpatialTree, inside: SpatialTree) -> str:
    """Law of a joint that is to stay where it is: a small one from a pose inside, where the start is outside its range.

    Args:
        start, inside: the loops at the start, and at the closed pose that the motion is to begin from.
    """
    value, (factor, unit) = float(inside.start[joint.coordinate]), _shown_unit(joint)
    if joint.range is None or joint.range[0] <= float(start.start[joint.coordinate]) <= joint.range[1]:
        return "hold"
    end = value + STILL_SHARE * (0.5 * sum(joint.range) - value)
    return f"move:{factor * value:.6g}{unit},{factor * end:.6g}{unit},1s"


def has_free_motion(tree: SpatialTree) -> bool:
    """True if closures leave a motion at the closed pose nearest to the start."""
    machine = DrivenTree(tree, {}, tuple(joint.name for joint in tree.joints if joint not in tree.loop_joints))
    return bool(free_directions(machine, machine.close_loops(tree.start[:, None], 0.0)[0]).shape[1])


def why_nothing_moves(tree: SpatialTree, names: Sequence[str], *, is_free: bool = False) -> str:
    """Say why loops leave nothing that could be driven, by the axis that is off where one explains it.

    Args:
        is_free: whether they can move all the same.
    """
    if is_free:
        return "its loops move, but no hinge or slide of them that a law could drive does"
    said = UNEXPLAINED
    joint = next((one for one in tree.joints if one.name in names[:1]), None)
    if joint is None or joint.kind != "hinge":
        return said
    law = parse_drive_law(FULL_TURN, joint.unit, float(tree.start[joint.coordinate]), joint.name)
    held = tuple(one.name for one in tree.joints if one not in tree.loop_joints)
    try:
        track_motion(DrivenTree(tree, {joint.name: law}, held), 0.0, OWN_POSE, explained=False)
    except InvalidInput as error:
        return f"{said}: driven by {joint.name}, {error}"
    return said


def joints_to_drive(model: mujoco.MjModel, tree: SpatialTree) -> list[SpatialJoint]:
    """Joints that determine the motion of the loops together, the best to drive first."""
    held = tuple(joint.name for joint in tree.joints if joint not in tree.loop_joints)
    machine = DrivenTree(tree, {}, held)
    pose = machine.close_loops(tree.start[:, None], 0.0)[0]
    directions = free_directions(machine, pose)
    if not directions.shape[1]:
        return []
    _, names = drives_to_add(machine, forward_kinematics(tree, pose), directions, preferred_joints(model, tree))
    by_name = {joint.name: joint for joint in tree.joints}
    return [by_name[name] for name in names]


def preferred_joints(model: mujoco.MjModel, tree: SpatialTree) -> list[str]:
    """Names of loop joints, best to drive first: with an actuator, hinges on the ground, the rest."""
    of_joint = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)
    actuated = {name_or_number(model, "joint", int(joint)) for joint in model.actuator_trnid[of_joint, 0]}
    loop = [joint for joint in tree.loop_joints if joint.kind in ("hinge", "slide")]
    grounded = {joint.name for joint in loop if joint.kind == "hinge" and not tree.joints_above[_parent(tree, joint)]}
    return [joint.name for joint in sorted(loop, key=lambda j: (j.name not in actuated, j.name not in grounded))]


def _parent(tree: SpatialTree, joint: SpatialJoint) -> int:
    return tree.bodies[joint.body].parent


def law_texts(joint: SpatialJoint, tree: SpatialTree, *, from_start: bool = True) -> Iterator[str]:
    """Yield laws for a joint from a pose, the widest first.

    Args:
        from_start: whether the pose is the start; laws from elsewhere name where they begin.
    """
    value, (factor, unit) = float(tree.start[joint.coordinate]), _shown_unit(joint)
    if joint.range is None:
        if joint.kind == "hinge":
            yield FULL_TURN
            yield from (f"sine:{swing:g}deg,1Hz" for swing in SWINGS)
            # A start beside a dead centre is left one way only.
            for swing in SWINGS:
                yield from (f"move:{factor * value:.6g}deg,{factor * value + way * swing:.6g}deg,1s" for way in (1, -1))
            return
        yield f"sine:{factor * STROKE_SHARE * tree.extent:.2g}mm,1Hz"
        return
    low, high = joint.range
    room = min(value - low, high - value)
    if from_start and room > ROOM_SHARE * (high - low):
        for share in (RANGE_SHARE, 0.25 * RANGE_SHARE):
            yield f"sine:{factor * share * room:.2g}{unit},1Hz"
    inside, middle = float(np.clip(value, low, high)), 0.5 * (low + high)
    for end in (middle, 0.5 * (inside + middle)):
        if end != inside:
            yield f"move:{factor * inside:.4g}{unit},{factor * end:.4g}{unit},1s"
    # From further inside, where the start is outside or at an end of the range.
    yield f"move:{factor * middle:.4g}{unit},{factor * 0.5 * (middle + high):.4g}{unit},1s"


def _shown_unit(joint: SpatialJoint) -> tuple[float, str]:
    return (float(np.degrees(1.0)), "deg") if joint.unit == "rad" else (1e3, "mm")


def track_laws(tree: SpatialTree, texts: Mapping[str, str]) -> DrivenTree:
    """Track the motion of the loops that laws determine.

    Raises:
        InvalidInput: the loops do not allow it.
    """
    by_name, laws = {joint.name: joint for joint in tree.joints}, dict[str, DriveLaw]()
    for name, text in texts.items():
        laws[name] = parse_drive_law(text, by_name[name].unit, float(tree.start[by_name[name].coordinate]), name)
    held = tuple(joint.name for joint in tree.joints if joint not in tree.loop_joints and joint.name not in laws)
    machine = DrivenTree(tree, laws, held)
    start = machine.assemble_start()
    check_drives(machine, start)
    machine.track_branch(start, duration(laws))
    return machine
