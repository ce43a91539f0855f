"""MuJoCo steps, and its states are kept, with its warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import mujoco
import numpy as np

from conrod.engines.mujoco import older
from conrod.engines.mujoco.model import Build, laws_acting
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.exact.motion import Array
from conrod.runs.outcome import Verdict
from conrod.runs.trajectory import Outcome

# What MuJoCo warns of where it resets the state, if it may.
BAD_NUMBERS = ("BADQPOS", "BADQVEL", "BADQACC")


def ended_by_engine(
    clock: Array, first: int, before: float, warnings: Mapping[str, int], settings: MuJoCoSettings
) -> Verdict | None:
    """The end that MuJoCo made after a warning, by its clock: its own reset starts it again, a stop lets it stand.

    Args:
        clock: of the engine at consecutive samples (T,) [s].
        first: index in the run of the first of them.
        before: the clock at the sample before that.
        warnings: of the engine, by name, up to the last sample.
    """
    if not np.all(np.isfinite(clock)):
        return None
    # The clock sums its steps, so over a long run it is off by many of them: each is judged by itself.
    steps = np.diff(clock, prepend=before)
    off = np.abs(steps - settings.timestep) > 0.5 * settings.timestep
    if not off.any():
        return None
    at = int(np.argmax(off))
    if steps[at] < 0.0:
        return Verdict(Outcome.RESET, f"the engine reset its state at step {first + at}")
    if older.resets_by_itself(settings) and any(name in warnings for name in BAD_NUMBERS):
        # In the first step there is nothing yet that a clock could fall back from.
        return Verdict(Outcome.RESET, f"the engine reset its state at step {first + at - 1}")
    return Verdict(Outcome.DIVERGED, f"the engine warned of bad numbers and stopped at step {first + at}")


STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS  # time, coordinates, rates
WARNINGS = {name.removeprefix("mjWARN_"): int(kind) for name, kind in mujoco.mjtWarning.__members__.items()}
del WARNINGS["mjNWARNING"]


def warnings_of(data: mujoco.MjData) -> dict[str, int]:
    """Warnings of the engine, by name, and how often each came."""
    counted = {name: int(data.warning[kind].number) for name, kind in WARNINGS.items()}
    return {name: number for name, number in counted.items() if number}


def bad_numbers(data: mujoco.MjData) -> list[str]:
    """Warnings after which the numbers of a run mean nothing, that there were."""
    return [name for name in BAD_NUMBERS if data.warning[WARNINGS[name]].number]


class Recorder:
    """A machine that is stepped from a state of its model, by as many samples at a time as one likes.

    At the engine's first warning it stands still, as MuJoCo's own rollouts do.

    Args:
        begin: the time [s] of the start, at which the engine's clock is 0.
    """

    def __init__(self, made: Build, coordinates: Array, rates: Array, begin: float = 0.0) -> None:
        self._made, self._begin = made, begin
        self._model, self._data = made.model, mujoco.MjData(made.model)
        self._data.qpos[:], self._data.qvel[:] = coordinates, rates
        self._state = np.empty(mujoco.mj_stateSize(self._model, STATE))  # that the next step starts from
        mujoco.mj_getState(self._model, self._data, self._state, STATE)

    @property
    def warnings(self) -> dict[str, int]:
        """Warnings of the engine since the start, and how often each came."""
        return warnings_of(self._data)

    def next(self, samples: int) -> tuple[Array, Array]:
        """The next T samples, at least one: states (T, nstate), the first of which is that of now, sensor data (T, ..).

        After a step, sensor data belongs to the instant before it: the step that leaves a sample gives its sensors, so
        that the engine is one step ahead of the reported samples.
        """
        states = np.empty((1, samples + 1, len(self._state)))
        sensors = np.empty((1, samples, self._model.nsensordata))
        states[0, 0] = self._state
        with warnings_kept_quiet(), laws_acting(self._model, self._made.tree, self._begin):
            if self.warnings:
                # Another rollout would clear the counters and go on.
                states[0, 1:], sensors[0] = states[0, 0], self._data.sensordata
            else:
                # The accelerations of the last step are the solver's first guess in the next: without them a run made
                # in pieces would not be the same to the last bit.
                guess = self._data.qacc_warmstart[None].copy()
                older.roll_out(self._model, self._data, states[:, 0], guess, states[:, 1:], sensors)
        self._state = states[0, -1].copy()
        return states[0, :-1], sensors[0]


@contextmanager
def warnings_kept_quiet() -> Iterator[None]:
    """MuJoCo writes a log file into the working folder at a warning; a run's outcome says more, and litters nothing."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)
