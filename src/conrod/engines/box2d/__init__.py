"""Box2D, an extra of conrod: settings of a run, and the presets. Imports no engine, which `engine` does."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from conrod.engines.engine import DASHED, DOTTED, SINGLE_EPSILON, STOCK, EngineSettings, Machine, Preset, step_length
from conrod.engines.numerics import NEAR_CHANGE_POINT, inverse_masses, iteration_matrix, joint_rows, poses_by_centres
from conrod.exact.kinematics import Kinematics
from conrod.mechanism.units import check_count, check_number

# Box2D moves no body farther than b2_maxTranslation = 2 of its units in a step, and says nothing of it.
FARTHEST = 1.0  # of what `tuned` lets the fastest one move
LARGEST_SCALE = 2.0**30
SAMPLES = 720  # of a turn, for the largest rate
POSITIONS = 72  # of a turn, for the iterations
LEAST, MOST = 8, 2000  # iterations: Box2D's default, and what can be waited for
OVERLAP_LEFT = 0.8  # of a contact's overlap after an iteration, 1 - b2_baumgarte


@dataclass(frozen=True)
class Box2DSettings(EngineSettings):
    """Settings of a Box2D run; the names are Box2D's own where it has one. SI."""

    engine: ClassVar[str] = "box2d"

    velocity_iterations: int = 8  # its manual suggests these two
    position_iterations: int = 3  # at most: they end where all joints are closed to 5 mm, b2_linearSlop
    all_iterations: bool = False  # a joint that cannot be closed, beside the machine, has none of them left out
    length_scale: float = 1.0  # of Box2D's units in a metre
    sleeping: bool = True
    continuous_physics: bool = True
    cam_vertices: int = 500  # at most; each of which a step takes half a microsecond to move

    def __post_init__(self) -> None:
        super().__post_init__()
        check_count("velocity_iterations", self.velocity_iterations, 1, 10**6)
        check_count("position_iterations", self.position_iterations, 1, 10**6)
        check_count("cam_vertices", self.cam_vertices, 16, 10**5)
        check_number("length_scale", self.length_scale, 1.0 / LARGEST_SCALE, LARGEST_SCALE)

    def time_constant(self, contact: bool) -> float:
        # A contact mends a fifth of its overlap (b2_baumgarte) in each iteration of a step; joints all of their gap.
        return self.timestep if contact else 0.0

    @classmethod
    def tuned(cls, machine: Machine, steps_per_revolution: int) -> Box2DSettings:
        """Iterations until the joints are closed to rounding, and a unit in which the fastest link moves by one a step.

        Box2D's lengths are absolute: it takes an overlap of a contact, or a gap of a joint, of 5 mm for none. The
        smaller the unit, the less that is of the machine.
        """
        h = step_length(machine, steps_per_revolution)
        count = iterations_needed(machine.kinematics, steps_per_revolution)
        scale = FARTHEST / (largest_rate(machine.kinematics) * abs(machine.speed) * h)
        # A power of two changes no digit of a length.
        scale = 2.0 ** math.floor(math.log2(min(max(scale, 1.0 / LARGEST_SCALE), LARGEST_SCALE)))
        return cls("tuned", steps_per_revolution, h, count, count, True, scale, False, False)


def largest_rate(kinematics: Kinematics) -> float:
    """Bound on the way of a centre of gravity by the crank angle [m/rad]."""
    rates = kinematics.derivatives(kinematics.angles(SAMPLES), 1)[1].reshape(SAMPLES, -1, 3)
    arms = [math.hypot(*body.centre_of_gravity) for body in kinematics.mechanism.bodies]
    return float((np.linalg.norm(rates[:, :, :2], axis=2) + np.abs(rates[:, :, 2]) * arms).max())


def iterations_needed(kinematics: Kinematics, steps: int) -> int:
    """So many that they leave rounding alone of what a step of so many in a turn opens, which is a step's share of it.

    An iteration leaves T of an error, and N of them T^N: no more than that power of the largest eigenvalue, in the end.
    """
    share = min(SINGLE_EPSILON * steps / (2.0 * math.pi), 0.5)
    return min(MOST, max(LEAST, math.ceil(math.log(share) / math.log(slowest_decay(kinematics)))))


@lru_cache(128)
def slowest_decay(kinematics: Kinematics) -> float:
    """Largest share of an error that an iteration leaves, in all positions of the turn but next to change points.

    Velocities and positions are solved for alike, a pin's or a slide's two equations together.
    """
    angle = kinematics.angles(POSITIONS)
    clear = ~kinematics.near_change(angle, NEAR_CHANGE_POINT)
    poses = kinematics.poses(angle[clear] if clear.any() else angle)
    inverse = inverse_masses(kinematics.mechanism)
    free = np.flatnonzero(inverse)
    jacobian = kinematics.jacobian(poses) @ poses_by_centres(kinematics.mechanism, poses)[:, :, free]
    once = iteration_matrix(jacobian, inverse[free], [rows for _, rows in joint_rows(kinematics)])
    largest = float(np.abs(np.linalg.eigvals(once)).max())
    return min(
        max(largest, OVERLAP_LEFT if kinematics.mechanism.cam_contacts else SINGLE_EPSILON), 1.0 - SINGLE_EPSILON
    )


# Its manual states no size of its errors: they are measured, and not judged.
BOX2D_PRESETS: Mapping[str, Preset[Box2DSettings]] = {
    STOCK: Preset(Box2DSettings.stock, "Box2D as it comes", judged=False, style=DOTTED),
    "tuned": Preset(
        Box2DSettings.tuned, "joints closed to rounding, lengths in units of its own", judged=False, style=DASHED
    ),
}
