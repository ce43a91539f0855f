"""Bounds on pymunk's errors from its documented scheme, the step and the exact motion.

With full correction (error_bias = 0), x_(n+1) = x_n + h v_n, where v_n fulfils the joint equations linearised at x_n in
the engine's own coordinates q: the centres of gravity c and the angles phi of the bodies. A prime is the derivative by
the crank angle, and h the step in crank angle. So positions lag behind the exact ones by h^2 q''/2; the velocity, the
difference of two positions, by h^2 q''' (1/2 - 1/24) at the middle of the step; the acceleration, the difference of two
velocities, by h^2 q'''' (1/2 - 1/12). A point at r from the centre of gravity has the velocity c' + phi' r_perp, so all
of these enter: the angle, extrapolated linearly to the middle, lags there by h^2 phi'' (1/2 - 1/4 + 1/8).

Angles phi are among q: a rotation lags by h^2 phi''/2, the difference of two rotations, at the middle of the step, by
11/24 h^2 phi''', and the difference of two angular velocities by 5/12 h^2 phi''''.

To the next order the position's lag is -h^2 q''/2 + h^3 (q'''/3 + J^-1 H q' q''/2), with the Jacobian J of the joint
equations and their second derivatives H. The first step goes straight ahead from an exact state, so the first reported
velocity and acceleration have another lag: the first steps are computed as a converged iteration takes them.

A step gives each body the velocity a h of what acts on it, mainly weight, which the joints' impulses take away again.
Both are rounded, so each joint equation is off by half an eps of the three velocities of its two bodies, 3 eps a h.
What that does to a point, by J^-1, is an error of its velocity; times h, of its position; times 2/h, of its
acceleration (h in seconds). For a slow machine, with long steps and small velocities, it is the whole error.

On a cam the follower sinks by at most the slop, until the curve falls away under it; then it falls freely for one step,
from rest against the tangent: by g h^2 and the curve's own departure h^2 |s''|/2 (h in seconds), at a speed of g h. If
a corner of the polygon lies in that step, its jump of speed acts for the step. The rounded polygon's own error is
added, over the cosine of the pressure angle. Free steps are few, and make up the rms of velocities: g h in each, plus
the facets' share.
"""

from __future__ import annotations

import math

import numpy as np

from conrod.comparison.compare import link_errors
from conrod.comparison.trajectory import BodyTracks
from conrod.engines.cam_polygon import CamPolygon, FollowerMotion
from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import Machine, run_extent, step_length
from conrod.engines.numerics import (
    CRANK_SAMPLES,
    NO_BOUND_AT_CHANGE_POINT,
    centres_from_frames,
    frames_from_centres,
    largest_derivatives,
    rounding_bound,
)
from conrod.engines.pymunk import ITERATION_ERROR_SHARE, PymunkSettings, follower_fall
from conrod.engines.pymunk.dynamics import SampleInstants, body_tracks, point_tracks, sample_instants
from conrod.engines.pymunk.space import rounded_polygon, wedges, with_crank_centred
from conrod.engines.tracks import applied_forces
from conrod.exact.jet import Jet
from conrod.exact.joint_equations import pose_jets
from conrod.exact.link_rotations import ROTATIONS, largest_rotation
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism

MAX_DERIVATIVE = 4  # highest derivative by the crank angle that enters
ROTATION_LAGS = (
    1.0 / 2.0,
    11.0 / 24.0,
    5.0 / 12.0,
)  # of rotation, angular velocity and angular acceleration, for h = 1
FIRST_SAMPLES = 5  # including the start; the first reported acceleration is that of the fourth


def largest_lags(machine: Machine) -> tuple[float, float, float]:
    """Largest lags of observed points over L in position, velocity and acceleration, for h = 1 in crank angle."""
    kinematics = machine.kinematics
    mechanism = with_crank_centred(kinematics.mechanism)
    derivatives = kinematics.derivatives(kinematics.angles(CRANK_SAMPLES), MAX_DERIVATIVE)
    # The lag follows the sense of motion: for a crank that rotates backwards odd derivatives change sign.
    sense = math.copysign(1.0, machine.speed)
    derivatives = [sense**k * d for k, d in enumerate(derivatives)]
    bodies = pose_jets(mechanism, [d / math.factorial(k) for k, d in enumerate(derivatives)])
    largest = np.zeros(3)
    for observed in mechanism.observed:
        pose = bodies[observed.body]
        centre = _point_derivatives(pose.point(mechanism.body(observed.body).centre_of_gravity))
        point = _point_derivatives(pose.point(observed.point))
        turns = [math.factorial(k) * np.asarray(c)[:, None] for k, c in enumerate(pose.phi.coefficients)]
        position, velocity, acceleration = _point_lags(centre, point, turns)
        sizes = [np.linalg.norm(lag, axis=1).max() for lag in (position, velocity, acceleration)]
        largest = np.maximum(largest, np.array(sizes) / kinematics.lengths[observed.name])
    return float(largest[0]), float(largest[1]), float(largest[2])


