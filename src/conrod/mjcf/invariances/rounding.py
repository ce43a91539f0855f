"""Accelerations at states of a run, what rounding may make of them.

At a state the accelerations minimise a strictly convex function, so they do not depend on how it is minimised, in which
coordinates, order or units. How far rounding may take them is measured before anything is changed: the coordinates and
rates of the state are rounded otherwise.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.runs import data_at

# Each number is off by up to so many units in the last place, as often, and the largest change counts so many times:
# a change reorders sums of some tens of terms, whose errors are of that size.
UNITS, DRAWS, MARGIN = 4, 8, 10.0
ITERATIONS = 100  # of Newton's method, which needs some ten at most; those of others are more


def converged(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy whose solver is Newton's method on dense matrices, and goes on to the end."""
    made = copy.copy(model)
    made.opt.solver, made.opt.jacobian = mujoco.mjtSolver.mjSOL_NEWTON, mujoco.mjtJacobian.mjJAC_DENSE
    made.opt.tolerance, made.opt.iterations = 0.0, max(ITERATIONS, made.opt.iterations)
    return made


def forward(model: mujoco.MjModel, state: Array) -> mujoco.MjData:
    """Fresh data at a state, with its accelerations, which the solver finds without a first guess."""
    data = data_at(model, state)
    data.qacc_warmstart[:] = 0.0
    mujoco.mj_forward(model, data)
    return data


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


def accelerations(model: mujoco.MjModel, state: Array) -> Accelerations:
    """Accelerations at a state, with the bound that rounding gives them."""
    found, random = Accelerations(model, forward(model, state)), np.random.default_rng(1)
    sizes = np.zeros(len(state))  # coordinates and rates come first
    sizes[: model.nq] = np.maximum(np.abs(state[: model.nq]), 1.0)
    sizes[model.nq : model.nq + model.nv] = state[model.nq : model.nq + model.nv]
    last_places = UNITS * np.finfo(float).eps * sizes
    draws = (state + last_places * random.uniform(-1.0, 1.0, len(state)) for _ in range(DRAWS))
    return replace(found, bound=MARGIN * max(found.off(forward(model, draw).qacc) for draw in draws))
