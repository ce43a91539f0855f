"""Steps of a model that can be looked at where each of them starts, as `mj_step` makes them to the last bit."""

from __future__ import annotations

import mujoco
import numpy as np

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
EULER, RK4 = mujoco.mjtIntegrator.mjINT_EULER, mujoco.mjtIntegrator.mjINT_RK4
IMPLICIT = (mujoco.mjtIntegrator.mjINT_IMPLICIT, mujoco.mjtIntegrator.mjINT_IMPLICITFAST)


class Stepper:
    """A model that is stepped; `data` holds the state of now.

    A step is the accelerations of now, then the integrator. To look in between costs nothing, and gives position,
    velocity and acceleration of one instant: what `mj_step` leaves of them does not belong together, under RK4 least
    of all. Where the integrator is not one that can be called by itself, another data object is looked at.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._kind = mujoco.mjtIntegrator(int(model.opt.integrator))
        self._aside = None if self._kind in (EULER, RK4, *IMPLICIT) else mujoco.MjData(model)
        self._state = np.empty(mujoco.mj_stateSize(model, STATE))

    def look(self) -> mujoco.MjData:
        """Data with all of now in it, up to the accelerations of bodies; to be read only."""
        data = self._data if self._aside is None else self._aside
        if self._aside is None:
            mujoco.mj_checkPos(self._model, data)
            mujoco.mj_checkVel(self._model, data)
        else:
            mujoco.mj_getState(self._model, self._data, self._state, STATE)
            mujoco.mj_setState(self._model, data, self._state, STATE)
        mujoco.mj_forward(self._model, data)
        if self._aside is None:
            mujoco.mj_checkAcc(self._model, data)
        mujoco.mj_rnePostConstraint(self._model, data)
        return data

    def step(self) -> None:
        """On by a step, after a look."""
        if self._aside is not None:
            mujoco.mj_step(self._model, self._data)
        elif self._kind == RK4:
            mujoco.mj_RungeKutta(self._model, self._data, 4)
        elif self._kind == EULER:
            mujoco.mj_Euler(self._model, self._data)
        else:
            mujoco.mj_implicit(self._model, self._data)
