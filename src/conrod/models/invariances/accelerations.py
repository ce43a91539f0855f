"""Accelerations at states of a run: the bound that rounding gives them, and those of the machine described otherwise.

At a state the accelerations minimise a strictly convex function, so they do not depend on how it is minimised, in which
coordinates, order or units. How far rounding may take them is measured before anything is changed: the coordinates and
rates of the state are rounded otherwise.

The machine otherwise described has its masses in another unit, or is turned. A power of two changes no bit of a
product, so the unit is changed by one.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import mujoco
import numpy as np

from conrod.engines.mujoco import compat
from conrod.exact.motion import Array
from conrod.mjcf.runs import data_at_state

# Each number is off by up to so many units in the last place, as often, and the largest change counts so many times:
# a change reorders sums of some tens of terms, whose errors are of that size.
ROUNDING_UNITS, ROUNDING_DRAWS, ROUNDING_MARGIN = 4, 8, 10.0
MIN_ITERATIONS = 100  # of Newton's method, which needs some ten at most; those of others are more


def with_converged_solver(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy that solves by Newton's method on dense matrices with tolerance 0."""
    made = copy.copy(model)
    made.opt.solver, made.opt.jacobian = mujoco.mjtSolver.mjSOL_NEWTON, mujoco.mjtJacobian.mjJAC_DENSE
    made.opt.tolerance, made.opt.iterations = 0.0, max(MIN_ITERATIONS, made.opt.iterations)
    return made


def forward(model: mujoco.MjModel, state: Array) -> mujoco.MjData:
    """Compute fresh data at a state with its accelerations, solved without a warm start."""
    data = data_at_state(model, state)
    data.qacc_warmstart[:] = 0.0
    mujoco.mj_forward(model, data)
    return data


@dataclass(frozen=True, eq=False)
class Accelerations:
    """Accelerations of a model at a state, and a norm for their difference from others.

    Attributes:
        data: MuJoCo's data at the state, with the accelerations.
        bound: largest difference that rounding may make, in the norm.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    bound: float = 0.0

    def difference(self, others: Array) -> float:
        """Norm of the difference d from other accelerations (nv,): sqrt(d' M d), M the mass matrix."""
        return self._norm(others - self.data.qacc)

    @property
    def size(self) -> float:
        """Norm of the accelerations a: sqrt(a' M a)."""
        return self._norm(self.data.qacc)

    def _norm(self, vector: Array) -> float:
        momenta = np.empty(self.model.nv)
        mujoco.mj_mulM(self.model, self.data, momenta, vector)
        return math.sqrt(max(float(vector @ momenta), 0.0))


def accelerations(model: mujoco.MjModel, state: Array) -> Accelerations:
    """Accelerations at a state, with the bound that rounding gives them."""
    found, random = Accelerations(model, forward(model, state)), np.random.default_rng(1)
    sizes = np.zeros(len(state))  # coordinates and rates come first
    sizes[: model.nq] = np.maximum(np.abs(state[: model.nq]), 1.0)
    sizes[model.nq : model.nq + model.nv] = state[model.nq : model.nq + model.nv]
    last_places = ROUNDING_UNITS * np.finfo(float).eps * sizes
    draws = (state + last_places * random.uniform(-1.0, 1.0, len(state)) for _ in range(ROUNDING_DRAWS))
    largest = max(found.difference(forward(model, draw).qacc) for draw in draws)
    # At a symmetric state no rounding of it may show, and accelerations are numbers that are rounded themselves.
    return replace(found, bound=ROUNDING_MARGIN * max(largest, ROUNDING_UNITS * np.finfo(float).eps * found.size))


FREE, SLIDE = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_SLIDE)
CONNECT, WELD = (int(getattr(mujoco.mjtEq, f"mjEQ_{kind}")) for kind in ("CONNECT", "WELD"))
WORLD, NO_SAME_FRAME = 0, 0  # the latter is mjSAMEFRAME_NONE, a name that 3.2.2 does not have yet
MASS_FIELDS = (  # fields in proportion to the unit of mass, and in inverse proportion
    "body_mass", "body_subtreemass", "body_inertia", "dof_armature", "dof_damping", "dof_M0", "dof_frictionloss",
    "jnt_stiffness", "jnt_actfrcrange", "tendon_stiffness", "tendon_damping", "tendon_frictionloss", "tendon_armature",
    "geom_adhesion", "pair_adhesion",
    "actuator_gainprm", "actuator_biasprm", "actuator_forcerange", "actuator_damping", "actuator_armature",
)  # fmt: skip
INVERSE_MASS_FIELDS = ("body_invweight0", "dof_invweight0", "tendon_invweight0")
# Which a model may have and a similarity does not know: counts, or fields that must be 0.
UNSUPPORTED_COUNTS = ("nflex", "nplugin", "nmocap", "nhfield", "na")
UNSUPPORTED_FIELDS = (
    "dof_dampingpoly", "jnt_stiffnesspoly", "tendon_dampingpoly", "tendon_stiffnesspoly", "actuator_dampingpoly",
    "jnt_springyield", "tendon_springyield",
)  # fmt: skip
LINEAR_GAINS = tuple(int(getattr(mujoco.mjtGain, f"mjGAIN_{kind}")) for kind in ("FIXED", "AFFINE"))
LINEAR_BIASES = tuple(int(getattr(mujoco.mjtBias, f"mjBIAS_{kind}")) for kind in ("NONE", "AFFINE"))


