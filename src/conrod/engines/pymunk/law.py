"""Bounds on pymunk's errors by its own scheme, from the step and the exact motion.

With full correction (error_bias = 0), x_(n+1) = x_n + h v_n, where v_n fits the joints' equations linearised at x_n.
Expanding both gives a position that runs behind the exact one by h^2 x'' / 2 (primes: by the crank angle, h the step
in crank angle). The velocity, the difference of two positions, belongs to the middle of the step:
h^2 x''' (1/24 - 1/2); the acceleration, the difference of two velocities: h^2 x'''' (1/12 - 1/2). This holds of the
engine's own coordinates, from which that of points elsewhere on a link follows.

What the scheme lags in are its own coordinates, the centres of gravity c and the turns phi of the bodies: by h^2 q'' /
2 in position, and in velocity, the difference of two positions, by h^2 q''' (1/2 - 1/24) in the middle of the step. The
turn there is extrapolated straight ahead with that velocity, and is behind by h^2 phi'' (1/2 - 1/4 + 1/8). A point at r
from the centre of gravity has the velocity c' + phi' r_perp, so that all of it enters. The acceleration is the
difference of two velocities.

To the next order the position's lag is -h^2 q''/2 + h^3 (q'''/3 + J^-1 H q' q''/2), with the joint equations' Jacobian
J and their second derivatives H. The first step goes straight ahead from an exact state, and has no last term: the
first difference after it, the first reported velocity, is off by h^2 b more, b = J^-1 H q' q''/2. The next step, one of
Newton's, keeps h^4 J^-1 H q' b of that place, which is h^2 J^-1 H q' b in the first reported acceleration.

On a cam the follower sinks by at most the slop, until the curve falls away from under it; then it falls free for one
step, from rest against the tangent: by g h^2 and what the curve itself departs, h^2 |s''|/2 (h in seconds), at a speed
of g h. Where a corner of the polygon falls into that step, its jump of speed acts for the step. The rounded polygon's
own error comes on top, by the pressure angle's cosine. Free steps are few, and the rms of velocities is theirs: g h in
each of them, and beside them that of the facets.
"""

from __future__ import annotations

import math

import numpy as np

from conrod.engines.cam_polygon import CamPolygon
from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import Machine
from conrod.engines.follower import FollowerMotion
from conrod.engines.massless_rod import BODY, model_form
from conrod.engines.numerics import SAMPLES, UNDETERMINED, largest_derivatives, rounding
from conrod.engines.pymunk.built import shaft_centred
from conrod.engines.pymunk.settings import PymunkSettings, follower_fall
from conrod.engines.pymunk.space import rounded_polygon, wedges
from conrod.exact.jet import Jet, sine_cosine
from conrod.exact.joint_equations import PoseJet, pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism

ORDER = 4  # derivatives by the crank angle that enter


def largest_lags(machine: Machine, start: float = 0.0) -> tuple[float, float, float]:
    """Largest errors of observed points over their L, of position, velocity, acceleration, for h = 1 in crank angle.

    Args:
        start: crank angle [rad] at which the run begins; the begin of the driver's span where there is one.
    """
    kinematics = machine.kinematics
    mechanism = shaft_centred(model_form(kinematics.mechanism, BODY)).mechanism
    if kinematics.mechanism.driver.span is not None:
        start = kinematics.span[0 if machine.speed > 0.0 else 1]
    # The start stands before the samples.
    derivatives = kinematics.derivatives(np.concatenate([[start], kinematics.angles(SAMPLES)]), ORDER)
    # The lag belongs to the sense of the motion: seen backwards, odd derivatives change their sign.
    sense = math.copysign(1.0, machine.speed)
    derivatives = [sense**k * d for k, d in enumerate(derivatives)]
    bodies = pose_jets(mechanism, [d / math.factorial(k) for k, d in enumerate(derivatives)])
    begun = [d[:1] for d in derivatives]
    first = _first_step(kinematics, mechanism, begun)
    second = _second_step(kinematics, mechanism, begun, first)
    largest = np.zeros(3)
    for observed in mechanism.observed:
        pose = bodies[observed.body]
        centre = _derivatives(pose.point(mechanism.body(observed.body).centre_of_gravity))
        point = _derivatives(pose.point(observed.point))
        turns = [math.factorial(k) * np.asarray(c)[:, None] for k, c in enumerate(pose.phi.coefficients)]
        position, velocity, acceleration = _lags(centre, point, turns)
        i = 3 * mechanism.body_index[observed.body]
        arm = point[0][0] - derivatives[0][0, i : i + 2]
        for lag, more in ((velocity, first), (acceleration, second)):
            lag[0] -= more[i : i + 2] + more[i + 2] * np.array([-arm[1], arm[0]])
        sizes = [np.linalg.norm(lag, axis=1).max() for lag in (position, velocity, acceleration)]
        largest = np.maximum(largest, np.array(sizes) / kinematics.lengths[observed.name])
    return float(largest[0]), float(largest[1]), float(largest[2])


