"""The exact start of a motion without a drive, for models that are exported without theirs."""

from __future__ import annotations

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.dynamics.forward import ForwardDynamics
from conrod.exact.motion import Array
from conrod.mechanism.loads import TimePulse
from conrod.scenes import Scene


def free_start(name: str, scene: Scene, motor: bool = False) -> tuple[Array, Array]:
    """Exact poses and rates (3 n,) [m, m, rad] of all bodies at the start.

    Args:
        motor: whether a motor on the crank will end a rest.

    Raises:
        InvalidInput: the joints do not allow the start, or the machine rests and nothing moves it.
    """
    mechanism = scene.kinematics.mechanism
    if motor and not any(scene.start_rates.values()):
        poses = scene.kinematics.start[0]
        return poses, np.zeros_like(poses)
    motion = ForwardDynamics(mechanism).motion(np.zeros(1), rates=scene.start_rates)
    pulsed = any(isinstance(load.law, TimePulse) for load in mechanism.loads)
    if not (motion.rates.any() or motion.accelerations.any() or pulsed):
        raise InvalidInput(f"--free: {name} rests, and no weight or load moves it: --motor gives its crank a motor")
    return motion.poses[0], motion.rates[0]
