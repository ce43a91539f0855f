"""Box2D, an optional engine: settings of a run, and the presets. Does not import the engine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from conrod.engines.engine import DASHED, DOTTED, SINGLE_EPSILON, STOCK, EngineSettings, Machine, Preset, step_length
from conrod.engines.numerics import (
    CRANK_SAMPLES,
    NEAR_CHANGE_POINT,
    inverse_masses,
    iteration_matrix,
    joint_rows,
    poses_by_centres,
)
from conrod.exact.kinematics import Kinematics
from conrod.mechanism.units import check_count, check_number

# Box2D moves no body farther than b2_maxTranslation = 2 of its units in a step, and says nothing of it.
TUNED_MAX_MOVE = 1.0  # Box2D units that the fastest body may move per step in `tuned`
MAX_LENGTH_SCALE = 2.0**30
DECAY_POSITIONS = 72  # crank angles over a revolution at which the decay of errors is computed
MIN_ITERATIONS, MAX_ITERATIONS = 8, 2000  # Box2D's default, and the longest acceptable step
OVERLAP_DECAY = 0.8  # share of a contact's overlap that is left after an iteration, 1 - b2_baumgarte


@dataclass(frozen=True)
class Box2DSettings(EngineSettings):
    """Settings of a Box2D run, in SI, named as in Box2D where Box2D has them."""

    engine: ClassVar[str] = "box2d"

    velocity_iterations: int = 8  # its manual suggests these two
    position_iterations: int = 3  # at most: they end when all joints are closed to 5 mm, b2_linearSlop
    all_iterations: bool = False  # a joint that cannot be closed is added, so that none is left out
    length_scale: float = 1.0  # Box2D units per metre
    sleeping: bool = True
    continuous_physics: bool = True
    cam_vertices: int = 500  # at most; a step takes half a microsecond to move each

    def __post_init__(self) -> None:
        super().__post_init__()
        check_count("velocity_iterations", self.velocity_iterations, 1, 10**6)
        check_count("position_iterations", self.position_iterations, 1, 10**6)
        check_count("cam_vertices", self.cam_vertices, 16, 10**5)
        check_number("length_scale", self.length_scale, 1.0 / MAX_LENGTH_SCALE, MAX_LENGTH_SCALE)

    def time_constant(self, contact: bool) -> float:
        """Time constant [s]: the step for contacts; 0 for joints, which correct their whole gap in a step.

        A contact corrects a fifth of its overlap (b2_baumgarte) in each iteration of a step.
        """
        return self.timestep if contact else 0.0

    @classmethod
    def tuned(cls, machine: Machine, steps_per_revolution: int) -> Box2DSettings:
        """Iterations that close joints to rounding, in a length unit that the fastest link moves by per step.

        Box2D's tolerances are absolute: it accepts an overlap of a contact, or a gap of a joint, of 5 mm. The smaller
        the length unit, the smaller a part of the machine that is.
        """
        h = step_length(machine, steps_per_revolution)
        count = iterations_needed(machine.kinematics, steps_per_revolution)
        scale = TUNED_MAX_MOVE / (largest_centre_rate(machine.kinematics) * abs(machine.speed) * h)
        # A power of two changes no digit of a length.
        scale = 2.0 ** math.floor(math.log2(min(max(scale, 1.0 / MAX_LENGTH_SCALE), MAX_LENGTH_SCALE)))
        return cls("tuned", steps_per_revolution, h, count, count, True, scale, False, False)


def largest_centre_rate(kinematics: Kinematics) -> float:
    """Bound on the speed of any centre of gravity per crank speed [m/rad]."""
    rates = kinematics.derivatives(kinematics.angles(CRANK_SAMPLES), 1)[1].reshape(CRANK_SAMPLES, -1, 3)
    arms = [math.hypot(*body.centre_of_gravity) for body in kinematics.mechanism.bodies]
    return float((np.linalg.norm(rates[:, :, :2], axis=2) + np.abs(rates[:, :, 2]) * arms).max())


def iterations_needed(kinematics: Kinematics, steps: int) -> int:
    """Iterations after which a step's joint error is below single-precision rounding.

    A step opens the joints by about 2 pi / steps of the machine's size, and N iterations leave r^N of that, with r the
    largest eigenvalue of one iteration (`largest_decay_factor`): N = ln(eps steps / 2 pi) / ln r.
    """
    share = min(SINGLE_EPSILON * steps / (2.0 * math.pi), 0.5)
    return min(
        MAX_ITERATIONS, max(MIN_ITERATIONS, math.ceil(math.log(share) / math.log(largest_decay_factor(kinematics))))
    )


@lru_cache(128)
def largest_decay_factor(kinematics: Kinematics) -> float:
    """Largest factor by which one iteration reduces an error, over all poses not next to change points.

    It is the largest eigenvalue of `iteration_matrix`: velocities and positions are solved for alike, the two equations
    of a pin or slide together.
    """
    angle = kinematics.angles(DECAY_POSITIONS)
    clear = ~kinematics.near_change(angle, NEAR_CHANGE_POINT)
    poses = kinematics.poses(angle[clear] if clear.any() else angle)
    inverse = inverse_masses(kinematics.mechanism)
    free = np.flatnonzero(inverse)
    jacobian = kinematics.jacobian(poses) @ poses_by_centres(kinematics.mechanism, poses)[:, :, free]
    once = iteration_matrix(jacobian, inverse[free], [rows for _, rows in joint_rows(kinematics)])
    largest = float(np.abs(np.linalg.eigvals(once)).max())
    return min(
        max(largest, OVERLAP_DECAY if kinematics.mechanism.cam_contacts else SINGLE_EPSILON), 1.0 - SINGLE_EPSILON
    )


# Its manual states no size of its errors: they are measured, and not judged.
BOX2D_PRESETS: Mapping[str, Preset[Box2DSettings]] = {
    STOCK: Preset(Box2DSettings.stock, "Box2D as it comes", judged=False, style=DOTTED),
    "tuned": Preset(
        Box2DSettings.tuned, "joints closed to rounding, lengths in units of its own", judged=False, style=DASHED
    ),
}
