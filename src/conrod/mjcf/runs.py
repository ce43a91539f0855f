"""States of compiled models, what ends a run, and a stepper that begins again where a run ends."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import WARNINGS, warnings_kept_quiet
from conrod.exact.motion import Array

KINDS = mujoco.mjtState
# All that the next step depends on, and what acts from outside; models that differ by sensors or closures share it.
STATE = int(
    KINDS.mjSTATE_QPOS
    | KINDS.mjSTATE_QVEL
    | KINDS.mjSTATE_ACT
    | KINDS.mjSTATE_WARMSTART
    | KINDS.mjSTATE_CTRL
    | KINDS.mjSTATE_MOCAP_POS
    | KINDS.mjSTATE_MOCAP_QUAT
)
# Warnings after which the numbers of a run mean nothing.
BROKEN = ("BADQPOS", "BADQVEL", "BADQACC")


def state_of(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """The state (n,) of data, coordinates and rates first."""
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    return state


def data_at(model: mujoco.MjModel, state: Array) -> mujoco.MjData:
    """New data in a state."""
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, state, STATE)
    return data


def broken(data: mujoco.MjData) -> str:
    """Reason why a run has broken off: MuJoCo's warning, or "not finite"; empty where it has not."""
    warned = next((name for name in BROKEN if data.warning[WARNINGS[name]].number), "")
    return warned or ("" if np.all(np.isfinite(data.qpos)) else "not finite")


def looping_stepper(model: mujoco.MjModel, start: Array, most: int) -> Callable[[], Callable[[int], None]]:
    """Maker of a function that makes so many steps of the same run, again and again.

    Args:
        start: state that the run starts from.
        most: steps of the run; what comes after it is not what the model is for.
    """

    def make() -> Callable[[int], None]:
        data, done = data_at(model, start), 0

        def advance(steps: int) -> None:
            nonlocal done
            with warnings_kept_quiet():
                while steps:
                    if done == most:
                        mujoco.mj_resetData(model, data)
                        mujoco.mj_setState(model, data, start, STATE)
                        done = 0
                    some = min(steps, most - done)
                    mujoco.mj_step(model, data, some)
                    done, steps = done + some, steps - some

        return advance

    return make