def _first_step(kinematics: Kinematics, mechanism: Mechanism, derivatives: list[Array]) -> Array:
    """J^-1 H q' q'' / 2 (3 n,) as a change of the poses, H in the coordinates of the centres of gravity."""
    bodies = pose_jets(mechanism, [d / math.factorial(k) for k, d in enumerate(derivatives[:4])])
    with_bend, without = (_straight(mechanism, bodies, bends) for bends in (2, 1))
    crank = np.zeros(1)
    # The terms of third order differ by H q' q''/2 alone; the driver's row has none.
    bent = kinematics.residual(with_bend, crank) - kinematics.residual(without, crank)
    bent[:, -1] = 0.0
    return np.asarray(np.linalg.solve(kinematics.jacobian(derivatives[0]), bent[:, :, None])[0, :, 0]) / 6.0


def _second_step(kinematics: Kinematics, mechanism: Mechanism, derivatives: list[Array], first: Array) -> Array:
    """J^-1 H q' b (3 n,) as a change of the poses, with b (3 n,) what the first step leaves."""
    poses, slopes = derivatives[:2]
    # H u u is what a straight way along u bends the equations by; H q' b is a quarter of a difference of two of them.
    bends = []
    for along in (slopes + first, slopes - first):
        bodies = pose_jets(mechanism, [poses, along, np.zeros_like(poses), np.zeros_like(poses)])
        bends.append(kinematics.residual(_straight(mechanism, bodies, 1)[:3], np.zeros(1)))
    bent = bends[0] - bends[1]
    bent[:, -1] = 0.0
    return np.asarray(kinematics.solve(poses, bent)[0]) / 4.0


def _straight(mechanism: Mechanism, bodies: dict[str, PoseJet], last: int) -> list[Array]:
    """Derivatives of poses (1, 3 n) whose centres of gravity and turns have none beyond an order."""
    columns: list[Jet] = []
    for body in mechanism.bodies:
        cut = [_cut(jet, last) for jet in (*bodies[body.name].point(body.centre_of_gravity), bodies[body.name].phi)]
        poses = pose_of_centre(body.centre_of_gravity, *cut)
        columns += poses
    return [math.factorial(k) * np.column_stack([np.ravel(jet.coefficients[k]) for jet in columns]) for k in range(4)]


def _cut(jet: Jet, last: int) -> Jet:
    return Jet([c if k <= last else 0.0 * np.asarray(c) for k, c in enumerate(jet.coefficients)])


def pose_of_centre(centre: tuple[float, float], x: Jet, y: Jet, phi: Jet) -> tuple[Jet, Jet, Jet]:
    """Pose of a body's frame from the place of its centre of gravity and its turn."""
    away = PoseJet(0.0 * x, 0.0 * y, phi, *sine_cosine(phi)).point(centre)
    return x - away[0], y - away[1], phi


def _derivatives(place: tuple[Jet, Jet]) -> list[Array]:
    """Of a point, each (T, 2)."""
    x, y = place
    return [
        math.factorial(k) * np.column_stack(np.broadcast_arrays(a, b))
        for k, (a, b) in enumerate(zip(x.coefficients, y.coefficients, strict=True))
    ]


