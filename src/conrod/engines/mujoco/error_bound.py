"""Bounds on MuJoCo's errors before any run, from its documented constraint model and integrators.

The independent variable is the crank's travel s [rad] in its sense of motion; a prime is d/ds. MuJoCo accelerates joint
coordinates so that the gap g of each closure obeys

    g'' + (2/c) g' + g/c^2 = p(s),    c = solref[0] |omega|

with the push p of the closure's compliance under its force (MuJoCo documentation, Computation, "Constraint model", and
Modeling, "Solver parameters"). The equation is linear whatever the mechanism, so an integrator enters only by the gap
and rate that each of its steps leaves. One step of RK4 from the exact state leaves gaps and rates that grow as h^5;
they are computed by taking that step, with four evaluations of the joint equations at the stages, which lie off the
joints. Integrated with their signs from the exact start, they are the error of the run, except for terms of second
order in that error. Errors of contact are bounded, not predicted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from conrod.engines.cam_polygon import FollowerMotion, cam_polygon
from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import Machine
from conrod.engines.mujoco import MIN_TIME_CONSTANT_STEPS, MuJoCoSettings, compat, exchanged_inertia
from conrod.engines.mujoco.model import MuJoCoModel, build
from conrod.engines.numerics import CRANK_SAMPLES, NO_BOUND_AT_CHANGE_POINT, rounding_bound
from conrod.engines.spanning_tree import SpanningTree
from conrod.exact.dynamics.inverse import steady_joint_forces
from conrod.exact.joint_equations import pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.link_rotations import ROTATIONS, largest_rotation
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mesh

MIN_SPACING = 2.0 * math.pi / 1440.0  # [rad] between samples of a course; several shorter steps share one sample
STEPS_PER_TIME_CONSTANT = 8.0  # local errors grow as h^5 for steps up to this part of the time constant
# After the start, where the gaps open: spacing of samples and duration of this phase [time constants].
OPENING_SPACING, OPENING_DURATION = 0.1, 8.0
GAIN_POSES = 72  # poses at which the displacement of points per gap is computed
MERGED_SPACING = 1e-3  # of a step: samples that lie closer are merged
START_TIME_CONSTANTS = 10.0  # after which gaps no longer depend on the start


@dataclass(frozen=True)
class DrivenCourse:
    """Exact states of a run, as functions of the crank's travel.

    Attributes:
        sense: +1 if the crank angle grows with the travel, else -1.
        angles: crank angles (T,) [rad] from the start.
        states: poses and their first and second derivatives by the travel s, (T, 3 n) each.
    """

    kinematics: Kinematics
    sense: float
    angles: Array
    states: tuple[Array, Array, Array]

    @property
    def steps(self) -> Array:
        """Travel [rad] from each sample to the next (T - 1,)."""
        return np.abs(np.diff(self.angles))

    @classmethod
    def sample_course(cls, machine: Machine, start_angle: float, step: float, constant: float) -> DrivenCourse:
        """Sample the exact states of a run until its gaps repeat, or over the driver's span.

        Args:
            start_angle: crank angle [rad] at the start; an input that makes one pass starts at an end of its span.
            step: step of the run [rad].
            constant: time constant c of the closures [rad].
        """
        kinematics, sense = machine.kinematics, math.copysign(1.0, machine.speed)
        spacing, length, span = max(step, MIN_SPACING), 2.0 * math.pi, kinematics.mechanism.driver.span
        if span is not None:
            start_angle, length = span[0] if sense > 0.0 else span[1], span[1] - span[0]
        elif kinematics.repeats:
            length *= math.ceil(1.0 + START_TIME_CONSTANTS * constant / length)
        else:
            length *= 2.0
        even = spacing * np.arange(math.floor(length / spacing * (1.0 + 1e-12)) + 1)
        early = np.arange(0.0, min(OPENING_DURATION * constant, length), max(step, OPENING_SPACING * constant))
        travel = np.union1d(even, early) if spacing > step else even
        travel = travel[np.diff(travel, prepend=-step) > MERGED_SPACING * step]
        angles: Array = np.asarray(start_angle + sense * travel, dtype=float)
        poses, first, second = kinematics.derivatives(angles, 2)
        return cls(kinematics, sense, angles, (poses, sense * first, second))

    def joint_gaps(self, states: list[Array], ahead: float = 0.0) -> Array:
        """Gaps of all joints (T, 3 n) at given states, or their rates or accelerations, by the last state given."""
        crank = (self.angles + self.sense * ahead, np.full_like(self.angles, self.sense), np.zeros_like(self.angles))
        return self.kinematics.residual(states, crank[len(states) - 1])


def rk4_local_errors(tree: SpanningTree, course: DrivenCourse, constant: float, step: float) -> tuple[Array, Array]:
    """Gaps and gap rates (T, 3 n) after one step of RK4 from each exact state, divided by the step.

    Args:
        constant: time constant c of the closures [rad].
        step: step of the run [rad].
    """
    # What a shorter step leaves would be lost in rounding, so a longer one is taken and scaled by h^5.
    h = max(step, min(MIN_SPACING, constant / STEPS_PER_TIME_CONSTANT))

    def acceleration(q: Array, rate: Array, ahead: float) -> Array:
        """Accelerations of the coordinates by the closures' springs, the crank `ahead` of the step's begin [rad]."""
        poses, speeds = tree.forward_kinematics(q, rate)
        pull = course.joint_gaps([poses, speeds, np.zeros_like(poses)], ahead)
        pull += 2.0 / constant * course.joint_gaps([poses, speeds], ahead)
        pull += course.joint_gaps([poses], ahead) / constant**2
        return tree.accelerations(poses, speeds, -course.kinematics.solve(poses, pull))

    poses, speeds, _ = course.states
    q, v1 = tree.coordinates(poses), tree.rates(poses, speeds)
    a1 = acceleration(q, v1, 0.0)
    v2 = v1 + 0.5 * h * a1
    a2 = acceleration(q + 0.5 * h * v1, v2, 0.5 * h)
    v3 = v1 + 0.5 * h * a2
    a3 = acceleration(q + 0.5 * h * v2, v3, 0.5 * h)
    v4 = v1 + h * a3
    a4 = acceleration(q + h * v3, v4, h)
    poses, speeds = tree.forward_kinematics(
        q + h / 6.0 * (v1 + 2.0 * (v2 + v3) + v4), v1 + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
    )
    over = (step / h) ** 4 / h
    return over * course.joint_gaps([poses], h), over * course.joint_gaps([poses, speeds], h)


def compliance_acceleration(
    machine: Machine, settings: MuJoCoSettings, made: MuJoCoModel, course: DrivenCourse
) -> Array:
    """Push p = -(1 - d) w f / omega^2 of each gap (T, 3 n), by the closures' compliance.

    d is the impedance solimp[0], w the compiled inverse weight of the closure, f the exact reaction.
    """
    forces = steady_joint_forces(course.kinematics, course.angles, machine.speed).components
    found = np.zeros_like(course.states[0])
    row = 0
    for joint in course.kinematics.mechanism.joints:
        rows = course.kinematics.equations_of(joint)
        if joint in made.tree.cuts or isinstance(joint, Mesh):
            give = (1.0 - settings.solimp[0]) * made.inverse_weight(joint.name) / machine.speed**2
            found[:, row : row + rows] = -give * np.column_stack([*forces[joint.name].values()])
        row += rows
    return found


def integrate_gaps(
    steps: Array, local_errors: tuple[Array, Array], push: Array, constant: float
) -> tuple[Array, Array, Array]:
    """Integrate g'' + (2/c) g' + g/c^2 = p from closed gaps: gaps, rates, accelerations (T, n).

    On a step, p is linear and the solution exact: c^2 p - 2 c^3 p' plus a part that decays as exp(-s/c). The
    integrator's own local errors are added after each step.

    Args:
        steps: travel [rad] between the samples (T - 1,).
        local_errors: gaps and gap rates (T, n) per unit of travel that each sample's own step leaves.
        push: p (T, n), linear between samples.
        constant: time constant c of the closures [rad].
    """
    c = constant
    gaps, rates = np.zeros_like(push), np.zeros_like(push)
    for k, s in enumerate(steps):
        # With p linear, p + r s, a linear solution is c^2 (p + r s) - 2 c^3 r; the rest decays.
        slope = (push[k + 1] - push[k]) / s
        gap = gaps[k] - c**2 * push[k] + 2.0 * c**3 * slope
        rate = rates[k] - c**2 * slope
        decay = math.exp(-s / c)
        gaps[k + 1] = decay * ((1.0 + s / c) * gap + s * rate) + c**2 * push[k + 1] - 2.0 * c**3 * slope
        rates[k + 1] = decay * ((1.0 - s / c) * rate - s / c**2 * gap) + c**2 * slope
        gaps[k + 1] += s * local_errors[0][k]
        rates[k + 1] += s * local_errors[1][k]
    return gaps, rates, push - 2.0 / c * rates - gaps / c**2


def predicted_gaps(
    machine: Machine, settings: MuJoCoSettings, made: MuJoCoModel, start_angle: float
) -> tuple[DrivenCourse, Array, tuple[Array, Array, Array]]:
    """Exact states of a run, the push on its gaps (T, 3 n), and the gaps with two derivatives by s."""
    constant, step = abs(machine.speed) * settings.solref[0], 2.0 * math.pi / settings.steps_per_revolution
    course = DrivenCourse.sample_course(machine, start_angle, step, constant)
    left = rk4_local_errors(made.tree, course, constant, step)
    pushed = compliance_acceleration(machine, settings, made, course)
    return course, pushed, integrate_gaps(course.steps, left, pushed, constant)


def closure_errors(
    machine: Machine, settings: MuJoCoSettings, made: MuJoCoModel, start_angle: float
) -> tuple[Array, Array]:
    """Predicted largest errors (2, 3) of observed points and of links, normalised, and the rounding in them (2, 3).

    Points are over L, omega L, omega^2 L, and links over their range of rotation R, omega R, omega^2 R.

    The three are position, velocity and acceleration. A step that always rounds to the same side leaves eps times the
    largest angle; the response of a gap and its derivatives to a unit of gap and of rate at each step bounds the sum.
    """
    course, pushed, gaps = predicted_gaps(machine, settings, made, start_angle)
    c = abs(machine.speed) * settings.solref[0]
    turn = max(float(np.abs(course.states[0][:, 2::3]).max()) / (4.0 * math.pi), 1.0)
    answers = np.array([2.0 * c + c**2, 1.0 + 2.0 / math.e * c, 2.0 / (math.e * c) + 1.0 + 2.0 / math.e**2])
    rounded = rounding_bound(machine.kinematics, 2 * settings.steps_per_revolution) * turn * np.maximum(answers, 1.0)
    gains = _largest_gains(course, np.flatnonzero(pushed.any(axis=0)))
    moved = states_with_gaps(course, gaps)
    errors = np.array([_point_errors(course, moved), largest_rotation_errors(course, moved)])
    return errors, np.outer(gains, rounded)


def _largest_gains(course: DrivenCourse, rows: Any) -> tuple[float, float]:
    """Largest displacement of an observed point over its L, and of a link's rotation over its range R, by gaps.

    The gaps are of the largest travel; each gain is at least 1.
    """
    kinematics, poses = course.kinematics, course.states[0][:: max(1, len(course.angles) // GAIN_POSES)]
    largest = turned = 1.0
    for row in rows:
        gap = np.zeros_like(poses)
        gap[:, row] = kinematics.travel
        change = kinematics.solve(poses, gap)
        for name, (_, move) in kinematics.point_derivatives([poses, change]).items():
            largest = max(largest, float(np.linalg.norm(move, axis=1).max()) / kinematics.lengths[name])
        turned = max(turned, largest_rotation(kinematics, change[:, 2::3]))
    return largest, turned


def states_with_gaps(course: DrivenCourse, gaps: tuple[Array, Array, Array]) -> list[Array]:
    """Poses and their derivatives by s, (T, 3 n) each, of a machine whose joints have given gaps."""
    moved: list[Array] = []
    for k, (exact, gap) in enumerate(zip(course.states, gaps, strict=True)):
        state = exact
        # The second step of the poses includes the change of geometry by the gaps; derivatives are linear in them.
        for _ in range(1 if k else 2):
            state = state - course.kinematics.solve(moved[0] if k else state, course.joint_gaps([*moved, state]) - gap)
        moved.append(state)
    return moved


def largest_point_errors(course: DrivenCourse, gaps: tuple[Array, Array, Array]) -> Array:
    """Largest changes (3,) over L that gaps make in observed points and their derivatives by s."""
    return _point_errors(course, states_with_gaps(course, gaps))


def largest_rotation_errors(course: DrivenCourse, moved: list[Array]) -> Array:
    """Largest changes (3,) over R of the driven links' rotations and their derivatives by s, in states off the exact.

    Args:
        moved: poses and their derivatives by s, (T, 3 n) each, as `states_with_gaps` returns them.
    """
    pairs = zip(moved, course.states, strict=True)
    return np.array([largest_rotation(course.kinematics, (after - exact)[:, 2::3]) for after, exact in pairs])


def _point_errors(course: DrivenCourse, moved: list[Array]) -> Array:
    """Largest changes (3,) over L of the observed points and their derivatives by s, in states off the exact ones."""
    before, after = course.kinematics.point_derivatives(list(course.states)), course.kinematics.point_derivatives(moved)
    off = [
        [np.linalg.norm(moved - exact, axis=1).max() for moved, exact in zip(after[name], before[name], strict=True)]
        for name in before
    ]
    lengths = np.array([course.kinematics.lengths[name] for name in before])
    return np.asarray((np.array(off) / lengths[:, None]).max(axis=0))


# -- bounds ------------------------------------------------------------------------------------------------------------


# Margins for what the prediction neglects: RK4's own error in stepping a closure, as a share of the error, and terms of
# second order, as a multiple of the error. No more than 2 % was found where errors are below 0.005.
PREDICTION_MARGIN, SECOND_ORDER_MARGIN = 0.05, 10.0
FALL_RMS = math.sqrt(1.1)  # over the speed of a fall in one step: 1 for that step, 0.18^2, 0.2^2, .. for the next
CONTACT_LAW = "contact sinking, a fall in the first step, the polygon's corners, half a sagitta / cos(pressure angle)"
LAW = (
    "(1.05 + 10 e_x) e + rounding; e (e_x of position) is the error by each closure's gap g: "
    "g'' + 2 g'/c + g/c² = p + d, with its spring's time constant c, push p of the exact reactions, step error d of RK4"
)


def expected_error(machine: Machine, settings: MuJoCoSettings, start_angle: float = 0.0) -> ExpectedError:
    """Bounds on the errors of a run: of linkages by RK4 with constant impedance, of cams by their contact.

    There are none for other settings, for bodies without weight, or for models with edits.
    The drive is a flywheel, whose rate varies by the energy that the crank exchanges with the links over its own.
    """
    if not machine.kinematics.mechanism.cam_contacts and not compat.CLOSURES_ARE_BOUNDED:
        return ExpectedError(law=compat.UNBOUNDED_REASON)
    bounds = _error_without_ripple(machine, settings, start_angle)
    return replace(bounds, ripple=speed_ripple_bound(machine, settings.armature)) if settings.armature > 0.0 else bounds


def speed_ripple_bound(machine: Machine, armature: float) -> float:
    """Bound on the relative variation of the crank speed with a flywheel [kg m^2] as drive.

    It is the larger of the exchanged inertia of the observed points, by which the flywheel is chosen, and the variation
    of the links' inertia reduced to the crank, over the armature: near its ends a rocker rotates its links faster than
    points move.
    """
    return max(exchanged_inertia(machine), _inertia_variation(machine)) / armature


def _inertia_variation(machine: Machine) -> float:
    """Variation over a revolution of all bodies' inertia reduced to the crank [kg m^2]."""
    kinematics = machine.kinematics
    bodies = pose_jets(kinematics.mechanism, kinematics.derivatives(kinematics.angles(CRANK_SAMPLES), 1))
    felt = np.zeros(CRANK_SAMPLES)
    for body in kinematics.mechanism.bodies:
        x, y = (jet.coefficients[1] for jet in bodies[body.name].point(body.centre_of_gravity))
        felt += body.mass * (x**2 + y**2) + body.inertia * bodies[body.name].phi.coefficients[1] ** 2
    return float(np.ptp(felt))