def first_sample_errors(machine: Machine, steps: int, start: float) -> list[float]:
    """Largest errors of the first samples of a run: position, velocity, acceleration over L, omega L, omega^2 L.

    Args:
        steps: per revolution.
        start: crank angle [rad] of the exact start; an input that makes one pass starts at an end of it instead.
    """
    kinematics, speed = machine.kinematics, machine.speed
    mechanism, at, centres, rates = first_samples(machine, steps, start)
    tracks, largest = point_tracks(mechanism, at, centres, rates), [0.0] * 3
    for k, quantity in enumerate(("position", "velocity", "acceleration")):
        instants = getattr(at, quantity)
        if not len(instants.times):
            continue
        exact = kinematics.motion(instants.angle, instants.rate, instants.acceleration)
        for name, found in tracks.items():
            off = np.linalg.norm(getattr(found, quantity).values - getattr(exact.point(name), quantity), axis=1)
            largest[k] = max(largest[k], float(off.max()) / (kinematics.lengths[name] * abs(speed) ** k))
    return largest


def first_samples(machine: Machine, steps: int, start: float) -> tuple[Mechanism, SampleInstants, Array, Array]:
    """Predict the first samples of a converged run: mechanism, instants, centres (T, 3 n) and their rates.

    Args:
        steps, start: as for `first_sample_errors`.
    """
    kinematics, speed, (begin, turns) = machine.kinematics, machine.speed, run_extent(machine, steps, 1.0)
    start = start if kinematics.mechanism.driver.span is None else begin
    # Velocities belong to half a step later, when a pass may have ended.
    count = max(1, min(FIRST_SAMPLES, round(turns * steps)))
    mechanism, h = with_crank_centred(kinematics.mechanism), step_length(machine, steps)
    poses, derivative = kinematics.derivatives(np.array([start]), 1)
    states = [centres_from_frames(mechanism, poses, speed * derivative)]
    for n in range(1, count):
        place, rate = states[-1]
        poses = frames_from_centres(mechanism, place + h * rate, rate)[0]
        gaps = kinematics.residual([poses], np.array([start + n * h * speed]))
        at_rest = kinematics.residual([poses, np.zeros_like(poses)], np.array([speed]))
        states.append(centres_from_frames(mechanism, poses, kinematics.solve(poses, -gaps / h - at_rest)))
    centres, rates = (np.vstack(some) for some in zip(*states, strict=True))
    times = np.asarray(start / speed + h * np.arange(count), dtype=float)
    return mechanism, sample_instants(mechanism, h, times, centres, rates), centres, rates


MAX_SWEEPS = 60  # over the whole run
SWEEP_TOLERANCE = 1e-13  # change of a pose over the mechanism's size that is rounding


def scheme_states(machine: Machine, h: float, start: float, steps: int) -> tuple[Array, Array]:
    """Poses and rates (steps + 1, 3 n) of the scheme's steps h [s] from an exact start, without solver error.

    All steps are computed at once, each from the pose that the sweep before gave the step before. x_(n+1) depends on
    x_n only by what the joint equations leave of their linearisation, a part of order h, so the sweeps converge.

    Args:
        start: crank angle [rad].
    """
    kinematics, speed = machine.kinematics, machine.speed
    mechanism = with_crank_centred(kinematics.mechanism)
    angles: Array = np.asarray(start + speed * h * np.arange(steps + 1), dtype=float)
    poses = kinematics.poses(angles)
    crank = np.full_like(angles, speed)
    for _ in range(MAX_SWEEPS):
        gaps = kinematics.residual([poses], angles)
        rates = kinematics.solve(poses, -gaps / h - kinematics.residual([poses, np.zeros_like(poses)], crank))
        centres, speeds = centres_from_frames(mechanism, poses, rates)
        following = frames_from_centres(mechanism, centres + h * speeds, speeds)[0][:-1]
        change = float(np.abs(following - poses[1:]).max(initial=0.0))
        poses[1:] = following
        if change <= SWEEP_TOLERANCE * max(kinematics.size, 1.0):
            break
    return poses, rates


def _point_derivatives(place: tuple[Jet, Jet]) -> list[Array]:
    """Derivatives of a point's position, (T, 2) each."""
    x, y = place
    return [
        math.factorial(k) * np.column_stack(np.broadcast_arrays(a, b))
        for k, (a, b) in enumerate(zip(x.coefficients, y.coefficients, strict=True))
    ]


