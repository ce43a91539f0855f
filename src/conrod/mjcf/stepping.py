"""Stepping of compiled models: how a run breaks off, and a stepper that begins again where a run ends."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import WARNINGS, warnings_kept_quiet

# Warnings after which the numbers of a run mean nothing.
BROKEN = ("BADQPOS", "BADQVEL", "BADQACC")


def broken(data: mujoco.MjData) -> str:
    """Reason why a run has broken off: MuJoCo's warning, or "not finite"; empty where it has not."""
    warned = next((name for name in BROKEN if data.warning[WARNINGS[name]].number), "")
    return warned or ("" if np.all(np.isfinite(data.qpos)) else "not finite")


def looping_stepper(
    model: mujoco.MjModel, start: Callable[[mujoco.MjData], None], most: int
) -> Callable[[], Callable[[int], None]]:
    """Maker of a function that makes so many steps of the same run, again and again.

    Args:
        start: puts data that are new, or have been reset, into the state that the run starts from.
        most: steps of the run; what comes after it is not what the model is for.
    """

    def make() -> Callable[[int], None]:
        data, done = mujoco.MjData(model), 0
        start(data)

        def advance(steps: int) -> None:
            nonlocal done
            with warnings_kept_quiet():
                while steps:
                    if done == most:
                        mujoco.mj_resetData(model, data)
                        start(data)
                        done = 0
                    some = min(steps, most - done)
                    mujoco.mj_step(model, data, some)
                    done, steps = done + some, steps - some

        return advance

    return make
