"""Watch a MuJoCo run for forces besides weight, inertia and the loops: rows of constraints and passive forces.

What acts is read from what MuJoCo computed in the run, never from what a file has: a limit that is not reached, a
friction that is switched off, or a spring at rest is not named.
"""

from __future__ import annotations

from functools import cache, partial

import mujoco
import numpy as np

from conrod.comparison import other_forces as kinds
from conrod.comparison.other_forces import OtherForce
from conrod.engines.mujoco import compat
from conrod.exact.motion import Array
from conrod.mjcf.equalities import closure_name, equality_kind, measures_angles
from conrod.mjcf.loading import joint_kind, name_or_number

ROWS = mujoco.mjtConstraint
LIMITS = {int(ROWS.mjCNSTR_LIMIT_JOINT): "joint", int(ROWS.mjCNSTR_LIMIT_TENDON): "tendon"}
FRICTIONS = {int(ROWS.mjCNSTR_FRICTION_DOF): "joint", int(ROWS.mjCNSTR_FRICTION_TENDON): "tendon"}
INTEGRATION = mujoco.mjtState.mjSTATE_INTEGRATION
PYRAMID = int(ROWS.mjCNSTR_CONTACT_PYRAMIDAL)
# A force of less than this share of the largest of its run is rounding, and a part of an acceleration of this share.
NO_FORCE, NO_ACCELERATION = 1e-12, 1e-9
DIFFERENCE_DISPLACEMENT = (
    1e-4  # displacement over which the length of a tendon is differenced [rad or m of the fastest joint]
)
# Gravity of less than this share of itself across the plane is in the plane, as a file with few digits has it.
MAX_GRAVITY_ACROSS = 1e-4
PARALLEL = 1e-6  # sine of the angle between axes that are parallel
ROTATIONAL = ("hinge", "ball")


