"""The file's own run against the drive laws: the speed of hinges whose law is a constant speed, and the branch."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialJoint
from conrod.exact.space.drive_laws import DriveLaw, quintic
from conrod.exact.space.motion import DrivenTree
from conrod.mechanism.units import REVOLUTION
from conrod.mjcf.crank_speed import MAX_MEAN_SPEED_ERROR, MAX_SPEED_SWING, CrankSpeed
from conrod.mjcf.driven_runs import is_on_other_branch
from conrod.mjcf.driving import break_off_reason
from conrod.mjcf.loading import element_id, names_of
from conrod.mjcf.loop_results import JointSpeed, LawComparison

LAW_INSTANTS = 9  # at which a law is looked at for whether its speed is constant


def allowed_speed_error(tolerance: Mapping[str, float], travel: float, fastest: float) -> float:
    """Allowed relative error of a mean speed: the velocity's tolerance over the fastest point's speed [m/s].

    Where that is not asked for, the position's over the travel [m], or a per cent where that is less: after a radian of
    a crank, a speed off by a share e has a point off by about e of its travel.
    """
    if "velocity" in tolerance:
        return tolerance["velocity"] / max(fastest, 1e-300)
    return min(MAX_MEAN_SPEED_ERROR, tolerance.get("position", math.inf) / max(travel, 1e-300))


def constant_speeds(machine: DrivenTree, seconds: float) -> dict[str, float]:
    """Speeds [rad/s] of the driven hinges whose law is a constant speed, by joint."""
    times, found = np.linspace(0.0, seconds, LAW_INSTANTS), dict[str, float]()
    for joint, law in zip(machine.driven, machine.laws.values(), strict=True):
        _, rates, accelerations, _ = law.derivatives(times)
        if joint.kind == "hinge" and rates[0] and np.ptp(rates) == 0.0 and not accelerations.any():
            found[joint.name] = float(rates[0])
    return found


def commands_speed(model: mujoco.MjModel, data: mujoco.MjData, joints: Iterable[SpatialJoint]) -> bool:
    """True if a start gives driven joints a rate, or a velocity actuator a speed other than 0.

    An actuator with a gain on a position (`biasprm[1]`) goes to its position and stays there.
    """
    commanded = (data.ctrl != 0.0) & (model.actuator_biasprm[:, 2] != 0.0) & (model.actuator_biasprm[:, 1] == 0.0)
    return any(bool(data.qvel[joint.rate]) for joint in joints) or bool(commanded.any())


def commands_force(model: mujoco.MjModel, data: mujoco.MjData) -> bool:
    """True if a control other than 0 is a force, which moves a machine or holds it."""
    return bool(np.any((data.ctrl != 0.0) & ~model.actuator_biasprm[:, 1:3].any(axis=1)))


def commands_joints(model: mujoco.MjModel, data: mujoco.MjData, joints: Iterable[str]) -> bool:
    """True if an actuator of one of some joints has a control other than 0."""
    numbers = {element_id(model, "joint", name) for name in joints if name in names_of(model, "joint")}
    of_joint = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)
    acting = np.flatnonzero((data.ctrl != 0.0) & of_joint)
    return bool(numbers & set(model.actuator_trnid[acting, 0].tolist()))


def compare_with_laws(
    machine: DrivenTree, model: mujoco.MjModel, data: mujoco.MjData, points: Iterable[str], seconds: float,
    allowed: float, near: float,
) -> LawComparison:  # fmt: skip
    """Run the file as it is, and compare its speeds and its branch with the laws.

    The branch is compared at the start, and after the motion of the laws, of a run that is commanded their speeds; at
    the start alone where an actuator of a driven joint is commanded anything else.

    Args:
        data: at the start of the file's own run; it goes on from there.
        points: points that the drives determine, by which branches are distinguished.
        seconds: length of the motion that the laws prescribe. Where that is a turn, one more is made, at whose end what
            has started from rest turns steadily.
        allowed: share of a law's speed by which a mean may be off.
        near: distance [m] up to which points are on one branch.
    """
    step, laws = float(model.opt.timestep), constant_speeds(machine, seconds)
    joints = [joint for joint in machine.driven if joint.name in laws]
    speed_commanded, force_commanded = commands_speed(model, data, joints), commands_force(model, data)
    targeted = commands_joints(model, data, machine.laws)
    turn = max((machine.laws[joint.name].duration for joint in joints), default=0.0)
    whole, count = turn <= seconds * (1.0 + 1e-9), round(seconds / step)
    poses, rates = _run_on(model, data, count, round(turn / step) if whole else 0)
    if not len(rates):
        return LawComparison()
    speeds = list[JointSpeed]()
    for joint in joints if speed_commanded or force_commanded else ():
        length = machine.laws[joint.name].duration if whole else 0.5 * seconds
        speed = _crank_speed(rates[:, joint.rate], round(length / step), step)
        if speed_commanded or not speed.is_still:  # a force that holds is no drive
            # The mean of a part of a turn swings as the speed does.
            bound = allowed if whole else max(allowed, MAX_SPEED_SWING)
            speeds.append(JointSpeed(joint.name, speed, laws[joint.name], bound))
    # A run that is not meant to follow the laws may pass dead centres of the driven joints.
    looked_at = poses if len(speeds) == len(machine.laws) else poses[:1] if speeds or targeted else ()
    branches = (is_on_branch_of_laws(machine, points, pose, near) for pose in looked_at)
    return LawComparison(tuple(speeds), any(one is False for one in branches))


def _run_on(model: mujoco.MjModel, data: mujoco.MjData, count: int, more: int) -> tuple[tuple[Array, Array], Array]:
    """Make steps; return the poses (nq,) at the start and after `count` of them, and the rates (T, nv) after each.

    Returns:
        No rates where the run breaks off.
    """
    first = last = np.array(data.qpos)
    rates = list[Array]()
    with silence_warnings():
        for k in range(1, count + more + 1):
            mujoco.mj_step(model, data)
            if break_off_reason(model, data):
                return (first, last), np.zeros((0, model.nv))
            rates.append(data.qvel.copy())
            if k == count:
                last = np.array(data.qpos)
    return (first, last), np.array(rates)


def _crank_speed(rates: Array, last: int, step: float) -> CrankSpeed:
    """Speed of a hinge over the last steps of a run of rates (T,) [rad/s]."""
    seen = rates[-max(2, last) :]
    farthest = step * float(np.abs(np.cumsum(rates)).max()) / REVOLUTION
    return CrankSpeed(float(seen.mean()), float(seen.min()), float(seen.max()), farthest)


# -- the branch --------------------------------------------------------------------------------------------------------


def is_on_branch_of_laws(machine: DrivenTree, names: Iterable[str], coordinates: Array, near: float) -> bool | None:
    """True if a pose (nq,) of the file's own run is on the branch that the laws' motion is on.

    The laws' motion is led from its start to where the pose has the driven joints, and both are compared there.

    Args:
        names: names of points that drives determine.
        near: distance [m] of such a point up to which poses are on one branch.

    Returns:
        None where the laws' motion cannot be led there, as beyond a dead centre.
    """
    start, here = machine.knots[0].coordinates, np.array(coordinates)[:, None]
    for joint in machine.tree.joints:
        if joint.name in machine.held:
            here[joint.coordinates] = start[joint.coordinates]
    for around in (True, False):
        there = DrivenTree(machine.tree, _laws_between(machine, start, here, around), machine.held)
        try:
            there.track_branch(start, 1.0)
        except InvalidInput:
            continue
        return not is_on_other_branch(there, names, here, 1.0, there.knots[-1].coordinates, near)
    return None


def _laws_between(machine: DrivenTree, start: Array, end: Array, around: bool) -> dict[str, DriveLaw]:
    """Laws of a second from one pose (nq, 1) to another.

    Args:
        around: whether a hinge takes the shorter way, in place of all its turns.
    """
    laws = dict[str, DriveLaw]()
    for joint in machine.driven:
        one, two = float(start[joint.coordinate, 0]), float(end[joint.coordinate, 0])
        if around and joint.unit == "rad":
            two = one + math.remainder(two - one, REVOLUTION)
        laws[joint.name] = DriveLaw("", 1.0, quintic(one, two, 1.0))
    return laws