def has_error_law(settings: MuJoCoSettings) -> bool:
    """Return True for settings whose closures the law describes: RK4, one impedance, critical damping."""
    if settings.dressing or not settings.gravity or settings.integrator != "RK4":
        return False
    # MuJoCo raises a shorter time constant, or RK4 cannot follow it.
    if settings.solref[0] < MIN_TIME_CONSTANT_STEPS * settings.timestep:
        return False
    return settings.solimp[0] == settings.solimp[1] and settings.solref[1] == 1.0


def _error_without_ripple(machine: Machine, settings: MuJoCoSettings, start_angle: float) -> ExpectedError:
    """Bounds on the errors of linkages by their predicted gaps, and of cams by contact."""
    none = ExpectedError()
    if machine.kinematics.mechanism.cam_contacts:
        return none if settings.dressing else _contact_error(machine, settings)
    if machine.kinematics.change_angles.size:
        return replace(none, law=NO_BOUND_AT_CHANGE_POINT)
    if not has_error_law(settings):
        return none
    errors, rounded = closure_errors(machine, settings, build(machine, settings), start_angle)
    bounds = errors * (1.0 + PREDICTION_MARGIN + SECOND_ORDER_MARGIN * errors[:, :1]) + rounded
    (position, velocity, acceleration), links = bounds.tolist()
    return ExpectedError(position, velocity, acceleration, law=LAW, **dict(zip(ROTATIONS, links, strict=True)))