class ForceWatch:
    """Recorder of the forces other than weight, inertia and the loops' that act in a run.

    Args:
        pair: geoms whose contact is a part of the machine, and is not named.
    """

    def __init__(self, model: mujoco.MjModel, pair: tuple[int, int] | None = None) -> None:
        self._model, self._pair = model, None if pair is None else frozenset(pair)
        self._seen = dict[tuple[str, str], OtherForce]()
        self._scale = self._fastest = 0.0
        disabled = int(model.opt.disableflags)
        springs, dampers = (not disabled & compat.disable_bit(name) for name in ("SPRING", "DAMPER"))
        # What acts is sought at every step, and where, once.
        self._sprung_joints = _acting_elements(springs, model, "jnt_stiffness", "jnt_stiffnesspoly")
        self._sprung_tendons = _acting_elements(springs, model, "tendon_stiffness", "tendon_stiffnesspoly")
        self._damped_tendons = _acting_elements(dampers, model, "tendon_damping", "tendon_dampingpoly")
        damped = _acting_elements(dampers, model, "dof_damping", "dof_dampingpoly")
        self._damped_joints = sorted({int(model.dof_jntid[dof]) for dof in damped})
        self._geared = _acting_elements(dampers, model, "actuator_damping", "actuator_dampingpoly")
        self._curved_springs = _nonzero_mask(model, "jnt_stiffnesspoly", "jnt_springyield")
        self._curved_dampers = _nonzero_mask(model, "dof_dampingpoly")
        self._pair_named = cache(partial(_pair_name, model))
        self._named = cache(partial(_kind_and_name, model))
        self._unit_of = cache(partial(_force_unit, model))
        self._polynomials = [k for k in range(model.neq) if _is_nonlinear(model, k)]
        self._aside = mujoco.MjData(model)
        self._handles = {k: body for k in range(model.neq) if (body := _dragging_mocap(model, k)) is not None}

    def step(self, data: mujoco.MjData) -> None:
        """Record the constraint forces of a step that was made."""
        if data.nefc > data.ne:
            self._record_constraints(data)

    def sample(self, data: mujoco.MjData) -> None:
        """Record all forces in data for which MuJoCo has computed them."""
        self.step(data)
        parts = (data.qfrc_bias, data.qfrc_passive, data.qfrc_actuator, data.qfrc_constraint)
        self._scale = max(self._scale, float(np.abs(np.concatenate(parts)).max(initial=0.0)))
        self._record_passive(data)
        for k in data.actuator_force.nonzero()[0].tolist():
            self._record(kinds.ACTUATOR, self._named("actuator", k), float(data.actuator_force[k]), "")
        if self._handles:
            self._record_drags(data)
        if self._polynomials:
            self._record_lacking(data)

    @property
    def found(self) -> tuple[OtherForce, ...]:
        """Forces that were recorded, in the order of their first sample."""
        model = self._model
        least, slowest = NO_FORCE * self._scale, NO_ACCELERATION * self._fastest
        every = self._seen.values()
        seen = [one for one in every if one.largest > (slowest if one.kind == kinds.LACKING else least)]
        if (across := gravity_across(model)) > MAX_GRAVITY_ACROSS:
            seen.append(OtherForce(kinds.ACROSS, "", across, "g", exact=True))
        return tuple(seen)

    # -- constraints ---------------------------------------------------------------------------------------------------

    def _record_constraints(self, data: mujoco.MjData) -> None:
        """Record limits, dry friction and contacts whose rows carry a force."""
        model, first = self._model, int(data.ne)
        forces, types, ids = (np.array(one[first : data.nefc]) for one in (data.efc_force, data.efc_type, data.efc_id))
        touching = dict[int, float]()
        for force, row, k in zip(forces.tolist(), types.tolist(), ids.tolist(), strict=True):
            if force == 0.0:
                continue
            if (of := LIMITS.get(row)) is not None:
                self._record(kinds.LIMIT, self._named(of, k), force, self._unit_of(of, k))
            elif (of := FRICTIONS.get(row)) is not None:
                at = int(model.dof_jntid[k]) if of == "joint" else k
                self._record(kinds.FRICTION, self._named(of, at), force, self._unit_of(of, at))
            elif row == PYRAMID or k not in touching:  # a pyramid's edges add up; a cone's first row is the normal
                touching[k] = touching.get(k, 0.0) + force
        for k, force in touching.items():
            one, other = data.contact.geom[k].tolist()
            if force > 0.0 and frozenset((one, other)) != self._pair:
                self._record(kinds.CONTACT, self._pair_named(one, other), force, "N")

    def _record_drags(self, data: mujoco.MjData) -> None:
        """Record the forces by which mocap bodies drag others."""
        model, owners = self._model, np.array(data.efc_id[: data.ne])
        for k, body in self._handles.items():
            force = float(np.linalg.norm(data.efc_force[: data.ne][owners == k][:3]))
            name = f"mocap {self._named('body', body)} by {closure_name(model, k)}"
            self._record(kinds.HANDLE, name, force, "N", exact=True)

    def _record_lacking(self, data: mujoco.MjData) -> None:
        """Record the acceleration that MuJoCo lacks for equalities that are nonlinear in the coordinates."""
        model, aside = self._model, self._aside
        state = np.empty(mujoco.mj_stateSize(model, INTEGRATION))
        mujoco.mj_getState(model, data, state, INTEGRATION)
        mujoco.mj_setState(model, aside, state, INTEGRATION)
        mujoco.mj_fwdPosition(model, aside)
        mujoco.mj_fwdVelocity(model, aside)
        owners = np.array(aside.efc_id[: aside.ne])
        self._fastest = max(self._fastest, float(np.abs(data.qacc).max(initial=0.0)))
        for k in self._polynomials:
            rows = np.flatnonzero(owners == k)
            if len(rows) == 1:
                unit = "rad/s²" if measures_angles(model, k) else "m/s²"
                missing = _missing_acceleration(model, aside, k, int(rows[0]))
                self._record(kinds.LACKING, closure_name(model, k), missing, unit, exact=True)

    # -- passive forces ------------------------------------------------------------------------------------------------

    def _record_passive(self, data: mujoco.MjData) -> None:
        """Record springs, dampers, a fluid, gravity compensation and adhesion that make a force."""
        model = self._model
        for name, kind in (("qfrc_fluid", kinds.FLUID), ("qfrc_gravcomp", kinds.COMPENSATION),
                           ("qfrc_adhesion", kinds.ADHESION)):  # fmt: skip
            if (forces := getattr(data, name, None)) is not None and any(forces.tolist()):
                self._record(kind, "", float(np.abs(forces).max()), "")
        if (self._sprung_joints or self._sprung_tendons) and any(springs := list[float](data.qfrc_spring.tolist())):
            for k in self._sprung_joints:
                linear = joint_kind(model, k) in ("hinge", "slide") and not any(self._curved_springs[k : k + 1])
                self._record_joint(kinds.SPRING, k, springs, exact=bool(linear))
            for k in self._sprung_tendons:
                low, high = model.tendon_lengthspring[k]
                stretch = float(data.ten_length[k] - np.clip(data.ten_length[k], low, high))
                self._record_tendon(kinds.SPRING, k, float(model.tendon_stiffness[k]) * stretch)
        damped = self._damped_tendons or self._damped_joints or self._geared
        if damped and any(dampers := list[float](data.qfrc_damper.tolist())):
            for k in self._damped_tendons:
                self._record_tendon(kinds.DAMPER, k, float(model.tendon_damping[k] * data.ten_velocity[k]))
            for k in self._damped_joints:
                first = int(model.jnt_dofadr[k])
                linear = not any(self._curved_dampers[first : first + 1])
                self._record_joint(kinds.DAMPER, k, dampers, exact=bool(linear))
            for k in self._geared:
                self._record(kinds.DAMPER, self._named("actuator", k), max(map(abs, dampers)), "")

    def _record_joint(self, kind: str, joint: int, forces: list[float], *, exact: bool) -> None:
        model, first = self._model, int(self._model.jnt_dofadr[joint])
        last = int(model.jnt_dofadr[joint + 1]) if joint + 1 < model.njnt else model.nv
        name, unit = self._named("joint", joint), self._unit_of("joint", joint)
        self._record(kind, name, max(map(abs, forces[first:last])), unit, exact=exact)

    def _record_tendon(self, kind: str, tendon: int, force: float) -> None:
        self._record(kind, self._named("tendon", tendon), force, self._unit_of("tendon", tendon))

    def _record(self, kind: str, name: str, size: float, unit: str, *, exact: bool = False) -> None:
        key, before = (kind, name), self._seen.get((kind, name))
        if size and (before is None or abs(size) > before.largest):
            self._seen[key] = OtherForce(kind, name, abs(size), unit, exact)


