"""The exact motion of a scene under a torque on its crank, at the instants of a table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from conrod.exact.dynamics.contact import check_contact
from conrod.exact.dynamics.forward import ForwardDynamics, FreeMotion
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism
from conrod.models.tables.columns import AXES, CRANK_ACCELERATION, CRANK_ANGLE, CRANK_SPEED, MOTION
from conrod.models.torque_runs.torque import Torque
from conrod.scenes import Scene

Values = Mapping[str, Array]  # (T,) by quantity, SI, with the names of `columns.quantities`


@dataclass(frozen=True)
class CrankStart:
    """Angle [rad] and speed [rad/s] of the crank at time 0; a speed of None is the scene's."""

    angle: float = 0.0
    speed: float | None = None

    def __bool__(self) -> bool:
        return self.angle != 0.0 or self.speed is not None


def machine_under(scene: Scene, torque: Torque) -> Mechanism:
    """The machine with all its loads, and the torque on its crank."""
    mechanism = scene.kinematics.mechanism
    return replace(mechanism, loads=(*mechanism.loads, torque.acts_on(mechanism)))


def start_state(scene: Scene, dynamics: ForwardDynamics, start: CrankStart) -> tuple[float, float]:
    """Arc length and its rate at the start: the scene's own start, at another crank angle or speed where one is given.

    Raises:
        InvalidInput: the joints do not allow it.
    """
    if not start:
        return 0.0, dynamics.start_rate(scene.start_rates)
    speed = scene.speed if start.speed is None else start.speed
    return dynamics.crank_start(start.angle, speed)


def exact_motion(name: str, scene: Scene, torque: Torque, start: CrankStart, times: Array) -> FreeMotion:
    """The exact motion at increasing times (T,) [s], from a start at time 0.

    Raises:
        InvalidInput: the machine cannot move so; says why.
    """
    dynamics = ForwardDynamics(machine_under(scene, torque))
    motion = dynamics.motion(times, {}, start_state(scene, dynamics, start))
    check_contact(name, dynamics.mechanism, motion)
    return motion


def quantities_of(scene: Scene, poses: Array, rates: Array, accelerations: Array) -> dict[str, Array]:
    """Columns of a table by name, in SI: motion of crank and points, from all bodies' (T, 3 n)."""
    kinematics = scene.kinematics
    driver, turning = kinematics.mechanism.driver, 3 * kinematics.mechanism.body_index[kinematics.mechanism.crank] + 2
    found = {
        CRANK_ANGLE: driver.sense * (poses[:, turning] - driver.start),
        CRANK_SPEED: driver.sense * rates[:, turning],
        CRANK_ACCELERATION: driver.sense * accelerations[:, turning],
    }
    for point, derivatives in kinematics.point_derivatives([poses, rates, accelerations]).items():
        for (letter, _), values in zip(MOTION.values(), derivatives, strict=True):
            found |= {f"{point}.{letter}{axis}": np.asarray(values[:, k]) for k, axis in enumerate(AXES)}
    return found
