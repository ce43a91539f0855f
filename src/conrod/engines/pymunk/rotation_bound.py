"""Bounds on pymunk's errors of links' rotations, by the scheme that `error_bound` states for points.

Angles phi are among the engine's own coordinates q. With the step h in crank angle and the k-th derivative phi_k by the
crank angle, a rotation lags by h^2 phi_2 / 2, the difference of two rotations, at the middle of the step, by
11/24 h^2 phi_3, and the difference of two angular velocities by 5/12 h^2 phi_4.
"""

from __future__ import annotations

import math

import numpy as np

from conrod.comparison.compare import link_errors
from conrod.comparison.trajectory import BodyTracks
from conrod.engines.engine import Machine
from conrod.engines.numerics import CRANK_SAMPLES
from conrod.engines.pymunk import ITERATION_ERROR_SHARE, PymunkSettings
from conrod.exact.link_rotations import ROTATIONS, largest_rotation
from conrod.exact.motion import Array

LAGS = (1.0 / 2.0, 11.0 / 24.0, 5.0 / 12.0)  # of rotation, angular velocity and angular acceleration, for h = 1


def rotation_bounds(machine: Machine, settings: PymunkSettings, first: BodyTracks, left: float) -> dict[str, float]:
    """Bounds on the largest errors of the driven links, by quantity of `ROTATIONS`, normalised.

    As for points they are the lag and its next term in h, or the first samples, and what rounding adds.

    Args:
        first: first samples of a run, as a converged iteration takes them.
        left: rounding of the joints' velocities in a step by what acts on the bodies [m/s].
    """
    kinematics, steps = machine.kinematics, settings.steps_per_revolution
    h = 2.0 * math.pi / steps
    derivatives = kinematics.derivatives(kinematics.angles(CRANK_SAMPLES), len(LAGS) + 2)
    sizes = [largest_rotation(kinematics, derivative[:, 2::3]) for derivative in derivatives]
    errors = link_errors(first, machine.speed, kinematics)
    gain = _rotation_gain(machine)
    rounding = float(np.finfo(float).eps) * steps * (1.0 + kinematics.size * gain)
    weight, speed = left * gain, abs(machine.speed)
    by_weight = (weight * settings.timestep, weight / speed, 2.0 * weight / (speed**2 * settings.timestep))
    bounds = {}
    for k, quantity in enumerate(ROTATIONS):
        lag = h**2 * LAGS[k] * (sizes[k + 2] + h * sizes[k + 3])
        begun = max((float(one[quantity].max(initial=0.0)) for one in errors.values()), default=0.0)
        bounds[quantity] = max(lag, (1.0 + ITERATION_ERROR_SHARE) * begun) + rounding / h**k + by_weight[k]
    return bounds


def _rotation_gain(machine: Machine) -> float:
    """Largest rotation of a driven link over its range R when all joint equations are off by one [1/m]."""
    kinematics, angles = machine.kinematics, machine.kinematics.angles(CRANK_SAMPLES)
    poses = kinematics.poses(angles)
    turned: Array = np.zeros_like(poses[:, 2::3])
    for equation in np.eye(poses.shape[1]):
        turned += np.abs(kinematics.solve(poses, np.tile(equation, (len(angles), 1)))[:, 2::3])
    return largest_rotation(kinematics, turned)