def geom_name(model: mujoco.MjModel, geom: int) -> str:
    """Name of a geom, or of its body if it has none; 'a flex' for contacts of a flex."""
    if geom < 0:
        return "a flex"
    own = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, geom)
    return own or name_or_number(model, "body", int(model.geom_bodyid[geom]))


def _pair_name(model: mujoco.MjModel, one: int, other: int) -> str:
    return " and ".join(sorted(geom_name(model, geom) for geom in (one, other)))


def _kind_and_name(model: mujoco.MjModel, kind: str, index: int) -> str:
    """'joint slide', or 'joint 3' where it has no name."""
    name = name_or_number(model, kind, index)
    return name if name == f"{kind} {index}" else f"{kind} {name}"


def gravity_across(model: mujoco.MjModel) -> float:
    """Share of gravity across the plane of a planar machine; 0 for others, and without gravity."""
    size = float(np.linalg.norm(model.opt.gravity))
    if size == 0.0 or model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_GRAVITY) or not model.njnt:
        return 0.0
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    hinges = np.array([data.xaxis[k] for k in range(model.njnt) if joint_kind(model, k) == "hinge"])
    slides = np.array([data.xaxis[k] for k in range(model.njnt) if joint_kind(model, k) == "slide"])
    if not len(hinges) or len(hinges) + len(slides) < model.njnt:
        return 0.0
    normal = hinges[0]
    off = [*np.linalg.norm(np.cross(hinges, normal), axis=1), *(np.abs(slides @ normal) if len(slides) else [])]
    return 0.0 if max(off) > PARALLEL else float(abs(model.opt.gravity @ normal)) / size


