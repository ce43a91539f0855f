"""Steps with nothing recorded: what MuJoCo itself costs."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco

from conrod.engines.engine import Machine
from conrod.engines.mujoco.dynamics import warnings_kept_quiet
from conrod.engines.mujoco.model import build
from conrod.engines.mujoco.settings import MuJoCoSettings


@dataclass(frozen=True)
class BareRun:
    """A model with its state; calling it advances the state by so many steps, in one call of the engine."""

    model: mujoco.MjModel
    data: mujoco.MjData

    def __call__(self, steps: int) -> None:
        with warnings_kept_quiet():
            mujoco.mj_step(self.model, self.data, nstep=steps)


def started(machine: Machine, settings: MuJoCoSettings) -> BareRun:
    """A machine in the exact state of crank angle 0, compiled without sensors."""
    made = build(machine, settings, sensors=False)
    data = mujoco.MjData(made.model)
    data.qpos[:], data.qvel[:] = made.start_state(machine, 0.0)
    return BareRun(made.model, data)
