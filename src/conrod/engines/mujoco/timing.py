"""Steps with nothing recorded, which is what MuJoCo itself costs."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass

import mujoco

from conrod.engines.engine import STOCK, Machine, run_of
from conrod.engines.mujoco.model import build, laws_acting
from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.engines.mujoco.settings import STOCK_TOLERANCE, MuJoCoSettings
from conrod.engines.reference_loop import REFERENCE
from conrod.engines.tree import Tree


def reference_loop() -> BareRun:
    """The slider-crank that timings are ratios to, with a flywheel of 10 kg m^2 and MuJoCo's own solver tolerance."""
    defaults = MuJoCoSettings(STOCK, 1000, 0.001, tolerance=STOCK_TOLERANCE, armature=10.0)
    return started(REFERENCE, defaults)


@dataclass(frozen=True)
class BareRun:
    """A model with its state; calling it advances the state by so many steps, in one call of the engine.

    Attributes:
        tree: of a machine under loads, whose laws act; None where there are none.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    tree: Tree | None = None

    def __call__(self, steps: int) -> None:
        acting = nullcontext() if self.tree is None else laws_acting(self.model, self.tree)
        with warnings_kept_quiet(), acting:
            mujoco.mj_step(self.model, self.data, nstep=steps)


def started(machine: Machine, settings: MuJoCoSettings) -> BareRun:
    """A machine in the exact state of its start, compiled without sensors."""
    made = build(machine, settings, sensors=False)
    data = mujoco.MjData(made.model)
    data.qpos[:], data.qvel[:] = made.start_state(machine, run_of(machine, 1, 1.0)[0])
    tree = made.tree if made.tree.mechanism.loads else None
    return BareRun(made.model, data, tree)
