"""MuJoCo steps, and the states that it takes are kept. Nothing is written into it after the start."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
from mujoco import rollout

from conrod.engines.mujoco.load_laws import laws_acting
from conrod.engines.mujoco.model import Build
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.mujoco.solver_state import solver_state
from conrod.motion import Array
from conrod.trajectory import SolverState

STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS  # time, coordinates, rates
WARNINGS = {name.removeprefix("mjWARN_"): int(kind) for name, kind in mujoco.mjtWarning.__members__.items()}
del WARNINGS["mjNWARNING"]


class Recorder:
    """A machine that is stepped from a state of its model, by as many samples at a time as one likes.

    At the engine's first warning it stands still, as MuJoCo's own rollouts do.

    Args:
        begin: the time [s] of the start, at which the engine's clock is 0.

    Attributes:
        solver: how the constraint solver ended for the accelerations of the last sample told; None where there was
            nothing to solve, or no step any more.
    """

    def __init__(
        self, made: Build, settings: MuJoCoSettings, coordinates: Array, rates: Array, begin: float = 0.0
    ) -> None:
        self.solver: SolverState | None = None
        self._made, self._begin = made, begin
        self._model, self._data = made.model, mujoco.MjData(made.model)
        self._aside = mujoco.MjData(made.model)  # to look at the solver without a trace in the run
        self._data.qpos[:], self._data.qvel[:] = coordinates, rates
        self._step = self._round_steps if settings.rounded_state else self._roll_out
        self._state = np.empty(mujoco.mj_stateSize(self._model, STATE))  # that the next step starts from
        mujoco.mj_getState(self._model, self._data, self._state, STATE)

    @property
    def state(self) -> Array:
        """The state (nstate,) that the next sample will tell."""
        return self._state

    @property
    def warnings(self) -> dict[str, int]:
        """What the engine has warned of since the start, and how often."""
        counted = {name: int(self._data.warning[kind].number) for name, kind in WARNINGS.items()}
        return {name: number for name, number in counted.items() if number}

    def next(self, samples: int) -> tuple[Array, Array]:
        """The next T samples, at least one: states (T, nstate), the first of which is that of now, sensor data (T, ..).

        After a step, sensor data belongs to the instant before it: the step that leaves a sample gives its sensors, so
        that the engine is one step ahead of the samples told.
        """
        states = np.empty((1, samples + 1, len(self._state)))
        sensors = np.empty((1, samples, self._model.nsensordata))
        states[0, 0] = self._state
        with warnings_kept_quiet(), laws_acting(self._model, self._made.tree, self._begin):
            self._take(states[:, :-1], sensors[:, :-1])
            self.solver = self._look(states[0, -2])
            self._take(states[:, -2:], sensors[:, -1:])
        self._state = states[0, -1].copy()
        return states[0, :-1], sensors[0]

    def _take(self, states: Array, sensors: Array) -> None:
        """States (1, steps + 1, nstate) after the first one, and sensor data (1, steps, ..) of the states before."""
        if not sensors.shape[1]:
            return
        if self.warnings:
            # Another rollout would clear the counters and go on.
            states[0, 1:], sensors[0] = states[0, 0], self._data.sensordata
        else:
            self._step(states, sensors)

    def _roll_out(self, states: Array, sensors: Array) -> None:
        # The accelerations of the last step are the solver's first guess in the next: without them a run told in pieces
        # would not be the same to the last bit.
        guess = self._data.qacc_warmstart[None].copy()
        rollout.rollout(
            self._model,
            [self._data],
            states[:, 0],
            nstep=sensors.shape[1],
            initial_warmstart=guess,
            state=states[:, 1:],
            sensordata=sensors,
        )

    def _round_steps(self, states: Array, sensors: Array) -> None:
        """Coordinates and rates go to single precision after every step."""
        counters = self._data.warning
        for k in range(sensors.shape[1]):
            if counters.number.any():
                states[0, k + 1 :], sensors[0, k:] = states[0, k], self._data.sensordata
                return
            mujoco.mj_step(self._model, self._data)
            round_state(self._data)
            mujoco.mj_getState(self._model, self._data, states[0, k + 1], STATE)
            sensors[0, k] = self._data.sensordata

    def _look(self, state: Array) -> SolverState | None:
        """The solver in the step that leaves this state, which is that of now; under RK4 in its first stage."""
        if self.warnings:
            return None
        mujoco.mj_setState(self._model, self._aside, state, STATE)
        self._aside.qacc_warmstart[:] = self._data.qacc_warmstart
        mujoco.mj_forward(self._model, self._aside)
        return solver_state(self._model, self._aside)


def round_state(data: mujoco.MjData) -> None:
    """Coordinates and rates, and nothing else, to single precision."""
    # What is too large becomes infinite, which the engine and the run's outcome tell.
    with np.errstate(over="ignore"):
        data.qpos[:] = data.qpos.astype(np.float32)
        data.qvel[:] = data.qvel.astype(np.float32)


@contextmanager
def warnings_kept_quiet() -> Iterator[None]:
    """MuJoCo writes a log file into the working folder at a warning; a run's outcome says more, and litters nothing."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)