def _contact_error(machine: Machine, settings: MuJoCoSettings) -> ExpectedError:
    """Bounds for a contact of constant impedance, with a time constant in steps, under Euler."""
    impedance, stiffest = settings.contact_solimp[:2]
    if impedance != stiffest or settings.integrator != "Euler" or settings.contact_solref[1] != 1.0:
        return ExpectedError()
    follower = FollowerMotion.from_machine(machine)
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
    corner = 2.0 * abs(machine.speed) * follower.largest_slope_jump(polygon) * impedance * constant / math.e
    # Semi-implicit Euler's velocity is the difference of the last two positions, half a step old.
    stale = h * float(np.abs(follower.acceleration).max()) / abs(machine.speed)
    settling = follower.corner_slope_rms(polygon, abs(machine.speed) * constant / 2.0)
    # The fall's speed in one step per revolution; the contact returns a fifth of it.
    fallen = FALL_RMS * fall / h / abs(machine.speed) / math.sqrt(settings.steps_per_revolution)
    slope = math.hypot(follower.facet_slope_rms(polygon), settling, fallen) + stale
    return ExpectedError(
        (max(sinking, fall) + corner + shape) / follower.lift, velocity_rms=slope / follower.lift, law=CONTACT_LAW
    )


def shape_error(machine: Machine, settings: MuJoCoSettings) -> float:
    """Largest static error of the lift [m] of the collision mesh: facets, and single precision."""
    follower = FollowerMotion.from_machine(machine)
    polygon = cam_polygon(follower.contact.profile, settings.cam_vertices)
    single = float(np.finfo(np.float32).eps) * float(np.abs(polygon.vertices).max())
    return (polygon.error + single) / float(follower.cosine.min())