def _lags(c: list[Array], point: list[Array], phi: list[Array]) -> tuple[Array, Array, Array]:
    """Of a point of a body, from its centre of gravity c, the point and the turn phi with their derivatives."""
    r = point[0] - c[0]
    across = np.column_stack([-r[:, 1], r[:, 0]])
    position = 0.5 * (c[2] + phi[2] * across)
    velocity = 11.0 / 24.0 * (c[3] + phi[3] * across) - 3.0 / 8.0 * phi[2] * phi[1] * r
    its_rate = 11.0 / 24.0 * (c[4] + phi[4] * across - phi[3] * phi[1] * r)
    its_rate -= 3.0 / 8.0 * ((phi[3] * phi[1] + phi[2] ** 2) * r + phi[2] * phi[1] ** 2 * across)
    return position, velocity, its_rate - point[4] / 24.0


NEXT_LAGS = (1.0 / 2.0, 11.0 / 24.0, 5.0 / 12.0)  # of the next term in h
CONTACT_LAW = (
    "one step's free fall, (g + |s''|/2) h^2, jumps of speed at the polygon's corners, and half a sagitta of it / "
    "cos(pressure angle); velocity's rms: g h in the steps of free fall, a share |s''|/g where the curve falls away"
)
LAW = (
    "scheme lag: h^2 x''/2, 11/24 h^2 x''', 5/12 h^2 x'''' of the links' centres of gravity and of their turns, and "
    "the next term in h"
)


def expected_error(machine: Machine, settings: PymunkSettings, start_angle: float = 0.0) -> ExpectedError:
    """Bounds for full correction; none where a share of the error is left at each step, or a rod is no body."""
    if settings.error_bias > 0.0 or settings.dressing or settings.rod != BODY:
        return ExpectedError()
    if machine.kinematics.mechanism.cam_contacts:
        return _contact_error(machine, settings)
    if machine.kinematics.change_angles.size:
        return ExpectedError(law=UNDETERMINED)
    step = 2.0 * math.pi / settings.steps_per_revolution
    sizes = largest_derivatives(machine.kinematics, 5)
    floor = rounding(machine.kinematics, settings.steps_per_revolution)
    behind = largest_lags(machine, start_angle)
    bounds = [step**2 * (behind[k] + lag * step * sizes[k + 3]) + floor / step**k for k, lag in enumerate(NEXT_LAGS)]
    return ExpectedError(bounds[0], bounds[1], bounds[2], law=LAW)


def _contact_error(machine: Machine, settings: PymunkSettings) -> ExpectedError:
    follower = FollowerMotion.of(machine)
    fall, h = follower_fall(machine.kinematics.mechanism), settings.timestep
    polygon = rounded_polygon(follower.contact.profile, settings.cam_vertices)
    corner = abs(machine.speed) * follower.largest_corner(polygon)  # speed that a corner adds
    drop = (fall + 0.5 * float(np.abs(follower.acceleration).max())) * h**2 + corner * h
    position = (drop + polygon.error / float(follower.cosine.min())) / follower.lift
    share = float(_free_share(follower, fall).mean()) + _other_free(follower, polygon) / settings.steps_per_revolution
    fallen = math.sqrt(min(1.0, share)) * fall * h / abs(machine.speed)
    velocity = (fallen + follower.facet_slope_rms(polygon)) / follower.lift
    return ExpectedError(position, velocity_rms=velocity, law=CONTACT_LAW)


def _free_share(follower: FollowerMotion, fall: float) -> Array:
    """Share (T,) of steps that a follower falls free in, where the curve falls away under it.

    It uses up an overlap of g h^2 / 2 by h^2 |s''| / 2 a step, and has it again after one free step, which falls by
    g h^2 less 2 h^2 |s''| at most: with |s''| above g / 4 not all of it.
    """
    away = np.maximum(0.0, -follower.acceleration) / fall
    return np.where(away <= 0.25, away, np.minimum(1.0, 2.0 * away))


def _other_free(follower: FollowerMotion, polygon: CamPolygon) -> int:
    """Free steps of a turn at most, beside them: the first, a begun one where the curve begins to fall away, and where
    contact passes from one of the shapes that the cam is made of to the next.
    """
    falling = follower.acceleration < 0.0
    return 1 + int(np.count_nonzero(falling & ~np.roll(falling, 1))) + len(wedges(polygon))


def shape_error(machine: Machine, settings: PymunkSettings) -> float:
    """Largest error of the lift [m] that the collision shape has, held still."""
    follower = FollowerMotion.of(machine)
    polygon = rounded_polygon(follower.contact.profile, settings.cam_vertices)
    return polygon.error / float(follower.cosine.min())
