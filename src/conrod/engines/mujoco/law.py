"""Bounds on MuJoCo's errors before any run, from its documented constraint model and its integrator.

Constraint model (MuJoCo documentation, Computation, 'Constraint model'): a constraint of force f keeps the residual
acceleration a = -2/(d tc) v - d/(d tc)^2 x - R f, with R = (1 - d)/d A and A the compiled inverse weight. Near rest
the gap is therefore x = (1 - d) A f tc^2, with f the joint's reaction in the exact motion; it appears within a few tc
after a start that was closed, which takes a rate of x / (e tc) and an acceleration of x / tc^2.

Integrator: RK4's local error is at most (73/720) h^5 times derivatives of the motion (Lotkin, 1951). A critically
damped closure answers a steady defect in velocity with 2 tc of it, one in acceleration with tc^2. Where tc is a few
steps the closure is stiff, and RK4 loses order (Hairer and Wanner, Solving Ordinary Differential Equations II,
section IV.15): its stages leave the curve by h^2 x''/8, and the closure pulls at that. How much stays is read off the
scalar equation y'' = x'' - 2/tc (y' - x') - (y - x)/tc^2 with x = t^2/2, one RK4 step after the other.

One pass: with defects e of position and f of velocity a step and unit of crank angle, a closure of time constant c
moves by y' = z + e, z' = -2 z/c - y/c^2 + f. From a start that is closed, y, z and z' are the defects folded with

    (1 + s/c) E and s E,    -(s/c^2) E and (1 - s/c) E,    (s/c - 1)/c^2 E and (s/c - 2)/c E,    E = exp(-s/c),

and f itself in z'. Folding their sizes bounds the errors: what is short beside c leaves little, where the largest value
of a derivative, lasting for ever, would leave much.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from conrod.engines.cam_polygon import cam_polygon
from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import Machine
from conrod.engines.follower import FollowerMotion
from conrod.engines.massless_rod import BODY
from conrod.engines.mujoco.model import build
from conrod.engines.mujoco.settings import MuJoCoSettings, exchanged_inertia
from conrod.engines.numerics import SAMPLES, UNDETERMINED, largest_derivatives, rounding
from conrod.exact.dynamics.inverse import reactions
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mesh

RK4_LOCAL = 73.0 / 720.0
CONTACT_LAW = (
    "contact sinking d tc^2 [s''(1 - h/(d tc)) + (1 - d)/d (s'' + g)/cos^2(pressure angle)], jumps of speed at"
    " the polygon's corners, and half a sagitta of it / cos(pressure angle)"
)
LAW = "regularisation (1 - d) A f tc^2 of the exact reactions; RK4's local error (Lotkin) and loss of order at stiff tc"


def expected_error(machine: Machine, settings: MuJoCoSettings) -> ExpectedError:
    """Bounds for RK4 with a constant impedance, for links as bodies that have their weight and carry nothing else.

    The drive is a flywheel, whose rate varies by what the crank exchanges with the links over what it holds.
    """
    bounds = _bounds(machine, settings)
    return replace(bounds, ripple=exchanged_inertia(machine) / settings.armature) if settings.armature > 0.0 else bounds


def _bounds(machine: Machine, settings: MuJoCoSettings) -> ExpectedError:
    none = ExpectedError()
    if settings.dressing:
        return none
    if machine.kinematics.mechanism.cam_contacts:
        return _contact_error(machine, settings)
    if machine.kinematics.change_angles.size:
        return replace(none, law=UNDETERMINED)
    if settings.rod != BODY or not settings.gravity or settings.integrator != "RK4":
        return none
    if settings.solimp[0] != settings.solimp[1] or settings.solref[1] != 1.0:
        return none
    softness, its_rate = regularisation_errors(machine, settings)
    constant = abs(machine.speed) * settings.solref[0]
    step = 2.0 * math.pi / settings.steps_per_revolution
    sizes = largest_derivatives(machine.kinematics, 8)
    floor = rounding(machine.kinematics, 2 * settings.steps_per_revolution)
    # At the start the gap opens; later on it follows the reactions, which may change fast.
    opening = softness / (math.e * constant) + softness
    yielding = (softness, max(opening, its_rate), softness / constant**2 + softness)
    local = RK4_LOCAL * step**4
    integration = [local * (2.0 * constant * sizes[k + 5] + constant**2 * sizes[k + 6]) for k in range(3)]
    if machine.kinematics.mechanism.driver.span is not None:
        integration = list(left_of_defects(machine, local, constant))
    reduction = order_reduction(constant / step)
    stiff = [sizes[2] * reduction[k] * step ** (2 - k) for k in range(3)]
    bounds = [y + i + s + floor for y, i, s in zip(yielding, integration, stiff, strict=True)]
    return ExpectedError(bounds[0], bounds[1], bounds[2], law=LAW)


def order_reduction(constant: float) -> tuple[float, float, float]:
    """Largest position, rate and acceleration error of RK4 on the scalar closure equation with x'' = 1, h = 1.

    Args:
        constant: time constant of the closure in steps.
    """
    damping, stiffness = 2.0 / constant, 1.0 / constant**2

    def slope(time: float, gap: tuple[float, float]) -> tuple[float, float]:
        return gap[1], 1.0 - damping * (gap[1] - time) - stiffness * (gap[0] - 0.5 * time**2)

    def moved(state: tuple[float, float], rate: tuple[float, float], by: float) -> tuple[float, float]:
        return state[0] + by * rate[0], state[1] + by * rate[1]

    # The closure's own coordinate is followed as an offset from the step's start, to keep its digits.
    offset, largest = (0.0, 0.0), [0.0, 0.0, 0.0]
    for _ in range(int(20 * constant) + 20):
        a = slope(0.0, offset)
        b = slope(0.5, moved(offset, a, 0.5))
        c = slope(0.5, moved(offset, b, 0.5))
        d = slope(1.0, moved(offset, c, 1.0))
        for k, error in enumerate((offset[0], offset[1], a[1] - 1.0)):
            largest[k] = max(largest[k], abs(error))
        end = [offset[k] + (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]) / 6.0 for k in (0, 1)]
        # Time and x start anew: x = t^2/2 looks the same from every point of itself, but for its own slope.
        offset = (end[0] - 0.5, end[1] - 1.0)
    return largest[0], largest[1], largest[2]


def regularisation_errors(machine: Machine, settings: MuJoCoSettings) -> tuple[float, float]:
    """Largest position error of an observed point, over its L, from the loops' giving way to their reactions.

    And the largest rate by the crank angle [1/rad] at which that error changes.

    What follows the reactions late, as a weighted mean of those before (the answer of a critically damped gap is never
    negative), changes no faster than they make it.
    """
    kinematics = machine.kinematics
    made = build(machine, settings)
    angles = kinematics.angles(SAMPLES)
    # A critically damped gap answers 1 / (1 + s tc)^2 = 1 - 2 s tc + 3 (s tc)^2 ...: it lags by twice its constant.
    constant = machine.speed * settings.solref[0]
    before = angles - 2.0 * constant
    if kinematics.mechanism.driver.span is not None:
        before = np.clip(before, *kinematics.span)  # the machine is not anywhere before the pass
    forces = reactions(kinematics, before, machine.speed).joints
    gaps = np.zeros((len(angles), 3 * len(kinematics.mechanism.bodies)))
    row = 0
    for joint in kinematics.mechanism.joints:
        rows = kinematics.equations_of(joint)
        if joint in made.tree.cuts or isinstance(joint, Mesh):
            # Gap per force [m/N] near rest.
            compliance = (1.0 - settings.solimp[0]) * made.inverse_weight(joint.name) * settings.solref[0] ** 2
            gaps[:, row : row + rows] = compliance * forces[joint.name]
        row += rows
    error, rate = _largest_point_errors(kinematics, angles, gaps)
    return error * (1.0 + 3.0 * constant**2), rate


def _largest_point_errors(kinematics: Kinematics, angles: Array, gaps: Array) -> tuple[float, float]:
    """Largest move of observed points by gaps of the joints (T, 3 n), over L, and its rate by the crank angle."""
    poses = kinematics.poses(angles)
    given_way = poses.copy()
    for _ in range(2):  # the second step takes in what the gaps themselves change of the geometry
        left = kinematics.residual([given_way], angles) - gaps
        given_way -= kinematics.solve(given_way, left)
    exact, moved = kinematics.point_derivatives([poses]), kinematics.point_derivatives([given_way])
    off = [(moved[name][0] - exact[name][0]) / kinematics.lengths[name] for name in exact]
    rates = [np.gradient(error, angles, axis=0, edge_order=2) for error in off]
    largest, fastest = (max(float(np.linalg.norm(e, axis=1).max()) for e in errors) for errors in (off, rates))
    return largest, fastest


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
    # At a corner of the polygon the follower's speed jumps; a critically damped contact gives v tc / e to that. A step
    # may take in two corners.
    corner = 2.0 * abs(machine.speed) * follower.largest_corner(polygon) * impedance * constant / math.e
    # Semi-implicit Euler's velocity is the difference of the last two positions, half a step old.
    stale = h * float(np.abs(follower.acceleration).max()) / abs(machine.speed)
    settling = follower.corner_slope_rms(polygon, abs(machine.speed) * constant / 2.0)
    slope = math.hypot(follower.facet_slope_rms(polygon), settling) + stale
    return ExpectedError(
        (sinking + corner + shape) / follower.lift, velocity_rms=slope / follower.lift, law=CONTACT_LAW
    )


def shape_error(machine: Machine, settings: MuJoCoSettings) -> float:
    """Largest error of the lift [m] that the collision mesh has, held still: facets, and single precision."""
    follower = FollowerMotion.of(machine)
    polygon = cam_polygon(follower.contact.profile, settings.cam_vertices)
    single = float(np.finfo(np.float32).eps) * float(np.abs(polygon.vertices).max())
    return (polygon.error + single) / float(follower.cosine.min())


# -- one pass: what local errors leave of closures that start closed ---------------------------------------------------

PASS_SAMPLES = 1440


def left_of_defects(machine: Machine, local: float, constant: float) -> tuple[float, float, float]:
    """Largest error of position, velocity and acceleration of observed points over their L, by the crank angle.

    Args:
        machine: one that makes a pass.
        local: local error over the fifth derivative of the motion, for a unit of crank angle.
        constant: time constant of the closures [rad].
    """
    start, stop = machine.kinematics.span
    angles = np.linspace(*((start, stop) if machine.speed > 0.0 else (stop, start)), PASS_SAMPLES + 1)
    fifth, sixth = (local * sizes for sizes in _sizes(machine.kinematics, angles))
    return largest_errors(fifth, sixth, abs(stop - start) / PASS_SAMPLES, constant)


def largest_errors(steady: Array, growing: Array, spacing: float, constant: float) -> tuple[float, float, float]:
    """Bounds on y, z and z' of a closure that starts closed, under defects of no more than given sizes.

    Args:
        steady, growing: sizes of e and f (T,), at equal distances.
        spacing: of the samples [rad].
        constant: time constant of the closure [rad].
    """
    s = spacing * np.arange(len(steady)) / constant
    decay = np.exp(-s)
    kernels = (
        ((1.0 + s) * decay, constant * s * decay),
        (s / constant * decay, np.abs(1.0 - s) * decay),
        (np.abs(s - 1.0) / constant**2 * decay, np.abs(s - 2.0) / constant * decay),
    )
    errors = [_folded(e, steady, spacing) + _folded(f, growing, spacing) for e, f in kernels]
    errors[2] = errors[2] + growing
    position, velocity, acceleration = (float(error.max()) for error in errors)
    return position, velocity, acceleration


def _sizes(kinematics: Kinematics, angles: Array) -> tuple[Array, Array]:
    """Fifth and sixth derivative by the crank angle (T,) of whatever point has the larger one, over its L."""
    points = kinematics.point_derivatives(kinematics.derivatives(angles, 6))
    fifth, sixth = (
        np.array([np.linalg.norm(values[k], axis=1) / kinematics.lengths[name] for name, values in points.items()])
        for k in (5, 6)
    )
    return fifth.max(axis=0), sixth.max(axis=0)


def _folded(kernel: Array, defect: Array, spacing: float) -> Array:
    """Integral of kernel(s) defect(t - s) over s from 0 to t (T,); each interval with the larger of its ends."""
    larger = np.maximum(defect[:-1], defect[1:])
    highest = np.maximum(kernel[:-1], kernel[1:])
    return np.concatenate([[0.0], spacing * np.convolve(highest, larger)[: len(larger)]])
