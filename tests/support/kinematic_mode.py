"""How exact an engine's own joints place a machine."""

from __future__ import annotations

from typing import Any

import numpy as np

from conrod.engines import engine_named
from conrod.exact.motion import Array


def kinematic_errors(engine: str, judge: Any, angles: Array, machine: Any = None) -> tuple[float, float]:
    """Largest error of a point's position over L, and of its velocity over L times the speed, against `judge`.

    Args:
        machine: that the engine solves, where it is another.
    """
    solver: Any = engine_named(engine)
    exact, position, velocity = judge.motion(angles, judge.speed), 0.0, 0.0
    for name, (places, rates) in solver.solve_kinematics(machine or judge, angles).points.items():
        truth, length = exact.point(name), judge.lengths[name]
        position = max(position, float(np.linalg.norm(places - truth.position, axis=1).max()) / length)
        if rates is not None:
            off = float(np.linalg.norm(rates - truth.velocity, axis=1).max())
            velocity = max(velocity, off / (length * abs(judge.speed)))
    return position, velocity
