"""Accelerations at states of a run, what rounding may make of them, and what a solver left undone.

At a state the accelerations minimise a strictly convex function, so they do not depend on how it is minimised, in which
coordinates, order or units. How far rounding may take them is measured before anything is changed: all numbers of the
model and of the state are rounded otherwise.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from conrod.exact.motion import Array

# Each number is off by up to so many units in the last place, as often, and the largest change counts so many times:
# a change reorders sums of some tens of terms, whose errors are of that size.
UNITS, DRAWS, MARGIN = 4, 8, 10.0
ITERATIONS = 100  # of Newton's method, which needs some ten at most; those of others are more
ROUNDED = (
    "body_pos", "body_quat", "body_ipos", "body_iquat", "body_mass", "body_inertia", "body_invweight0", "jnt_pos",
    "jnt_axis", "jnt_stiffness", "jnt_range", "dof_armature", "dof_damping", "dof_frictionloss", "dof_invweight0",
    "tendon_stiffness", "tendon_damping", "tendon_invweight0", "geom_pos", "geom_quat", "geom_size", "geom_friction",
    "site_pos", "site_quat", "eq_data", "eq_solref", "eq_solimp", "wrap_prm", "actuator_gainprm", "actuator_biasprm",
)  # fmt: skip

Put = Callable[[mujoco.MjData], None]  # brings data to a state


def converged(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy whose solver is Newton's method on dense matrices, and goes on to the end."""
    made = copy.copy(model)
    made.opt.solver, made.opt.jacobian = mujoco.mjtSolver.mjSOL_NEWTON, mujoco.mjtJacobian.mjJAC_DENSE
    made.opt.tolerance, made.opt.iterations = 0.0, max(ITERATIONS, made.opt.iterations)
    return made


@dataclass(frozen=True, eq=False)
class Accelerations:
    """Accelerations of a model at a state, and the norm in which others are compared with them.

    Attributes:
        data: at the state, with the accelerations.
        bound: of the difference that rounding may make, in the norm.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    bound: float = 0.0

    def off(self, others: Array) -> float:
        """Difference of other accelerations (nv,), in the norm of the kinetic energy."""
        return self._norm(others - self.data.qacc)

    @property
    def size(self) -> float:
        """Size of the accelerations, in the norm."""
        return self._norm(self.data.qacc)

    def _norm(self, vector: Array) -> float:
        return math.sqrt(max(float(vector @ self._momenta(vector)), 0.0))

    def _momenta(self, rates: Array) -> Array:
        found = np.empty(self.model.nv)
        mujoco.mj_mulM(self.model, self.data, found, rates)
        return found

    def undone(self, others: Array) -> float:
        """Largest distance from the minimum at which accelerations with their gradient can be, in the norm.

        The function's Hessian is at least the inertia M, so |a - a*|_M <= |gradient|_(1/M) (strong convexity).
        """
        aside, rows, changed = copy.copy(self.data), np.empty(self.data.nefc), np.empty((1, self.model.nv))
        mujoco.mj_mulJacVec(self.model, aside, rows, others)
        mujoco.mj_constraintUpdate(self.model, aside, rows - aside.efc_aref, None, 0)
        gradient = self._momenta(others) - aside.qfrc_smooth - aside.qfrc_constraint
        mujoco.mj_solveM(self.model, aside, changed, gradient[None])
        return math.sqrt(max(float(gradient @ changed[0]), 0.0))


def accelerations(model: mujoco.MjModel, put: Put) -> Accelerations:
    """Accelerations at the state that `put` makes of fresh data, with the bound that rounding gives them."""
    found, random = Accelerations(model, forward(model, put)), np.random.default_rng(1)
    changed = [found.off(forward(_rounded(model, random), put, random).qacc) for _ in range(DRAWS)]
    return replace(found, bound=MARGIN * max(changed))


def forward(model: mujoco.MjModel, put: Put, random: np.random.Generator | None = None) -> mujoco.MjData:
    """Fresh data at a state, with its accelerations; its coordinates and rates rounded otherwise where asked for."""
    data = mujoco.MjData(model)
    put(data)
    if random is not None:
        data.qpos[:] += _last_places(np.maximum(np.abs(data.qpos), 1.0), random)
        data.qvel[:] += _last_places(data.qvel, random)
    mujoco.mj_forward(model, data)
    return data


def _rounded(model: mujoco.MjModel, random: np.random.Generator) -> mujoco.MjModel:
    made = copy.copy(model)
    for name in ROUNDED:
        values = getattr(made, name)
        if values.size and values.ndim == 2 and name not in ("geom_size", "eq_solimp", "eq_solref"):
            # A turned vector has none of its zeros any more.
            values += _last_places(np.broadcast_to(np.linalg.norm(values, axis=1)[:, None], values.shape), random)
        elif values.size:
            values += _last_places(values, random)
    made.opt.gravity[:] += _last_places(np.full(3, np.linalg.norm(made.opt.gravity)), random)
    return made


def _last_places(values: Array, random: np.random.Generator) -> Array:
    return UNITS * np.finfo(float).eps * values * random.uniform(-1.0, 1.0, np.shape(values))
