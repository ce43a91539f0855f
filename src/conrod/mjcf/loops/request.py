"""Request of a user for a model: drives, controls, points, and the machine that it is to be."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.space.laws import FORMS, Law, law_of
from conrod.exact.space.mobility import Mobility
from conrod.exact.space.tree import SpatialTree
from conrod.mjcf.loops.driving import site_points
from conrod.mjcf.loops.reading import tree_of
from conrod.mjcf.loops.results import Question
from conrod.own.models.loading import (
    OWN_POSE,
    FoundPoint,
    data_at_start,
    element_id,
    listed,
    load_model,
    name_or_number,
    names_of,
)
from conrod.scenes.space import MACHINES

JOINT_TRANSMISSIONS = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))


def machine_tree(machine: str) -> SpatialTree:
    """The machine of a name, or of a model file."""
    if machine in MACHINES:
        model = mujoco.MjModel.from_xml_string(MACHINES[machine]().mjcf)
    else:
        model = load_model(Path(machine))
    return tree_of(model, data_at_start(model, OWN_POSE)[0].qpos)


def laws_of(model: mujoco.MjModel, tree: SpatialTree, question: Question) -> tuple[dict[str, Law], tuple[str, ...]]:
    """Laws of the driven joints, and the joints that are held: those in no loop, such as a floating base.

    Raises:
        InvalidInput: a drive is no joint, no hinge or slide, or its law leaves the joint's range.
    """
    by_name, laws = {joint.name: joint for joint in tree.joints}, dict[str, Law]()
    drivable = [one.name for one in tree.joints if one.kind in ("hinge", "slide")]
    for name, text in question.drives.items():
        if name not in by_name:
            if name in names_of(model, "actuator"):
                at = element_id(model, "actuator", name)
                moves_joint = int(model.actuator_trntype[at]) in JOINT_TRANSMISSIONS
                moved = name_or_number(model, "joint", int(model.actuator_trnid[at, 0])) if moves_joint else "JOINT"
                raise InvalidInput(f"--drive {name}: it is an actuator; drive its joint: --drive {moved}={text}")
            raise unknown_choice("joint", name, drivable)
        joint = by_name[name]
        if joint.kind not in ("hinge", "slide"):
            raise InvalidInput(
                f"--drive {name}: it is a {joint.kind} joint; hinges and slides are driven: {listed(drivable)}"
            )
        laws[name] = law_of(text, joint.unit, float(tree.start[joint.coordinate]), name)
    if all(law.duration == math.inf for law in laws.values()):
        raise InvalidInput(
            f"none of its joints is driven: give --drive JOINT=LAW for one of {listed(drivable)}; LAW: {FORMS}"
        )
    seconds, keys = question.seconds or duration(laws), [key for key in names_of(model, "key") if key]
    keyframes = f"; to start elsewhere, --keyframe takes {listed(keys)}" if keys and not question.keyframe else ""
    for name, law in laws.items():
        if (span := by_name[name].range) is not None:
            values = law.derivatives(np.linspace(0.0, seconds, 1001))[0]
            if values.min() < span[0] - 1e-9 or values.max() > span[1] + 1e-9:
                raise InvalidInput(
                    f"--drive {name}={law.text}: it goes from {values.min():.4g} to {values.max():.4g}, the joint's "
                    f"range is {span[0]:.4g} to {span[1]:.4g} {by_name[name].unit}{keyframes}"
                )
    return laws, tuple(j.name for j in tree.joints if j not in tree.looped and j.name not in laws)


def duration(laws: Mapping[str, Law]) -> float:
    """Time [s] after which the slowest drive has been through its law."""
    return max(law.duration for law in laws.values() if law.duration < math.inf)


def judged_points(
    model: mujoco.MjModel, tree: SpatialTree, freedom: Mobility, question: Question
) -> tuple[FoundPoint, ...]:
    """Points that are judged: those named, or sites that loops carry and drives determine; bodies where none is."""
    for name in question.points:
        if name not in tree.points:
            raise unknown_choice("point", name, tree.points)
        if name in freedom.undetermined:
            raise InvalidInput(
                f"--point {name}: its drives do not determine it: {', '.join(freedom.idle)} can still move"
            )
    carried = [name for name, point in tree.points.items() if set(tree.above[point.body]) & set(tree.looped)]
    judged = [name for name in carried if name not in freedom.undetermined]
    sites = [name_or_number(model, "site", k) for k in range(model.nsite)]
    return site_points(model, question.points or tuple(name for name in judged if name in sites) or tuple(judged))