def _point_lags(c: list[Array], point: list[Array], phi: list[Array]) -> tuple[Array, Array, Array]:
    """Lags (T, 2) of a point behind its exact position, velocity and acceleration, for a step h = 1.

    Args:
        c: derivatives of the centre of gravity of the point's body by the crank angle, (T, 2) each [m].
        point: the same derivatives of the point, (T, 2) each [m].
        phi: the same derivatives of the body's angle, (T, 1) each [rad].
    """
    r = point[0] - c[0]
    across = np.column_stack([-r[:, 1], r[:, 0]])
    position = 0.5 * (c[2] + phi[2] * across)
    velocity = 11.0 / 24.0 * (c[3] + phi[3] * across) - 3.0 / 8.0 * phi[2] * phi[1] * r
    its_rate = 11.0 / 24.0 * (c[4] + phi[4] * across - phi[3] * phi[1] * r)
    its_rate -= 3.0 / 8.0 * ((phi[3] * phi[1] + phi[2] ** 2) * r + phi[2] * phi[1] ** 2 * across)
    return position, velocity, its_rate - point[4] / 24.0


NEGLIGIBLE_SHARE = 1e-6  # of a bound, below which rounding is not added to it


def weight_rounding(machine: Machine, h: float) -> list[float]:
    """Errors over L, omega L, omega^2 L by rounding of weight, constant forces and loads in a step h [s].

    Position, velocity and acceleration: r h, r / omega, 2 r / (omega^2 h) with r = 3 eps a h |J^-1| / L, where a is the
    largest acceleration [m/s^2] that weight, constant forces and loads alone give a body, and |J^-1| the displacement
    of an observed point when all joint equations are off by one.
    """
    kinematics, speed, angles = machine.kinematics, abs(machine.speed), machine.kinematics.angles(CRANK_SAMPLES)
    poses = kinematics.poses(angles)
    moved = dict.fromkeys(kinematics.lengths, np.zeros(len(angles)))
    for equation in np.eye(poses.shape[1]):
        rates = kinematics.solve(poses, np.tile(equation, (len(angles), 1)))
        for name, motion in kinematics.point_derivatives([poses, rates]).items():
            moved[name] = moved[name] + np.linalg.norm(motion[1], axis=1)
    gain = max(float(found.max()) / kinematics.lengths[name] for name, found in moved.items())
    left = weight_velocity_rounding(machine, h) * gain
    return [left * h, left / speed, 2.0 * left / (speed**2 * h)]


def weight_velocity_rounding(machine: Machine, h: float) -> float:
    """Rounding 3 eps a h [m/s] of the joints' velocities in a step h [s], by weight, constant forces and loads."""
    kinematics, angles = machine.kinematics, machine.kinematics.angles(CRANK_SAMPLES)
    mechanism = kinematics.mechanism
    poses, derivative = kinematics.derivatives(angles, 1)
    forces = applied_forces(mechanism, poses, machine.speed * derivative, angles / machine.speed)[:, :, :2]
    masses = np.array([body.mass for body in mechanism.bodies])
    own = forces / np.where(masses > 0.0, masses, np.inf)[:, None]
    largest = float(np.linalg.norm(own + np.asarray(mechanism.gravity), axis=2).max())
    return 3.0 * float(np.finfo(float).eps) * largest * h


MIN_FALL = 1e-12  # [m/s^2]; without any force on the follower all its steps are free
NEXT_ORDER_LAGS = (1.0 / 2.0, 11.0 / 24.0, 5.0 / 12.0)  # coefficients of the next term in h
CONTACT_LAW = "one step's free fall, the polygon's corners, half a sagitta / cos(pressure angle)"
LAW = "scheme lag: h^2 x''/2, 11/24 h^2 x''', 5/12 h^2 x'''' of centres of gravity and turns, and the next term"


def expected_error(machine: Machine, settings: PymunkSettings, start_angle: float = 0.0) -> ExpectedError:
    """Bounds on the errors of a run; none if a step leaves a share of the joint error (error_bias > 0)."""
    if settings.error_bias > 0.0:
        return ExpectedError()
    if machine.kinematics.mechanism.cam_contacts:
        return _contact_error(machine, settings)
    if machine.kinematics.change_angles.size:
        return ExpectedError(law=NO_BOUND_AT_CHANGE_POINT)
    step = 2.0 * math.pi / settings.steps_per_revolution
    sizes = largest_derivatives(machine.kinematics, 5)
    floor = rounding_bound(machine.kinematics, settings.steps_per_revolution)
    behind, first = largest_lags(machine), first_sample_errors(machine, settings.steps_per_revolution, start_angle)
    lags = [step**2 * (behind[k] + lag * step * sizes[k + 3]) for k, lag in enumerate(NEXT_ORDER_LAGS)]
    bounds = [max(lags[k], (1.0 + ITERATION_ERROR_SHARE) * first[k]) + floor / step**k for k in range(3)]
    left = weight_rounding(machine, settings.timestep)
    bounds = [b + r if r > NEGLIGIBLE_SHARE * b else b for b, r in zip(bounds, left, strict=True)]
    samples = body_tracks(*first_samples(machine, settings.steps_per_revolution, start_angle))
    links = _rotation_bounds(machine, settings, samples, weight_velocity_rounding(machine, settings.timestep))
    return ExpectedError(bounds[0], bounds[1], bounds[2], law=LAW, **links)


