"""Laws of loads that MJCF cannot say, given to MuJoCo while it steps.

MuJoCo asks a program for the bias of an actuator (`mjcb_act_bias`) whenever it evaluates forces, so at every stage of
RK4, at that stage's length, rate and time. There is one such program in a process: it is there while it is needed, and
what was there before comes back, whatever happens.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from conrod.engines.mujoco.loads import by_program, moves_nothing, origin_of
from conrod.engines.tree import Tree


@contextmanager
def laws_acting(model: mujoco.MjModel, tree: Tree, begin: float = 0.0) -> Iterator[None]:
    """Give the laws of a machine's loads to MuJoCo, which steps it in this thread alone.

    Args:
        begin: the time [s] at which the engine's clock is 0.
    """
    laws = {
        int(model.actuator(load.name).id): (load.law, origin_of(load, tree))
        for load in by_program(tree.mechanism)
        if not moves_nothing(load, tree)
    }
    if not laws:
        yield
        return

    def bias(_: mujoco.MjModel, data: mujoco.MjData, actuator: int) -> float:
        law, origin = laws[actuator]
        value, rate = data.actuator_length[actuator] + origin, data.actuator_velocity[actuator]
        return float(law.force(np.asarray(value), np.asarray(rate), np.asarray(begin + data.time)))

    before = mujoco.get_mjcb_act_bias()
    mujoco.set_mjcb_act_bias(bias)
    try:
        yield
    finally:
        mujoco.set_mjcb_act_bias(before)
