"""How many iterations Box2D takes to close a machine's joints to rounding. Imports no engine."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from conrod.engines.centres import by_centres, one_iteration
from conrod.engines.engine import SINGLE
from conrod.engines.numerics import MEETING
from conrod.exact.kinematics import Kinematics

SAMPLES = 72  # positions of the turn
LEAST, MOST = 70, 2000  # a contact's overlap falls to 0.8 in each, and so to rounding in 70; what can be waited for
KEPT = 128


@lru_cache(KEPT)
def iterations_needed(kinematics: Kinematics) -> int:
    """So many that they leave rounding alone of any error, in all positions of the turn but next to change points.

    Impulses go from joint to joint, and leave T^N of an error after N rounds: less than the largest eigenvalue's power.
    Velocities and positions are solved for alike, a pin's or a slide's two equations together.
    """
    mechanism, angle = kinematics.mechanism, kinematics.angles(SAMPLES)
    clear = ~kinematics.near_change(angle, MEETING)
    poses = kinematics.poses(angle[clear] if clear.any() else angle)
    held = [body.name == mechanism.crank for body in mechanism.bodies]
    inverse = np.array(
        [
            0.0 if still else 1.0 / size
            for body, still in zip(mechanism.bodies, held, strict=True)
            for size in (body.mass, body.mass, body.inertia)
        ]
    )
    free = np.flatnonzero(inverse)
    jacobian = kinematics.jacobian(poses) @ by_centres(mechanism, poses)[:, :, free]
    largest = np.abs(np.linalg.eigvals(one_iteration(jacobian, inverse[free], _joints(kinematics)))).max()
    if largest >= 1.0:
        return MOST
    return min(MOST, max(LEAST, math.ceil(math.log(SINGLE) / math.log(largest))))


def _joints(kinematics: Kinematics) -> Iterator[slice]:
    """Equations of each joint but the driven one."""
    first = 0
    for joint in kinematics.mechanism.joints:
        rows = slice(first, first + kinematics.equations_of(joint))
        first = rows.stop
        if joint.name != kinematics.mechanism.driver.joint:
            yield rows
