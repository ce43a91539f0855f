"""Motion of a compiled MuJoCo model whose loops are exactly closed, without MuJoCo's constraint solver."""

from __future__ import annotations

import copy

import mujoco
import numpy as np

from conrod.engines.mujoco.model import equality_jacobian
from conrod.exact.motion import Array
from conrod.mjcf.runs import STATE


class ExactLoops:
    """The equations of motion with Lagrange multipliers for the equality constraints, nothing regularised.

    M a = f + J^T l, J a = a_ref (MuJoCo's: the velocity's part and Baumgarte's feedback), the redundant rows by least
    squares; stepped by the classical Runge-Kutta method. Contacts and limits do not act.
    """

    def __init__(self, model: mujoco.MjModel, state: Array, timestep: float) -> None:
        self.model = copy.copy(model)
        self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT)
        self.data = mujoco.MjData(self.model)
        mujoco.mj_setState(self.model, self.data, state, STATE)
        self.timestep = timestep
        self.q, self.v = self.data.qpos.copy(), self.data.qvel.copy()

    def step(self) -> None:
        h, q, v = self.timestep, self.q, self.v
        a1 = self.acceleration(q, v)
        v2 = v + h / 2 * a1
        a2 = self.acceleration(self.moved(q, h / 2 * v), v2)
        v3 = v + h / 2 * a2
        a3 = self.acceleration(self.moved(q, h / 2 * v2), v3)
        v4 = v + h * a3
        a4 = self.acceleration(self.moved(q, h * v3), v4)
        self.q = self.moved(q, h / 6 * (v + 2 * v2 + 2 * v3 + v4))
        self.v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)

    def moved(self, q: Array, by: Array) -> Array:
        result = q.copy()
        mujoco.mj_integratePos(self.model, result, by, 1.0)
        return result

    def acceleration(self, q: Array, v: Array) -> Array:
        data = self.data
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(self.model, data)
        jacobian = equality_jacobian(self.model, data)
        spread = np.zeros_like(jacobian)
        mujoco.mj_solveM(self.model, data, spread, jacobian)  # rows of J M^-1
        wanted = data.efc_aref[: len(jacobian)] - jacobian @ data.qacc_smooth
        multipliers = np.linalg.lstsq(spread @ jacobian.T, wanted, rcond=1e-13)[0]
        return np.asarray(data.qacc_smooth + spread.T @ multipliers)

    def points(self) -> Array:
        """(bodies, 3) centres of gravity of all that can move [m]."""
        self.data.qpos[:] = self.q
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        return self.data.xipos[self.model.body_weldid > 0].copy()
