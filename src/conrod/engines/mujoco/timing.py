"""Steps with nothing recorded, which is what MuJoCo itself costs; and the slider-crank that timings are ratios to.

NEVER CHANGE THAT ONE: ratios of any date and machine relate to this very text. MuJoCo's defaults (Euler, Newton), a
crank of 0.1 m with a flywheel, a rod of 0.3 m and a slider, its loop closed by one `connect`; no gravity, no sensors.
"""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass

import mujoco

from conrod.engines.engine import Machine, run_of
from conrod.engines.mujoco.model import build, compiled, laws_acting
from conrod.engines.mujoco.recorder import round_state, warnings_kept_quiet
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import Tree

MODEL = """
<mujoco model="conrod-reference-loop">
  <compiler angle="radian"/>
  <option timestep="0.001" gravity="0 0 0">
    <flag contact="disable"/>
  </option>
  <worldbody>
    <body name="crank">
      <joint name="crank" type="hinge" axis="0 0 1" armature="10"/>
      <inertial pos="0 0 0" mass="4" diaginertia="0.02 0.02 0.02"/>
      <body name="rod" pos="0.1 0 0">
        <joint name="crank-pin" type="hinge" axis="0 0 1"/>
        <inertial pos="0.15 0 0" mass="1.5" diaginertia="0.01125 0.01125 0.01125"/>
        <site name="rod-end" pos="0.3 0 0"/>
      </body>
    </body>
    <body name="slider" pos="0.4 0 0">
      <joint name="slide" type="slide" axis="1 0 0"/>
      <inertial pos="0 0 0" mass="6" diaginertia="0.06 0.06 0.06"/>
      <site name="slider-pin" pos="0 0 0"/>
    </body>
  </worldbody>
  <equality>
    <connect name="slider-pin" site1="rod-end" site2="slider-pin"/>
  </equality>
  <keyframe>
    <key name="start" qpos="0 0 0" qvel="6.283185307179586 -8.377580409572781 0"/>
  </keyframe>
</mujoco>
"""


def reference_loop() -> BareRun:
    """The slider-crank at its start: in line, the crank at one turn a second, 1000 steps a turn."""
    model = compiled(MODEL)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return BareRun(model, data)


@dataclass(frozen=True)
class BareRun:
    """A model with its state; calling it advances the state by so many steps, in one call of the engine.

    Attributes:
        rounded: to single precision after each step, which takes a call for each.
        tree: of a machine under loads, whose laws act; None where there are none.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    rounded: bool = False
    tree: Tree | None = None

    def __call__(self, steps: int) -> None:
        acting = nullcontext() if self.tree is None else laws_acting(self.model, self.tree)
        with warnings_kept_quiet(), acting:
            if not self.rounded:
                mujoco.mj_step(self.model, self.data, nstep=steps)
                return
            for _ in range(steps):
                mujoco.mj_step(self.model, self.data)
                round_state(self.data)


def started(machine: Machine, settings: MuJoCoSettings) -> BareRun:
    """A machine in the exact state of its start, compiled without sensors."""
    made = build(machine, settings, sensors=False)
    data = mujoco.MjData(made.model)
    data.qpos[:], data.qvel[:] = made.start_state(machine, run_of(machine, 1, 1.0)[0])
    tree = made.tree if made.tree.mechanism.loads else None
    return BareRun(made.model, data, settings.rounded_state, tree)
