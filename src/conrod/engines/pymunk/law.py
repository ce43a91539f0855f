"""Bounds on pymunk's errors by its own scheme, from the step and the exact motion.

With full correction (error_bias = 0), x_(n+1) = x_n + h v_n, where v_n fits the joints' equations linearised at x_n.
Expanding both gives a position that runs behind the exact one by h^2 x'' / 2 (primes: by the crank angle, h the step
in crank angle). The velocity, the difference of two positions, belongs to the middle of the step:
h^2 x''' (1/24 - 1/2); the acceleration, the difference of two velocities: h^2 x'''' (1/12 - 1/2). This holds of the
engine's own coordinates, from which `lag` tells that of points elsewhere on a link.

On a cam the follower sinks by at most the slop, until the curve falls away from under it; then it falls free for one
step, from rest against the tangent: by g h^2 and what the curve itself departs, h^2 |s''|/2 (h in seconds), at a speed
of g h. Where a corner of the polygon falls into that step, its jump of speed acts for the step. The rounded polygon's
own error comes on top, by the pressure angle's cosine.
"""

from __future__ import annotations

import math

import numpy as np

from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import Machine
from conrod.engines.follower import FollowerMotion
from conrod.engines.massless_rod import BODY
from conrod.engines.numerics import UNDETERMINED, largest_derivatives, rounding
from conrod.engines.pymunk.drift import predicted_softness
from conrod.engines.pymunk.lag import largest_lags
from conrod.engines.pymunk.settings import PymunkSettings, follower_fall
from conrod.engines.pymunk.space import rounded_polygon

NEXT_LAGS = (1.0 / 2.0, 11.0 / 24.0, 5.0 / 12.0)  # of the next term in h
CONTACT_LAW = (
    "one step's free fall, (g + |s''|/2) h^2, jumps of speed at the polygon's corners, and half a sagitta of it / "
    "cos(pressure angle)"
)
SAMPLED = 1e-3  # what sampling the turn takes off the drift at most, at 20 steps a revolution or more
LAW = (
    "scheme lag: h^2 x''/2, 11/24 h^2 x''', 5/12 h^2 x'''' of the links' centres of gravity and of their turns, and "
    "the next term in h"
)


def expected_error(machine: Machine, settings: PymunkSettings) -> ExpectedError:
    """Bounds for full correction; none where a share of the error is left at each step."""
    if settings.error_bias > 0.0 or settings.dressing:
        return ExpectedError(None, None, None)
    if machine.kinematics.mechanism.cam_contacts:
        return _contact_error(machine, settings)
    if machine.kinematics.change_angles.size:
        return ExpectedError(None, None, None, law=UNDETERMINED)
    if settings.rod != BODY:
        return _drift(machine, settings)
    step = 2.0 * math.pi / settings.steps_per_revolution
    sizes = largest_derivatives(machine.kinematics, 5)
    floor = rounding(machine.kinematics, settings.steps_per_revolution)
    behind = largest_lags(machine)
    bounds = [step**2 * (behind[k] + lag * step * sizes[k + 3]) + floor / step**k for k, lag in enumerate(NEXT_LAGS)]
    return ExpectedError(bounds[0], bounds[1], bounds[2], law=LAW)


def _drift(machine: Machine, settings: PymunkSettings) -> ExpectedError:
    """The lag of distance joints, which a point on a link that is left out shares in part."""
    drift = predicted_softness(machine, settings)
    if drift is None:
        return ExpectedError(None, None, None)
    floor = rounding(machine.kinematics, settings.steps_per_revolution)
    return ExpectedError((1.0 + SAMPLED) * drift.whole_run + floor, None, None, law=drift.law)


def _contact_error(machine: Machine, settings: PymunkSettings) -> ExpectedError:
    follower = FollowerMotion.of(machine)
    fall, h = follower_fall(machine.kinematics.mechanism), settings.timestep
    polygon = rounded_polygon(follower.contact.profile, settings.cam_vertices)
    corner = abs(machine.speed) * follower.largest_corner(polygon)  # speed that a corner adds
    drop = (fall + 0.5 * float(np.abs(follower.acceleration).max())) * h**2 + corner * h
    position = (drop + polygon.error / float(follower.cosine.min())) / follower.lift
    velocity = (fall * h / abs(machine.speed) + follower.facet_slope_rms(polygon)) / follower.lift
    return ExpectedError(position, None, None, velocity_rms=velocity, law=CONTACT_LAW)


def shape_error(machine: Machine, settings: PymunkSettings) -> float:
    """Largest error of the lift [m] that the collision shape has, held still."""
    follower = FollowerMotion.of(machine)
    polygon = rounded_polygon(follower.contact.profile, settings.cam_vertices)
    return polygon.error / float(follower.cosine.min())
