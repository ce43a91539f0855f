"""Bounds on MuJoCo's errors before any run, from its documented constraint model and its integrator.

Loops: the errors of closures under RK4 are predicted (`closure_errors`). What that leaves out is of second order in
them, and rounding. Contact: below.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from conrod.engines.cam_polygon import FollowerMotion, cam_polygon
from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import Machine
from conrod.engines.mujoco.closure_errors import closure_errors
from conrod.engines.mujoco.model import build
from conrod.engines.mujoco.settings import LEAST_STEPS, MuJoCoSettings, exchanged_inertia
from conrod.engines.numerics import SAMPLES, UNDETERMINED
from conrod.exact.joint_equations import pose_jets

# Of an error, what its prediction leaves out: RK4's own step of a closure, and terms of second order. Over 2 % was not
# found where errors are below 0.005.
LEFT_OUT, SECOND_ORDER = 0.05, 10.0
FALL_RMS = math.sqrt(1.1)  # 1 for the step itself, and 0.18^2, 0.2^2, .. for those that follow
CONTACT_LAW = "contact sinking, a fall in the first step, the polygon's corners, half a sagitta / cos(pressure angle)"
LAW = "predicted: each closure's gap by its spring, by what RK4 leaves of it and by the exact reactions; 5 % more"


def expected_error(machine: Machine, settings: MuJoCoSettings, start_angle: float = 0.0) -> ExpectedError:
    """Bounds for RK4 with a constant impedance, for links as bodies that have their weight and carry nothing else.

    The drive is a flywheel, whose rate varies by what the crank exchanges with the links over what it holds.
    """
    bounds = _bounds(machine, settings, start_angle)
    return replace(bounds, ripple=ripple(machine, settings.armature)) if settings.armature > 0.0 else bounds


def ripple(machine: Machine, armature: float) -> float:
    """Bound on the share by which a flywheel's rate varies: what it exchanges with the links over its own [kg m^2].

    The flywheel is chosen by the motion of observed points; near its ends a rocker turns its links faster than these.
    """
    return max(exchanged_inertia(machine), _varying_inertia(machine)) / armature


def _varying_inertia(machine: Machine) -> float:
    """By how much the inertia of all bodies, as the crank feels it, varies in a turn [kg m^2]."""
    kinematics = machine.kinematics
    bodies = pose_jets(kinematics.mechanism, kinematics.derivatives(kinematics.angles(SAMPLES), 1))
    felt = np.zeros(SAMPLES)
    for body in kinematics.mechanism.bodies:
        x, y = (jet.coefficients[1] for jet in bodies[body.name].point(body.centre_of_gravity))
        felt += body.mass * (x**2 + y**2) + body.inertia * bodies[body.name].phi.coefficients[1] ** 2
    return float(np.ptp(felt))


def _bounds(machine: Machine, settings: MuJoCoSettings, start_angle: float) -> ExpectedError:
    none = ExpectedError()
    if machine.kinematics.mechanism.cam_contacts:
        return none if settings.dressing else _contact_error(machine, settings)
    if machine.kinematics.change_angles.size:
        return replace(none, law=UNDETERMINED)
    if settings.dressing or not settings.gravity or settings.integrator != "RK4":
        return none
    # A time constant that is shorter MuJoCo raises, or RK4 cannot follow.
    if settings.solref[0] < LEAST_STEPS * settings.timestep:
        return none
    if settings.solimp[0] != settings.solimp[1] or settings.solref[1] != 1.0:
        return none
    errors, rounded = closure_errors(machine, settings, build(machine, settings), start_angle)
    position, velocity, acceleration = (errors * (1.0 + LEFT_OUT + SECOND_ORDER * errors[0]) + rounded).tolist()
    return ExpectedError(position, velocity, acceleration, law=LAW)


def _contact_error(machine: Machine, settings: MuJoCoSettings) -> ExpectedError:
    """Bounds for a contact of constant impedance, time constant in steps, under Euler."""
    impedance, stiffest = settings.contact_solimp[:2]
    if impedance != stiffest or settings.integrator != "Euler" or settings.contact_solref[1] != 1.0:
        return ExpectedError()
    follower = FollowerMotion.of(machine)
    h, constant = settings.timestep, settings.contact_solref[0]
    mass = machine.kinematics.mechanism.body(follower.contact.b).mass
    # The contact has no term for the cam's curvature, so it lags by s''; the force it carries is mass (s'' + g).
    lag = follower.acceleration * (1.0 - h / (impedance * constant))
    give = (1.0 - impedance) / impedance * follower.force / (mass * follower.cosine)
    sinking = impedance * constant**2 * float(np.abs(lag + give).max())
    shape = shape_error(machine, settings)
    polygon = cam_polygon(follower.contact.profile, settings.cam_vertices)
    # Where the start is over a facet, inside the curve, there is no contact in the first step: the follower falls.
    gap = polygon.distance(follower.start) - follower.contact.roller_radius
    falls = gap > -np.finfo(np.float32).eps * float(follower.distance[0])  # in which MuJoCo has a mesh
    fall = falls * h**2 * abs(float(follower.force[0] * follower.cosine[0])) / mass
    # At a corner of the polygon the follower's speed jumps; a critically damped contact gives v tc / e to that. A step
    # may take in two corners.
    corner = 2.0 * abs(machine.speed) * follower.largest_corner(polygon) * impedance * constant / math.e
    # Semi-implicit Euler's velocity is the difference of the last two positions, half a step old.
    stale = h * float(np.abs(follower.acceleration).max()) / abs(machine.speed)
    settling = follower.corner_slope_rms(polygon, abs(machine.speed) * constant / 2.0)
    # The fall's speed, in one step of a turn; what the contact makes of it is a fifth of that.
    fallen = FALL_RMS * fall / h / abs(machine.speed) / math.sqrt(settings.steps_per_revolution)
    slope = math.hypot(follower.facet_slope_rms(polygon), settling, fallen) + stale
    return ExpectedError(
        (max(sinking, fall) + corner + shape) / follower.lift, velocity_rms=slope / follower.lift, law=CONTACT_LAW
    )


def shape_error(machine: Machine, settings: MuJoCoSettings) -> float:
    """Largest error of the lift [m] that the collision mesh has, held still: facets, and single precision."""
    follower = FollowerMotion.of(machine)
    polygon = cam_polygon(follower.contact.profile, settings.cam_vertices)
    single = float(np.finfo(np.float32).eps) * float(np.abs(polygon.vertices).max())
    return (polygon.error + single) / float(follower.cosine.min())