def _contact_error(machine: Machine, settings: PymunkSettings) -> ExpectedError:
    """Bounds for a cam: free fall in one step, corners of the polygon, and the polygon's own error."""
    follower = FollowerMotion.from_machine(machine)
    mechanism, h = machine.kinematics.mechanism, settings.timestep
    # A released follower accelerates by the force that presses it: its weight, or contact force less inertia force.
    falls: Array = np.full(1, follower_fall(mechanism))
    if mechanism.loads:
        falls = follower.force * follower.cosine / mechanism.body(follower.contact.b).mass - follower.acceleration
    fall = float(falls.max())
    polygon = rounded_polygon(follower.contact.profile, settings.cam_vertices)
    corner = abs(machine.speed) * follower.largest_slope_jump(polygon)  # speed that a corner adds
    drop = (fall + 0.5 * float(np.abs(follower.acceleration).max())) * h**2 + corner * h
    position = (drop + polygon.error / float(follower.cosine.min())) / follower.lift
    share = (
        float(_free_fall_share(follower, falls).mean())
        + _extra_free_steps(follower, polygon) / settings.steps_per_revolution
    )
    fallen = math.sqrt(min(1.0, share)) * fall * h / abs(machine.speed)
    velocity = (fallen + follower.facet_slope_rms(polygon)) / follower.lift
    return ExpectedError(position, velocity_rms=velocity, law=CONTACT_LAW)


def _free_fall_share(follower: FollowerMotion, falls: Array) -> Array:
    """Share (T,) of steps with a free fall of the follower, at each crank angle.

    A follower falls where the cam's curve falls away under it. A step uses up h^2 |s''| / 2 of the overlap g h^2 / 2; a
    free step restores it by a fall of at most g h^2 - 2 h^2 |s''|, which is not all of it if |s''| exceeds g / 4.

    Args:
        falls: g (T,) [m/s^2], or (1,) if it is constant.
    """
    away = np.maximum(0.0, -follower.acceleration) / np.maximum(falls, MIN_FALL)
    return np.where(away <= 0.25, away, np.minimum(1.0, 2.0 * away))


def _extra_free_steps(follower: FollowerMotion, polygon: CamPolygon) -> int:
    """Bound on the free steps per revolution that `_free_fall_share` does not count.

    These are the first step, one wherever the curve begins to fall away, and one wherever contact passes to the next
    of the wedges that make up the contact shape.
    """
    falling = follower.acceleration < 0.0
    return 1 + int(np.count_nonzero(falling & ~np.roll(falling, 1))) + len(wedges(polygon))


def shape_error(machine: Machine, settings: PymunkSettings) -> float:
    """Largest static error of the lift [m] of the collision shape."""
    follower = FollowerMotion.from_machine(machine)
    polygon = rounded_polygon(follower.contact.profile, settings.cam_vertices)
    return polygon.error / float(follower.cosine.min())


# -- rotations of the driven links -------------------------------------------------------------------------------------


def _rotation_bounds(machine: Machine, settings: PymunkSettings, first: BodyTracks, left: float) -> dict[str, float]:
    """Bounds on the largest errors of the driven links, by quantity of `ROTATIONS`, normalised.

    As for points they are the lag and its next term in h, or the first samples, and what rounding adds.

    Args:
        first: first samples of a run, as a converged iteration takes them.
        left: rounding of the joints' velocities in a step by what acts on the bodies [m/s].
    """
    kinematics, steps = machine.kinematics, settings.steps_per_revolution
    h = 2.0 * math.pi / steps
    derivatives = kinematics.derivatives(kinematics.angles(CRANK_SAMPLES), len(ROTATION_LAGS) + 2)
    sizes = [largest_rotation(kinematics, derivative[:, 2::3]) for derivative in derivatives]
    errors = link_errors(first, machine.speed, kinematics)
    gain = _rotation_gain(machine)
    rounding = float(np.finfo(float).eps) * steps * (1.0 + kinematics.size * gain)
    weight, speed = left * gain, abs(machine.speed)
    by_weight = (weight * settings.timestep, weight / speed, 2.0 * weight / (speed**2 * settings.timestep))
    bounds = {}
    for k, quantity in enumerate(ROTATIONS):
        lag = h**2 * ROTATION_LAGS[k] * (sizes[k + 2] + h * sizes[k + 3])
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
