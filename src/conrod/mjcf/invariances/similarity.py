"""The same machine with masses in another unit, or turned: a compiled model, its states and its accelerations.

A power of two changes no bit of a product, so the unit is changed by one.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.engines.mujoco import older
from conrod.exact.motion import Array

FREE, SLIDE = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_SLIDE)
CONNECT, WELD = (int(getattr(mujoco.mjtEq, f"mjEQ_{kind}")) for kind in ("CONNECT", "WELD"))
WORLD, NO_SAME_FRAME = 0, 0  # the latter is mjSAMEFRAME_NONE, a name that 3.2.2 does not have yet
MASSES = (  # fields in proportion to the unit of mass, and in inverse proportion
    "body_mass", "body_subtreemass", "body_inertia", "dof_armature", "dof_damping", "dof_M0", "dof_frictionloss",
    "jnt_stiffness", "jnt_actfrcrange", "tendon_stiffness", "tendon_damping", "tendon_frictionloss", "tendon_armature",
    "actuator_gainprm", "actuator_biasprm", "actuator_forcerange", "actuator_damping", "actuator_armature",
)  # fmt: skip
INVERSE_MASSES = ("body_invweight0", "dof_invweight0", "tendon_invweight0")
# Which a model may have and a similarity does not know: counts, or fields that must be 0.
NEVER = ("nflex", "nplugin", "nmocap", "nhfield", "na")
ZERO = ("dof_dampingpoly", "jnt_stiffnesspoly", "tendon_dampingpoly", "tendon_stiffnesspoly", "actuator_dampingpoly")


@dataclass(frozen=True)
class Similarity:
    """A rotation of the world, a unit quaternion, and a factor of all numbers of mass."""

    mass: float = 1.0
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
        of_joints = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)
        right = model.jnt_type[model.actuator_trnid[of_joints, 0]] >= SLIDE
        yield "an actuator acts on something else than a hinge or a slide", not (of_joints.all() and right.all())
        to_world = (model.eq_obj1id == WORLD) | (model.eq_obj2id == WORLD)
        yield "a weld to the world", self.turned and bool(np.any((model.eq_type == WELD) & to_world))

    def applied(self, model: mujoco.MjModel) -> mujoco.MjModel:
        """A copy of a model as this similarity makes it."""
        made = copy.copy(model)
        for names, factor in ((MASSES, self.mass), (INVERSE_MASSES, 1.0 / self.mass)):
            for name in names:
                if hasattr(made, name):
                    getattr(made, name)[:] *= factor
        if self.turned:
            self._turn(made)
        return made

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
        for name in ("qpos0", "qpos_spring"):
            getattr(made, name)[:] = self.positions(made, getattr(made, name))

    # -- states --------------------------------------------------------------------------------------------------------

    def positions(self, model: mujoco.MjModel, coordinates: Array) -> Array:
        """Coordinates (nq,) of a model as they are in its image."""
        made = np.array(coordinates)
        for kind, at in zip(model.jnt_type, model.jnt_qposadr, strict=True):
            if kind == FREE:
                made[at : at + 3] = _rotated(np.array(self.turn), made[at : at + 3])
                made[at + 3 : at + 7] = _product(np.array(self.turn), made[at + 3 : at + 7])
        return made

    def rates(self, model: mujoco.MjModel) -> Array:
        """Matrix (nv, nv) from rates, or accelerations, to those of the image."""
        made = np.eye(model.nv)
        for kind, at in zip(model.jnt_type, model.jnt_dofadr, strict=True):
            if kind == FREE:
                axes = [_rotated(np.array(self.turn), axis) for axis in np.eye(3)]
                made[at : at + 3, at : at + 3] = np.column_stack(axes)
        return made


def _rotated(turn: Array, vector: Array) -> Array:
    made = np.empty(3)
    mujoco.mju_rotVecQuat(made, np.asarray(vector, dtype=float), turn)
    return made


def _product(first: Array, second: Array) -> Array:
    made = np.empty(4)
    mujoco.mju_mulQuat(made, first, np.asarray(second, dtype=float))
    return made
