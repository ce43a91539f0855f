"""A compiled MuJoCo model as a machine in space, and what is asked of it: drives, points, and another machine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.errors import InvalidInput, OutsideLoopsError, list_names, unknown_choice
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialClosure, SpatialJoint, SpatialPoint, SpatialTree
from conrod.exact.space.drive_laws import FORMS, DriveLaw, parse_drive_law
from conrod.exact.space.forward_kinematics import rotation_matrices
from conrod.exact.space.mobility import Mobility
from conrod.mjcf.driving import site_points
from conrod.mjcf.equalities import closure_name, disabling_flag, equality_kind
from conrod.mjcf.loading import OWN_POSE, FoundPoint, data_at_start, joint_kind, load_model, name_or_number, names_of
from conrod.mjcf.loop_results import LoopRequest
from conrod.scenes.space import MACHINES

SITE = int(mujoco.mjtObj.mjOBJ_SITE)


def tree_of(model: mujoco.MjModel, start: Array) -> SpatialTree:
    """Build the spatial tree of a model, with the closures that act at first.

    Args:
        start: coordinates (nq,) of the pose from which the model is assembled.

    Raises:
        InvalidInput: a closure is of a kind whose motion is not determined by rigid bodies.
    """
    acting = [] if disabling_flag(model) else np.flatnonzero(model.eq_active0).tolist()
    closures = tuple(_closure(model, k) for k in acting)
    bodies = tuple(_body(model, k) for k in range(model.nbody))
    points = {body.name: SpatialPoint(k, np.zeros(3)) for k, body in enumerate(bodies) if _is_movable(model, k)}
    sites = (k for k in range(model.nsite) if _is_movable(model, int(model.site_bodyid[k])))
    points |= {name_or_number(model, "site", k): _site_point(model, k) for k in sites}
    gravity = np.zeros(3) if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY else model.opt.gravity.copy()
    return SpatialTree(bodies, closures, points, gravity, np.array(start, dtype=float), _unmodelled_inertia(model))


def _is_movable(model: mujoco.MjModel, body: int) -> bool:
    """True if a joint moves the body against the world."""
    return bool(model.body_dofnum[model.body_weldid[body]])


def _rotation(quaternion: Array) -> Array:
    return np.asarray(
        rotation_matrices(np.asarray(quaternion, dtype=float)[:, None] / np.linalg.norm(quaternion))[:, :, 0]
    )


def _body(model: mujoco.MjModel, k: int) -> SpatialBody:
    first = int(model.body_jntadr[k])
    joints = tuple(_joint(model, j) for j in range(first, first + int(model.body_jntnum[k])))
    place, quaternion = model.body_pos[k].copy(), model.body_quat[k]
    if (mocap := int(model.body_mocapid[k])) >= 0:
        data = mujoco.MjData(model)
        place, quaternion = data.mocap_pos[mocap].copy(), data.mocap_quat[mocap]
    along = _rotation(model.body_iquat[k])
    return SpatialBody(
        name_or_number(model, "body", k), int(model.body_parentid[k]), place, _rotation(quaternion), joints,
        float(model.body_mass[k]), model.body_ipos[k].copy(), along @ np.diag(model.body_inertia[k]) @ along.T,
    )  # fmt: skip


def _joint(model: mujoco.MjModel, j: int) -> SpatialJoint:
    kind, coordinate, rate = joint_kind(model, j), int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j])
    made = SpatialJoint(
        name_or_number(model, "joint", j), kind, int(model.jnt_bodyid[j]), coordinate, rate, model.jnt_pos[j].copy(),
        model.jnt_axis[j].copy(), float(model.qpos0[coordinate]), float(model.dof_armature[rate]),
        float(model.dof_damping[rate]) * (not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_DAMPER),
        float(model.jnt_stiffness[j]) * (not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_SPRING),
        float(model.qpos_spring[coordinate]),
    )  # fmt: skip
    limits = not model.opt.disableflags & (mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    limited = limits and model.jnt_limited[j] and kind in ("hinge", "slide")
    return replace(made, range=(float(model.jnt_range[j, 0]), float(model.jnt_range[j, 1]))) if limited else made


def _site_point(model: mujoco.MjModel, k: int) -> SpatialPoint:
    """Point of a site, by the index of the site."""
    return SpatialPoint(int(model.site_bodyid[k]), model.site_pos[k].copy())


def _closure(model: mujoco.MjModel, k: int) -> SpatialClosure:
    name, kind = closure_name(model, k), equality_kind(model, k)
    if not kind:
        raise InvalidInput(f"{name}: an equality constraint of a flex: its motion is no rigid one")
    one, two, data = int(model.eq_obj1id[k]), int(model.eq_obj2id[k]), model.eq_data[k]
    if kind in ("joint", "tendon"):
        sum_of, rests = (
            (_joint_sum, model.qpos0[model.jnt_qposadr]) if kind == "joint" else (_tendon_sum, model.tendon_length0)
        )
        sums = tuple(sum_of(model, name, k) if k >= 0 else {} for k in (one, two))
        references = tuple(float(rests[k]) if k >= 0 else 0.0 for k in (one, two))
        return SpatialClosure(name, kind, sums=sums, references=references, polynomial=tuple(data[:5].tolist()))
    if int(model.eq_objtype[k]) == SITE:
        points = (_site_point(model, one), _site_point(model, two))
        first, second = (_rotation(model.site_quat[s]) for s in (one, two))
        return SpatialClosure(name, kind, points, first @ second.T if kind == "weld" else None)
    if kind == "connect":
        return SpatialClosure(name, kind, (SpatialPoint(one, data[:3].copy()), SpatialPoint(two, data[3:6].copy())))
    points = (SpatialPoint(one, data[3:6].copy()), SpatialPoint(two, data[:3].copy()))
    return SpatialClosure(name, kind, points, _rotation(data[6:10]))


def _joint_sum(model: mujoco.MjModel, name: str, joint: int) -> dict[int, float]:
    """Return the coefficient 1 of a hinge or slide, by its degree of freedom."""
    if (kind := joint_kind(model, joint)) not in ("hinge", "slide"):
        raise InvalidInput(f"{name}: it couples {name_or_number(model, 'joint', joint)}, a {kind} joint")
    return {int(model.jnt_dofadr[joint]): 1.0}


def _tendon_sum(model: mujoco.MjModel, name: str, tendon: int) -> dict[int, float]:
    """Return the coefficients of a fixed tendon's joints, by degree of freedom.

    Raises:
        InvalidInput: the tendon runs through sites.
    """
    first = int(model.tendon_adr[tendon])
    wraps = range(first, first + int(model.tendon_num[tendon]))
    if any(int(model.wrap_type[w]) != int(mujoco.mjtWrap.mjWRAP_JOINT) for w in wraps):
        raise InvalidInput(
            f"{name}: its tendon runs through sites; only fixed tendons, sums of joints, are closures here"
        )
    return {int(model.jnt_dofadr[model.wrap_objid[w]]): float(model.wrap_prm[w]) for w in wraps}


def _unmodelled_inertia(model: mujoco.MjModel) -> tuple[str, ...]:
    """Names of inertias that the exact forces do not include."""
    found = {
        "armatures of tendons": _has_nonzero(model, "tendon_armature"),
        "armatures of actuators": _has_nonzero(model, "actuator_armature"),
    }
    return tuple(name for name, there in found.items() if there)


def _has_nonzero(model: mujoco.MjModel, *fields: str) -> bool:
    """True if any of some fields is not 0 anywhere; fields missing in this release are skipped."""
    return any(bool(np.any(getattr(model, field, 0.0))) for field in fields)


def check_rigid(model: mujoco.MjModel) -> None:
    """Refuse a model with flexes or plugins; raises InvalidInput, which names them."""
    parts = {"flex": model.nflex, "plugin": model.nplugin}
    if found := [f"{number} {name}" for name, number in parts.items() if number]:
        raise InvalidInput(f"it has {list_names(found)}: only rigid bodies have an exact motion here")


# -- what is asked of it ----------------------------------------------------------------------------------------------


def machine_tree(machine: str) -> SpatialTree:
    """The spatial tree of a built-in machine, by name, or of a model file."""
    if machine in MACHINES:
        model = mujoco.MjModel.from_xml_string(MACHINES[machine]().mjcf)
    else:
        model = load_model(Path(machine))
    return tree_of(model, data_at_start(model, OWN_POSE)[0].qpos)


def laws_of(
    model: mujoco.MjModel, tree: SpatialTree, question: LoopRequest
) -> tuple[dict[str, DriveLaw], tuple[str, ...]]:
    """Laws of the driven joints, and names of the joints to hold, which are in no loop.

    Raises:
        InvalidInput: a drive is no joint, no hinge or slide, or its law leaves the joint's range.
    """
    by_name, laws = {joint.name: joint for joint in tree.joints}, dict[str, DriveLaw]()
    drivable = [one.name for one in tree.joints if one.kind in ("hinge", "slide")]
    for name, text in question.drives.items():
        if name not in by_name:
            unknown = unknown_choice("joint", name, drivable)
            actuators = [name_or_number(model, "actuator", k) for k in range(len(model.actuator_trntype))]
            raise OutsideLoopsError(str(unknown)) if name in actuators else unknown
        joint = by_name[name]
        if joint.kind not in ("hinge", "slide"):
            raise InvalidInput(
                f"--drive {name}: it is a {joint.kind} joint; hinges and slides are driven: {list_names(drivable)}"
            )
        laws[name] = parse_drive_law(text, joint.unit, float(tree.start[joint.coordinate]), name)
    if all(law.duration == math.inf for law in laws.values()):
        raise InvalidInput(
            f"none of its joints is driven: give --drive JOINT=LAW for one of {list_names(drivable)}; LAW: {FORMS}"
        )
    seconds, keys = question.seconds or duration(laws), [key for key in names_of(model, "key") if key]
    keyframes = f"; to start elsewhere, --keyframe takes {list_names(keys)}" if keys and not question.keyframe else ""
    for name, law in laws.items():
        if (span := by_name[name].range) is not None:
            values = law.derivatives(np.linspace(0.0, seconds, 1001))[0]
            start = float(tree.start[by_name[name].coordinate])
            begins = ""
            if not span[0] <= start <= span[1]:
                inside = "" if keyframes else ": begin inside it, by move:FROM,TO,TIME or a keyframe"
                begins = f", which the pose that it starts from, at {start:.4g}, is outside{inside}"
            if values.min() < span[0] - 1e-9 or values.max() > span[1] + 1e-9:
                raise InvalidInput(
                    f"--drive {name}={law.text}: it goes from {values.min():.4g} to {values.max():.4g}, the joint's "
                    f"range is {span[0]:.4g} to {span[1]:.4g} {by_name[name].unit}{begins}{keyframes}"
                )
    return laws, tuple(j.name for j in tree.joints if j not in tree.loop_joints and j.name not in laws)


def duration(laws: Mapping[str, DriveLaw]) -> float:
    """Time [s] after which the slowest drive has completed its law."""
    return max(law.duration for law in laws.values() if law.duration < math.inf)


def judged_points(
    model: mujoco.MjModel, tree: SpatialTree, freedom: Mobility, question: LoopRequest
) -> tuple[FoundPoint, ...]:
    """Select the points to judge: the named ones, or sites that closures move and drives determine, or bodies.

    A point that is rigid with what is driven or held is where the drives put it, however far the loops open: it is
    selected by name, or where closures move no point at all. Points that are neither sites nor frames of bodies are
    those of `conrod.exact.space.link_points`, in a tree that has them.
    """
    for name in question.points:
        if name not in tree.points:
            raise unknown_choice("point", name, tree.points)
        if name in freedom.undetermined:
            raise InvalidInput(
                f"--point {name}: its drives do not determine it: {', '.join(freedom.idle)} can still move"
            )
    carried = [
        name for name, point in tree.points.items() if set(tree.joints_above[point.body]) & set(tree.loop_joints)
    ]
    judged = [name for name in carried if name not in freedom.undetermined]
    judged = [name for name in judged if name not in freedom.rigid] or judged
    sites = [name_or_number(model, "site", k) for k in range(model.nsite)]
    names = question.points or tuple(name for name in judged if name in sites) or tuple(judged)
    return site_points(model, names, tree.points)
