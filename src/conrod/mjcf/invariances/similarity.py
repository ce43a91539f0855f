"""The same machine in other units, or turned: a compiled model, its states and its accelerations.

Powers of two change no bit of a product, so units are changed by them.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.engines.mujoco import older
from conrod.exact.motion import Array

FREE, SLIDE, HINGE = (int(getattr(mujoco.mjtJoint, f"mjJNT_{kind}")) for kind in ("FREE", "SLIDE", "HINGE"))
CONNECT, WELD = (int(getattr(mujoco.mjtEq, f"mjEQ_{kind}")) for kind in ("CONNECT", "WELD"))
WORLD, NO_SAME_FRAME = 0, 0  # the latter is mjSAMEFRAME_NONE, a name that 3.2.2 does not have yet
# Fields by the powers of mass and length in their unit; what counts by coordinate is in `_by_coordinate`.
LENGTHS = (
    "body_pos", "body_ipos", "jnt_pos", "geom_pos", "geom_size", "geom_rbound", "geom_aabb", "geom_margin", "geom_gap",
    "site_pos", "site_size", "mesh_vert", "mesh_pos", "bvh_aabb", "pair_margin", "pair_gap", "body_margin",
)  # fmt: skip
MASSES = (
    "body_mass",
    "body_subtreemass",
    "tendon_stiffness",
    "tendon_damping",
    "tendon_frictionloss",
    "tendon_armature",
)
WIDTHS = ("eq_solimp", "geom_solimp", "pair_solimp")  # their third number is a length
# Which a model may have and a similarity does not know: counts, or fields that must be 0.
NEVER = ("nflex", "nplugin", "nmocap", "nhfield", "na")
ZERO = ("dof_dampingpoly", "jnt_stiffnesspoly", "tendon_dampingpoly", "tendon_stiffnesspoly", "actuator_dampingpoly")


@dataclass(frozen=True)
class Similarity:
    """A similarity of space, times a unit of mass.

    Attributes:
        mass, length: factors of the numbers.
        turn: rotation of the world, a unit quaternion.
    """

    mass: float = 1.0
    length: float = 1.0
    turn: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

    @property
    def turned(self) -> bool:
        """True if it turns the world."""
        return self.turn != (1.0, 0.0, 0.0, 0.0)

    def refusal(self, model: mujoco.MjModel) -> str:
        """Features of the model that the similarity does not know; empty where it knows all."""
        return next((words for words, has in self._unknown(model) if has), "")

    def _unknown(self, model: mujoco.MjModel) -> Iterator[tuple[str, bool]]:
        yield from ((f"the model has {name} > 0", bool(getattr(model, name, 0))) for name in NEVER)
        yield from ((f"the model has {name}", bool(np.any(getattr(model, name, 0.0)))) for name in ZERO)
        yield "the model has a fluid", bool(model.opt.density or model.opt.viscosity)
        scaled, of_joints = self.length != 1.0, model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)
        moved = model.jnt_type[model.actuator_trnid[of_joints, 0]]
        right = moved == HINGE if scaled else moved >= SLIDE
        yield "an actuator acts on something else than a hinge", not (of_joints.all() and right.all())
        mixed = model.ntendon > 0 or bool(np.any(model.eq_type != CONNECT))
        yield "tendons, couplings and welds mix lengths and angles", scaled and mixed
        to_world = (model.eq_obj1id == WORLD) | (model.eq_obj2id == WORLD)
        yield "a weld to the world", self.turned and bool(np.any((model.eq_type == WELD) & to_world))

    def applied(self, model: mujoco.MjModel) -> mujoco.MjModel:
        """A copy of a model as this similarity makes it."""
        made = copy.copy(model)
        self._rescale(made)
        if self.turned:
            self._turn(made)
        return made

    def _rescale(self, made: mujoco.MjModel) -> None:
        for names, factor in ((LENGTHS, self.length), (MASSES, self.mass)):
            for name in names:
                if hasattr(made, name):
                    getattr(made, name)[:] *= factor
        for name in WIDTHS:
            getattr(made, name)[:, 2] *= self.length
        angular = self.length**2
        made.body_inertia[:] *= self.mass * angular
        made.body_invweight0[:] /= self.mass * np.array([1.0, angular])
        made.tendon_invweight0[:] /= self.mass
        made.geom_friction[:, 1:] *= self.length
        made.opt.gravity[:] *= self.length
        made.eq_data[made.eq_type == CONNECT, :6] *= self.length
        if made.nu:
            for name in ("gainprm", "biasprm", "forcerange", "damping", "armature"):
                getattr(made, f"actuator_{name}", made.actuator_biasprm[:0])[:] *= self.mass * angular
        self._by_coordinate(made)

    def _by_coordinate(self, made: mujoco.MjModel) -> None:
        """Fields whose unit depends on whether the coordinate is a length or an angle."""
        kind = made.jnt_type[made.dof_jntid]
        linear = (kind == SLIDE) | ((kind == FREE) & (np.arange(made.nv) - made.jnt_dofadr[made.dof_jntid] < 3))
        inertia = self.mass * np.where(linear, 1.0, self.length**2)
        for name in ("dof_armature", "dof_damping", "dof_M0"):
            getattr(made, name)[:] *= inertia
        made.dof_invweight0[:] /= inertia
        made.dof_frictionloss[:] *= inertia * np.where(linear, self.length, 1.0)
        of_joint = linear[made.jnt_dofadr]
        made.jnt_stiffness[:] *= self.mass * np.where(of_joint, 1.0, self.length**2)
        made.jnt_actfrcrange[:] *= (self.mass * np.where(of_joint, self.length, self.length**2))[:, None]
        reach = np.where(of_joint, self.length, 1.0)
        made.jnt_range[:] *= reach[:, None]
        made.jnt_margin[:] *= reach
        made.jnt_solimp[:, 2] *= reach
        for name in ("qpos0", "qpos_spring"):
            getattr(made, name)[:] = self.positions(made, getattr(made, name))

    def _turn(self, made: mujoco.MjModel) -> None:
        turn = np.array(self.turn)
        for kind, owner in (("body", made.body_parentid), ("geom", made.geom_bodyid), ("site", made.site_bodyid)):
            places, rotations = getattr(made, f"{kind}_pos"), getattr(made, f"{kind}_quat")
            for index in np.flatnonzero(owner == WORLD):
                if kind == "body" and index == WORLD:
                    continue
                places[index] = _rotated(turn, places[index])
                rotations[index] = _product(turn, rotations[index])
                if kind != "body":  # MuJoCo skips the rotation of what stood at its body's frame
                    getattr(made, f"{kind}_sameframe")[index] = NO_SAME_FRAME
        of_bodies = (made.eq_type == CONNECT) & ~older.of_sites(made)
        for objects, columns in ((made.eq_obj1id, slice(0, 3)), (made.eq_obj2id, slice(3, 6))):
            for index in np.flatnonzero(of_bodies & (objects == WORLD)):
                made.eq_data[index, columns] = _rotated(turn, made.eq_data[index, columns])
        made.opt.gravity[:] = _rotated(turn, made.opt.gravity)

    # -- states --------------------------------------------------------------------------------------------------------

    def positions(self, model: mujoco.MjModel, coordinates: Array) -> Array:
        """Coordinates (nq,) of a model as they are in its image."""
        made = np.array(coordinates)
        for kind, at in zip(model.jnt_type, model.jnt_qposadr, strict=True):
            if kind == SLIDE:
                made[at] *= self.length
            if kind == FREE:
                made[at : at + 3] = self.length * _rotated(np.array(self.turn), made[at : at + 3])
                made[at + 3 : at + 7] = _product(np.array(self.turn), made[at + 3 : at + 7])
        return made

    def rates(self, model: mujoco.MjModel) -> Array:
        """Matrix (nv, nv) from rates, or accelerations, to those of the image."""
        made = np.eye(model.nv)
        for kind, at in zip(model.jnt_type, model.jnt_dofadr, strict=True):
            if kind == SLIDE:
                made[at, at] = self.length
            if kind == FREE:
                axes = [_rotated(np.array(self.turn), axis) for axis in np.eye(3)]
                made[at : at + 3, at : at + 3] = self.length * np.column_stack(axes)
        return made


def _rotated(turn: Array, vector: Array) -> Array:
    made = np.empty(3)
    mujoco.mju_rotVecQuat(made, np.asarray(vector, dtype=float), turn)
    return made


def _product(first: Array, second: Array) -> Array:
    made = np.empty(4)
    mujoco.mju_mulQuat(made, first, np.asarray(second, dtype=float))
    return made