def _missing_acceleration(model: mujoco.MjModel, data: mujoco.MjData, equality: int, row: int) -> float:
    """Part of the acceleration of a polynomial equality that MuJoCo does not compute.

    With x and y the coordinates of joints, or lengths of tendons, the gap is g = x - x0 - p(d), d = y - y0, so that
    g'' = J a + J' v with J' v = x~ - p'(d) y~ - p''(d) y'^2, where x~ and y~ are what lengths of tendons accelerate by
    without accelerations of joints, 0 of joints and fixed tendons. MuJoCo sets J a = -b g' - k d(r) g less what it
    computes of J' v (MuJoCo documentation, Computation; 4.0.0 computes it for connects and welds alone).
    """
    one, two = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
    of_tendons, offset, rate = equality_kind(model, equality) == "tendon", 0.0, 0.0
    term = _length_curvature(model, data, one) if of_tendons else 0.0
    if two >= 0:
        if of_tendons:
            offset, rate = float(data.ten_length[two] - model.tendon_length0[two]), float(data.ten_velocity[two])
        else:
            offset = float(data.qpos[model.jnt_qposadr[two]] - model.qpos0[model.jnt_qposadr[two]])
            rate = float(data.qvel[model.jnt_dofadr[two]])
        c = model.eq_data[equality, 1:5]
        term -= (2.0 * c[1] + 6.0 * c[2] * offset + 12.0 * c[3] * offset**2) * rate**2
        if of_tendons:
            slope = c[0] + 2.0 * c[1] * offset + 3.0 * c[2] * offset**2 + 4.0 * c[3] * offset**3
            term -= slope * _length_curvature(model, data, two)
    stiffness, damping, impedance, _ = data.efc_KBIP[row]
    computed = -data.efc_aref[row] - damping * data.efc_vel[row] - stiffness * impedance * data.efc_pos[row]
    return abs(float(term - computed))


def _length_curvature(model: mujoco.MjModel, data: mujoco.MjData, tendon: int) -> float:
    """Second derivative of a tendon's length at constant rates of all joints, by a central difference."""
    speed = float(np.abs(data.qvel).max(initial=0.0))
    if speed == 0.0 or model.wrap_type[model.tendon_adr[tendon]] == int(mujoco.mjtWrap.mjWRAP_JOINT):
        return 0.0
    aside, lengths, time = mujoco.MjData(model), list[float](), DIFFERENCE_DISPLACEMENT / speed
    for side in (-1.0, 0.0, 1.0):
        aside.qpos[:] = data.qpos
        mujoco.mj_integratePos(model, aside.qpos, data.qvel, side * time)
        mujoco.mj_fwdPosition(model, aside)
        lengths.append(float(aside.ten_length[tendon]))
    return (lengths[0] - 2.0 * lengths[1] + lengths[2]) / time**2


def _is_nonlinear(model: mujoco.MjModel, equality: int) -> bool:
    """True for an equality of joints or tendons that is nonlinear in the joints' coordinates."""
    if (kind := equality_kind(model, equality)) not in ("joint", "tendon"):
        return False
    ends = [int(end) for end in (model.eq_obj1id[equality], model.eq_obj2id[equality]) if end >= 0]
    fixed = kind == "joint" or all(model.wrap_type[model.tendon_adr[ends]] == int(mujoco.mjtWrap.mjWRAP_JOINT))
    return not fixed or (len(ends) > 1 and bool(np.any(model.eq_data[equality, 2:5])))


def _dragging_mocap(model: mujoco.MjModel, equality: int) -> int | None:
    """The mocap body that a connect or weld ties to another body, or None."""
    if equality_kind(model, equality) not in ("connect", "weld"):
        return None
    return next((body for body in compat.equality_bodies(model, equality) if model.body_mocapid[body] >= 0), None)


def _force_unit(model: mujoco.MjModel, kind: str, index: int) -> str:
    """Unit of the force of a joint or tendon."""
    if kind == "joint":
        return "N m" if joint_kind(model, index) in ROTATIONAL else "N" if joint_kind(model, index) == "slide" else ""
    first = int(model.tendon_adr[index])
    wraps = range(first, first + int(model.tendon_num[index]))
    of_joints = [int(model.wrap_objid[w]) for w in wraps if model.wrap_type[w] == int(mujoco.mjtWrap.mjWRAP_JOINT)]
    return "N m" if of_joints and all(joint_kind(model, joint) == "hinge" for joint in of_joints) else "N"


def _acting_elements(acting: bool, model: mujoco.MjModel, *fields: str) -> list[int]:
    """Indices of the elements for which any of some fields is not 0; none where they do not act."""
    return np.flatnonzero(_nonzero_mask(model, *fields)).tolist() if acting else []


def _nonzero_mask(model: mujoco.MjModel, *fields: str) -> Array:
    """Mask of the elements for which any of some fields is not 0; fields missing in this release are skipped."""
    found = [np.asarray(getattr(model, field)) for field in fields if hasattr(model, field)]
    masks = [np.any(one != 0.0, axis=1) if one.ndim > 1 else one != 0.0 for one in found]
    return np.asarray(np.logical_or.reduce(masks)) if masks else np.zeros(0, dtype=bool)
