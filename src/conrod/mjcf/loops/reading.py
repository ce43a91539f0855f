"""A compiled MuJoCo model as the plain numbers of a machine in space."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space.poses import turn_of
from conrod.exact.space.tree import Closure, SpatialBody, SpatialJoint, SpatialPoint, SpatialTree
from conrod.mjcf.equalities import closure_name, kind_of
from conrod.own.models.loading import joint_kind, listed, name_or_number

SITE = int(mujoco.mjtObj.mjOBJ_SITE)


def tree_of(model: mujoco.MjModel, start: Array) -> SpatialTree:
    """The machine of a model, with the closures that act at first.

    Args:
        start: coordinates (nq,) that it is assembled from.

    Raises:
        InvalidInput: a closure is of a kind whose motion is not determined by rigid bodies.
    """
    none_acts = model.opt.disableflags & (mujoco.mjtDisableBit.mjDSBL_EQUALITY | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    closures = tuple(_closure(model, k) for k in range(model.neq) if model.eq_active0[k] and not none_acts)
    bodies = tuple(_body(model, k) for k in range(model.nbody))
    points = {body.name: SpatialPoint(k, np.zeros(3)) for k, body in enumerate(bodies) if _moves(model, k)}
    points |= {name_or_number(model, "site", k): _of_site(model, k) for k in _moving_sites(model)}
    gravity = np.zeros(3) if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY else model.opt.gravity.copy()
    return SpatialTree(bodies, closures, points, gravity, np.array(start, dtype=float), _unmodelled(model))


def _moves(model: mujoco.MjModel, body: int) -> bool:
    return bool(model.body_dofnum[model.body_weldid[body]])


def _moving_sites(model: mujoco.MjModel) -> list[int]:
    """Sites on bodies that are not fixed to the ground."""
    return [k for k in range(model.nsite) if _moves(model, int(model.site_bodyid[k]))]


def _rotation(quaternion: Array) -> Array:
    return np.asarray(turn_of(np.asarray(quaternion, dtype=float)[:, None] / np.linalg.norm(quaternion))[:, :, 0])


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
    limited = model.jnt_limited[j] and kind in ("hinge", "slide")
    return replace(made, range=(float(model.jnt_range[j, 0]), float(model.jnt_range[j, 1]))) if limited else made


def _of_site(model: mujoco.MjModel, k: int) -> SpatialPoint:
    return SpatialPoint(int(model.site_bodyid[k]), model.site_pos[k].copy())


def _closure(model: mujoco.MjModel, k: int) -> Closure:
    name, kind = closure_name(model, k), kind_of(model, k)
    if not kind:
        raise InvalidInput(f"{name}: an equality constraint of a flex: its motion is no rigid one")
    one, two, data = int(model.eq_obj1id[k]), int(model.eq_obj2id[k]), model.eq_data[k]
    if kind == "joint":
        sums = tuple(_joint_sum(model, name, j) for j in (one, two))
        references = tuple(float(model.qpos0[model.jnt_qposadr[j]]) if j >= 0 else 0.0 for j in (one, two))
        return Closure(name, kind, sums=sums, references=references, polynomial=tuple(data[:5].tolist()))
    if kind == "tendon":
        sums = tuple(_tendon_sum(model, name, t) for t in (one, two))
        references = tuple(float(model.tendon_length0[t]) if t >= 0 else 0.0 for t in (one, two))
        return Closure(name, kind, sums=sums, references=references, polynomial=tuple(data[:5].tolist()))
    if int(model.eq_objtype[k]) == SITE:
        points = (_of_site(model, one), _of_site(model, two))
        first, second = (_rotation(model.site_quat[s]) for s in (one, two))
        return Closure(name, kind, points, first @ second.T if kind == "weld" else None)
    if kind == "connect":
        return Closure(name, kind, (SpatialPoint(one, data[:3].copy()), SpatialPoint(two, data[3:6].copy())))
    points = (SpatialPoint(one, data[3:6].copy()), SpatialPoint(two, data[:3].copy()))
    return Closure(name, kind, points, _rotation(data[6:10]))


def _joint_sum(model: mujoco.MjModel, name: str, joint: int) -> dict[int, float]:
    if joint < 0:
        return {}
    if (kind := joint_kind(model, joint)) not in ("hinge", "slide"):
        raise InvalidInput(f"{name}: it couples {name_or_number(model, 'joint', joint)}, a {kind} joint")
    return {int(model.jnt_dofadr[joint]): 1.0}


def _tendon_sum(model: mujoco.MjModel, name: str, tendon: int) -> dict[int, float]:
    if tendon < 0:
        return {}
    first = int(model.tendon_adr[tendon])
    wraps = range(first, first + int(model.tendon_num[tendon]))
    if any(int(model.wrap_type[w]) != int(mujoco.mjtWrap.mjWRAP_JOINT) for w in wraps):
        raise InvalidInput(
            f"{name}: its tendon runs through sites; only fixed tendons, sums of joints, are closures here"
        )
    return {int(model.jnt_dofadr[model.wrap_objid[w]]): float(model.wrap_prm[w]) for w in wraps}


def _unmodelled(model: mujoco.MjModel) -> tuple[str, ...]:
    """Forces on the bodies besides weight, inertia, and springs and dampers of joints."""
    found = {
        "actuators": bool(model.nu),
        "tendons with springs, dampers or armatures": _any(
            model, "tendon_stiffness", "tendon_stiffnesspoly", "tendon_damping", "tendon_dampingpoly", "tendon_armature"
        ),
        "springs or dampers that are not linear": _any(
            model, "jnt_stiffnesspoly", "jnt_springyield", "dof_dampingpoly"
        ),
        "dry friction": _any(model, "dof_frictionloss", "tendon_frictionloss"),
        "a fluid": bool(model.opt.density or model.opt.viscosity),
        "gravity compensation": _any(model, "body_gravcomp"),
        "springs of balls and free joints": any(
            model.jnt_stiffness[j] and joint_kind(model, j) in ("ball", "free") for j in range(model.njnt)
        ),
    }
    return tuple(name for name, there in found.items() if there)


def _any(model: mujoco.MjModel, *fields: str) -> bool:
    """True if a field, of those that this release of MuJoCo has, is anywhere not 0."""
    return any(bool(np.any(getattr(model, field, 0.0))) for field in fields)


def check_rigid(model: mujoco.MjModel) -> None:
    """Refuse what is no machine of rigid bodies; raises InvalidInput, which names it."""
    parts = {"flex": model.nflex, "skin": model.nskin, "plugin": model.nplugin}
    if found := [f"{number} {name}" for name, number in parts.items() if number and name != "skin"]:
        raise InvalidInput(f"it has {listed(found)}: only rigid bodies have an exact motion here")
