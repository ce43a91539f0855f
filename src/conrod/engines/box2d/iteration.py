"""How many iterations Box2D takes to close a machine's joints to rounding. Imports no engine."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from conrod.engines.centres import by_centres, equations, inverse_masses, one_iteration
from conrod.engines.engine import SINGLE
from conrod.engines.numerics import MEETING
from conrod.exact.kinematics import Kinematics

SAMPLES = 72  # positions of the turn
LEAST, MOST = 8, 2000  # Box2D's default, and what can be waited for
OVERLAP_LEFT = 0.8  # of a contact's overlap after an iteration, 1 - b2_baumgarte
KEPT = 128


def iterations_needed(kinematics: Kinematics, steps: int) -> int:
    """So many that they leave rounding alone of what a step of so many in a turn opens, which is a step's share of it.

    An iteration leaves T of an error, and N of them T^N: no more than that power of the largest eigenvalue, in the end.
    """
    share = min(SINGLE * steps / (2.0 * math.pi), 0.5)
    return min(MOST, max(LEAST, math.ceil(math.log(share) / math.log(slowest_decay(kinematics)))))


@lru_cache(KEPT)
def slowest_decay(kinematics: Kinematics) -> float:
    """Largest share of an error that an iteration leaves, in all positions of the turn but next to change points.

    Velocities and positions are solved for alike, a pin's or a slide's two equations together.
    """
    angle = kinematics.angles(SAMPLES)
    clear = ~kinematics.near_change(angle, MEETING)
    poses = kinematics.poses(angle[clear] if clear.any() else angle)
    inverse = inverse_masses(kinematics.mechanism)
    free = np.flatnonzero(inverse)
    jacobian = kinematics.jacobian(poses) @ by_centres(kinematics.mechanism, poses)[:, :, free]
    once = one_iteration(jacobian, inverse[free], [rows for _, rows in equations(kinematics)])
    largest = float(np.abs(np.linalg.eigvals(once)).max())
    return min(max(largest, OVERLAP_LEFT if kinematics.mechanism.cam_contacts else SINGLE), 1.0 - SINGLE)