@dataclass(frozen=True)
class Similarity:
    """A rotation of the world by a unit quaternion, with a factor on all masses."""

    mass: float = 1.0
    turn: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

    @property
    def turned(self) -> bool:
        """True if the world is rotated."""
        return self.turn != (1.0, 0.0, 0.0, 0.0)

    @cached_property
    def rotation(self) -> Array:
        """Rotation matrix of the world (3, 3)."""
        made = np.empty(9)
        mujoco.mju_quat2Mat(made, np.array(self.turn))
        return made.reshape(3, 3)

    def refusal(self, model: mujoco.MjModel) -> str:
        """A feature of the model that the similarity does not support; empty if it supports all."""
        return next((words for words, has in self._unsupported_features(model) if has), "")

    def _unsupported_features(self, model: mujoco.MjModel) -> Iterator[tuple[str, bool]]:
        yield from ((f"the model has {name} > 0", bool(getattr(model, name, 0))) for name in UNSUPPORTED_COUNTS)
        yield from ((f"the model has {name}", bool(np.any(getattr(model, name, 0.0)))) for name in UNSUPPORTED_FIELDS)
        yield "the model has a fluid", bool(model.opt.density or model.opt.viscosity)
        of_joints = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)
        right = model.jnt_type[model.actuator_trnid[of_joints, 0]] >= SLIDE
        yield "an actuator acts on something else than a hinge or a slide", not (of_joints.all() and right.all())
        linear = np.isin(model.actuator_gaintype, LINEAR_GAINS) & np.isin(model.actuator_biastype, LINEAR_BIASES)
        yield "an actuator's force is not linear in its numbers", not linear.all()
        to_world = (model.eq_obj1id == WORLD) | (model.eq_obj2id == WORLD)
        yield "a weld to the world", self.turned and bool(np.any((model.eq_type == WELD) & to_world))

    def apply(self, model: mujoco.MjModel) -> mujoco.MjModel:
        """A copy of a model with the similarity applied."""
        made = copy.copy(model)
        for names, factor in ((MASS_FIELDS, self.mass), (INVERSE_MASS_FIELDS, 1.0 / self.mass)):
            for name in names:
                if hasattr(made, name):
                    getattr(made, name)[:] *= factor
        made.stat.meanmass, made.stat.meaninertia = self.mass * made.stat.meanmass, self.mass * made.stat.meaninertia
        if self.turned:
            self._rotate_world(made)
        return made

    def _rotate_world(self, made: mujoco.MjModel) -> None:
        for kind, owner in (("body", made.body_parentid), ("geom", made.geom_bodyid), ("site", made.site_bodyid)):
            places, rotations = getattr(made, f"{kind}_pos"), getattr(made, f"{kind}_quat")
            of_world = np.flatnonzero(owner == WORLD)
            for index in of_world[1:] if kind == "body" else of_world:  # the world is its own parent
                places[index] = self.rotation @ places[index]
                rotations[index] = self._rotate(rotations[index])
                if kind != "body":  # MuJoCo skips the rotation of what stood at its body's frame
                    getattr(made, f"{kind}_sameframe")[index] = NO_SAME_FRAME
        of_bodies = (made.eq_type == CONNECT) & ~compat.site_equalities(made)
        for objects, columns in ((made.eq_obj1id, slice(0, 3)), (made.eq_obj2id, slice(3, 6))):
            anchors = made.eq_data[:, columns]
            anchors[of_bodies & (objects == WORLD)] @= self.rotation.T
        # The boxes around the world's geoms (bvh_aabb) stay where they were compiled: contacts are sought without.
        made.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MIDPHASE)
        made.opt.gravity[:] = self.rotation @ made.opt.gravity
        for name in ("qpos0", "qpos_spring"):
            getattr(made, name)[:] = self.positions(made, getattr(made, name))

    def _rotate(self, rotation: Array) -> Array:
        made = np.empty(4)
        mujoco.mju_mulQuat(made, np.array(self.turn), np.asarray(rotation, dtype=float))
        return made

    # -- states --------------------------------------------------------------------------------------------------------

    def positions(self, model: mujoco.MjModel, coordinates: Array) -> Array:
        """Coordinates (nq,) of a model transformed by the similarity."""
        made = np.array(coordinates)
        for at in model.jnt_qposadr[model.jnt_type == FREE]:
            made[at : at + 3] = self.rotation @ made[at : at + 3]
            made[at + 3 : at + 7] = self._rotate(made[at + 3 : at + 7])
        return made

    def rate_matrix(self, model: mujoco.MjModel) -> Array:
        """Matrix (nv, nv) that transforms rates, or accelerations, by the similarity."""
        made = np.eye(model.nv)
        for at in model.jnt_dofadr[model.jnt_type == FREE]:
            made[at : at + 3, at : at + 3] = self.rotation
        return made
