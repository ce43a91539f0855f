"""A compiled model with its crank held: its own constraints, solved by Newton iteration, place everything else."""

from __future__ import annotations

import copy
from collections.abc import Callable

import mujoco
import numpy as np

from conrod.engines.mobility import jacobian_rank
from conrod.engines.mujoco.mobility import equality_jacobian
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.loading import name_or_number
from conrod.own.models.points import Crank

NEWTON_STEPS = 40
# A step of the iteration this small, against the largest coordinate, is rounding.
CLOSED = 1e-13
# The crank goes on by two degrees; where the rest does not follow its tangent within a fifth of the way, by less.
STEP, LEAST_STEP, STRAYED = np.radians(2.0), 1e-7, 0.2
# Below this a movement is rounding, whatever share of the way it is.
NOTHING = 1e-9

NOT_KINEMATIC = (
    mujoco.mjtDisableBit.mjDSBL_CONTACT
    | mujoco.mjtDisableBit.mjDSBL_LIMIT
    | mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
    | mujoco.mjtDisableBit.mjDSBL_SENSOR
)


class Assembly:
    """A copy of a model in which nothing but the closures acts; `data` is at the pose that was placed last.

    Attributes:
        place_rest: places what the closures leave free, where a contact does that; None otherwise.
    """

    def __init__(self, model: mujoco.MjModel, crank: Crank) -> None:
        self.model = copy.copy(model)
        self.model.opt.disableflags |= int(NOT_KINEMATIC)
        self.data = mujoco.MjData(self.model)
        self.crank = crank
        self.free = np.array([i for i in range(model.nv) if i != crank.rate], dtype=int)
        self.place_rest: Callable[[], None] | None = None

    # -- one pose ----------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Close the loops with the crank where it is.

        Raises:
            InvalidInput: they cannot be closed.
        """
        for _ in range(NEWTON_STEPS):
            step = self._newton_step()
            self._move(step)
            if not np.all(np.isfinite(self.data.qpos)):
                break
            if np.abs(step).max(initial=0.0) <= CLOSED * (1.0 + np.abs(self.data.qpos).max()):
                mujoco.mj_fwdPosition(self.model, self.data)
                return
        raise InvalidInput(f"its loops do not close with the crank at {self._degrees():.6g} deg: {self.gap()[1]}")

    def _newton_step(self) -> Array:
        """Change of the joint rates' coordinates (nv,), none of the crank."""
        mujoco.mj_fwdPosition(self.model, self.data)
        step = np.zeros(self.model.nv)
        jacobian = self.jacobian()
        if len(jacobian) and np.all(np.isfinite(jacobian)):
            step[self.free] = -np.linalg.lstsq(jacobian[:, self.free], self.violation(), rcond=1e-10)[0]
        return step

    def _move(self, by: Array) -> None:
        mujoco.mj_integratePos(self.model, self.data.qpos, by, 1.0)

    def jacobian(self) -> Array:
        """Of the closures (rows, nv)."""
        return equality_jacobian(self.model, self.data)

    def violation(self) -> Array:
        """Of the closures (rows,)."""
        rows = self.data.efc_type[: self.data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        return np.array(self.data.efc_pos[: self.data.nefc][rows])

    def gap(self) -> tuple[float, str]:
        """Largest violation of a closure, and which one has it."""
        size = np.abs(self.violation())
        if not size.size:
            return 0.0, ""
        rows = self.data.efc_type[: self.data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        worst = int(np.argmax(size))
        owner = int(self.data.efc_id[: self.data.nefc][rows][worst])
        return float(size[worst]), name_or_number(self.model, "equality", owner)

    # -- along the motion --------------------------------------------------------------------------------------

    def rates(self) -> Array:
        """Joint rates (nv,) that the closures leave at a crank rate of one; the contact's part is not in it."""
        rates = np.zeros(self.model.nv)
        rates[self.crank.rate] = 1.0
        jacobian = self.jacobian()
        if len(jacobian):
            rates[self.free] = np.linalg.lstsq(jacobian[:, self.free], -jacobian[:, self.crank.rate], rcond=1e-10)[0]
        return rates

    def left_free(self) -> Array:
        """Directions (k, nv) in which the closures let the model move with the crank held."""
        jacobian = self.jacobian()[:, self.free]
        if not len(jacobian):
            directions = np.eye(len(self.free))
        else:
            rank = jacobian_rank(jacobian)
            directions = np.linalg.svd(jacobian)[2][rank:]
        every = np.zeros((len(directions), self.model.nv))
        every[:, self.free] = directions
        return every

    def coordinate(self) -> float:
        """Of the crank [rad]."""
        return float(self.data.qpos[self.crank.coordinate])

    def go(self, goal: float) -> None:
        """Turn the crank to a coordinate; the rest follows without leaving its branch.

        Raises:
            InvalidInput: it goes no further.
        """
        step = float(np.copysign(STEP, goal - self.coordinate()))
        while self.coordinate() != goal:
            here, before = self.coordinate(), self.data.qpos.copy()
            following = goal if abs(goal - here) <= abs(step) else here + step
            if self._try_step(following):
                step = float(np.copysign(min(2.0 * abs(step), STEP), step))
                continue
            self.data.qpos[:] = before
            mujoco.mj_fwdPosition(self.model, self.data)
            step *= 0.5
            if abs(step) < LEAST_STEP:
                held = "the closures hold it, and a crank turns fully"
                raise InvalidInput(f"its crank goes no further than {self._degrees():.6g} deg: {held}")

    def _try_step(self, following: float) -> bool:
        tangent = self.rates() * (following - self.coordinate())
        self._move(tangent)
        self.data.qpos[self.crank.coordinate] = following
        predicted = self.data.qpos.copy()
        try:
            self.close()
        except InvalidInput:
            return False
        strayed = np.empty(self.model.nv)
        mujoco.mj_differentiatePos(self.model, strayed, 1.0, predicted, self.data.qpos)
        if np.abs(strayed).max() > STRAYED * np.abs(tangent).max() + NOTHING:
            return False
        if self.place_rest is not None:
            self.place_rest()
        return True

    def _degrees(self) -> float:
        return float(np.degrees(self.coordinate()))
