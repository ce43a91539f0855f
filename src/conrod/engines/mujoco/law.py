"""Bounds on MuJoCo's errors before any run, from its documented constraint model and its integrator.

Errors that soft closures and RK4 make of the exact motion are predicted sample by sample, and contact's bounded.
MuJoCo accelerates joint coordinates q so that each closure's gap g follows g'' = -2/c g' - g/c^2 - R f, with c the time
constant and R f what it gives way to its force (MuJoCo documentation, Computation, 'Constraint model'). That is linear
whatever the mechanism, so all that an integrator does to a gap is what its steps leave. One step of RK4 from the exact
state leaves gaps d and rates e, which grow as h^5 and are found by making it: four evaluations of the joint equations,
with the pull of the closures at the stages, which lie off them. Signed, and followed through the equation from the
exact start, they are the error of the run, but for terms of second order in it. Time is the way s of the crank [rad].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from conrod.engines.cam_polygon import FollowerMotion, cam_polygon
from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import Machine
from conrod.engines.mujoco import LEAST_STEPS, MuJoCoSettings, exchanged_inertia, older
from conrod.engines.mujoco.model import Build, build
from conrod.engines.numerics import CRANK_SAMPLES, NO_BOUND_AT_CHANGE_POINT, rounding_bound
from conrod.engines.spanning_tree import SpanningTree
from conrod.exact.dynamics.inverse import steady_joint_forces
from conrod.exact.joint_equations import pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mesh

FINEST = 2.0 * math.pi / 1440.0  # [rad]; shorter steps are looked at together
OF_CONSTANT = 8.0  # local errors grow as h^5 for steps up to this part of the time constant
OPENING = (0.1, 8.0)  # time constants after the start: spacing and end of what is looked at, where the gaps open
SOME = 72  # poses at which it is looked how far a point moves for a gap
SAME = 1e-3  # of a step: samples that lie nearer are one
FORGOTTEN = 10.0  # time constants, in which a start is forgotten


@dataclass(frozen=True)
class Course:
    """Exact states of a run along the way of the crank, by it.

    Attributes:
        sense: of the way, +1 where the crank angle grows.
        angles: of the crank (T,) [rad], from the start.
        states: poses and their first and second derivatives by the way, (T, 3 n) each.
        steps: of the way to the next sample (T - 1,).
    """

    kinematics: Kinematics
    sense: float
    angles: Array
    states: tuple[Array, Array, Array]

    @property
    def steps(self) -> Array:
        return np.abs(np.diff(self.angles))

    @classmethod
    def from_machine(cls, machine: Machine, start_angle: float, step: float, constant: float) -> Course:
        """From an angle, or the begin of the driver's span, until it repeats itself."""
        kinematics, sense = machine.kinematics, math.copysign(1.0, machine.speed)
        spacing, way, span = max(step, FINEST), 2.0 * math.pi, kinematics.mechanism.driver.span
        if span is not None:
            start_angle, way = span[0] if sense > 0.0 else span[1], span[1] - span[0]
        elif kinematics.repeats:
            way *= math.ceil(1.0 + FORGOTTEN * constant / way)
        else:
            way *= 2.0
        even = spacing * np.arange(math.floor(way / spacing * (1.0 + 1e-12)) + 1)
        early = np.arange(0.0, min(OPENING[1] * constant, way), max(step, OPENING[0] * constant))
        ways = np.union1d(even, early) if spacing > step else even
        ways = ways[np.diff(ways, prepend=-step) > SAME * step]
        angles: Array = np.asarray(start_angle + sense * ways, dtype=float)
        poses, slopes, bends = kinematics.derivatives(angles, 2)
        return cls(kinematics, sense, angles, (poses, sense * slopes, bends))

    def opening(self, states: list[Array], ahead: float = 0.0) -> Array:
        """Gaps of all joints (T, 3 n), their rates or accelerations, of states a little ahead: the last one given."""
        crank = (self.angles + self.sense * ahead, np.full_like(self.angles, self.sense), np.zeros_like(self.angles))
        return self.kinematics.residual(states, crank[len(states) - 1])


def local_errors(tree: SpanningTree, course: Course, constant: float, step: float) -> tuple[Array, Array]:
    """Gaps and their rates that RK4 leaves in steps from exact states, over the step; (T, 3 n) each.

    Args:
        constant: time constant of the closures [rad].
        step: of the run [rad].
    """
    # A shorter step leaves what is lost in rounding; what a longer one leaves is h^5 as large.
    h = max(step, min(FINEST, constant / OF_CONSTANT))

    def acceleration(q: Array, rate: Array, ahead: float) -> Array:
        poses, speeds = tree.forward_kinematics(q, rate)
        pull = course.opening([poses, speeds, np.zeros_like(poses)], ahead)
        pull += 2.0 / constant * course.opening([poses, speeds], ahead)
        pull += course.opening([poses], ahead) / constant**2
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
    return over * course.opening([poses], h), over * course.opening([poses, speeds], h)


def yielding(machine: Machine, settings: MuJoCoSettings, made: Build, course: Course) -> Array:
    """Accelerations (T, 3 n) of the gaps, by the way, by the closures' giving way to the exact reactions."""
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


def followed(steps: Array, left: tuple[Array, Array], pushed: Array, constant: float) -> tuple[Array, Array, Array]:
    """Gaps, their rates and accelerations (T, n) of closures that start closed.

    Args:
        steps: between the samples (T - 1,).
        left: gaps and rates that are left for a unit of the way (T, n), of each sample's own step.
        pushed: accelerations of the gaps (T, n), straight between samples.
        constant: time constant c of the closures.
    """
    c = constant
    gaps, rates = np.zeros_like(pushed), np.zeros_like(pushed)
    for k, s in enumerate(steps):
        # Of g'' + 2/c g' + g/c^2 = p + r s a straight solution is c^2 (p + r s) - 2 c^3 r; the rest dies away.
        slope = (pushed[k + 1] - pushed[k]) / s
        gap = gaps[k] - c**2 * pushed[k] + 2.0 * c**3 * slope
        rate = rates[k] - c**2 * slope
        gone = math.exp(-s / c)
        gaps[k + 1] = gone * ((1.0 + s / c) * gap + s * rate) + c**2 * pushed[k + 1] - 2.0 * c**3 * slope
        rates[k + 1] = gone * ((1.0 - s / c) * rate - s / c**2 * gap) + c**2 * slope
        gaps[k + 1] += s * left[0][k]
        rates[k + 1] += s * left[1][k]
    return gaps, rates, pushed - 2.0 / c * rates - gaps / c**2


def predicted_gaps(
    machine: Machine, settings: MuJoCoSettings, made: Build, start_angle: float
) -> tuple[Course, Array, tuple[Array, Array, Array]]:
    """The exact states of a run, what pushes its gaps open (T, 3 n), and the gaps with two derivatives by the way."""
    constant, step = abs(machine.speed) * settings.solref[0], 2.0 * math.pi / settings.steps_per_revolution
    course = Course.from_machine(machine, start_angle, step, constant)
    left = local_errors(made.tree, course, constant, step)
    pushed = yielding(machine, settings, made, course)
    return course, pushed, followed(course.steps, left, pushed, constant)


def closure_errors(machine: Machine, settings: MuJoCoSettings, made: Build, start_angle: float) -> tuple[Array, Array]:
    """Largest errors (3,) of position, velocity and acceleration of observed points, over L, ω L, ω² L.

    And what rounding alone may make of them (3,). A step that always rounds to the same side leaves eps of the largest
    turn; folded with the answers of a gap and its derivatives to a unit of gap and of rate, that is no more than this.
    """
    course, pushed, gaps = predicted_gaps(machine, settings, made, start_angle)
    c = abs(machine.speed) * settings.solref[0]
    turn = max(float(np.abs(course.states[0][:, 2::3]).max()) / (4.0 * math.pi), 1.0)
    answers = np.array([2.0 * c + c**2, 1.0 + 2.0 / math.e * c, 2.0 / (math.e * c) + 1.0 + 2.0 / math.e**2])
    rounded = rounding_bound(machine.kinematics, 2 * settings.steps_per_revolution) * turn * np.maximum(answers, 1.0)
    return largest_point_errors(course, gaps), rounded * _largest_gain(course, np.flatnonzero(pushed.any(axis=0)))


def _largest_gain(course: Course, rows: Any) -> float:
    """Largest move of an observed point, over its L, for a gap of the largest travel in some rows; 1 at least."""
    kinematics, poses = course.kinematics, course.states[0][:: max(1, len(course.angles) // SOME)]
    largest = 1.0
    for row in rows:
        gap = np.zeros_like(poses)
        gap[:, row] = kinematics.travel
        for name, (_, move) in kinematics.point_derivatives([poses, kinematics.solve(poses, gap)]).items():
            largest = max(largest, float(np.linalg.norm(move, axis=1).max()) / kinematics.lengths[name])
    return largest


def moved_states(course: Course, gaps: tuple[Array, Array, Array]) -> list[Array]:
    """Poses and their derivatives by the way, (T, 3 n) each, with gaps left open and their derivatives."""
    moved: list[Array] = []
    for k, (exact, gap) in enumerate(zip(course.states, gaps, strict=True)):
        state = exact
        # The second step of the poses takes in what the gaps themselves change of the geometry; the others are linear.
        for _ in range(1 if k else 2):
            state = state - course.kinematics.solve(moved[0] if k else state, course.opening([*moved, state]) - gap)
        moved.append(state)
    return moved


def largest_point_errors(course: Course, gaps: tuple[Array, Array, Array]) -> Array:
    """Largest changes (3,) of observed points over L, and of their derivatives by the way, by gaps (T, 3 n)."""
    moved = moved_states(course, gaps)
    before, after = course.kinematics.point_derivatives(list(course.states)), course.kinematics.point_derivatives(moved)
    off = [
        [np.linalg.norm(moved - exact, axis=1).max() for moved, exact in zip(after[name], before[name], strict=True)]
        for name in before
    ]
    lengths = np.array([course.kinematics.lengths[name] for name in before])
    return np.asarray((np.array(off) / lengths[:, None]).max(axis=0))


# -- bounds ------------------------------------------------------------------------------------------------------------


# Of an error, what its prediction leaves out: RK4's own step of a closure, and terms of second order. Over 2 % was not
# found where errors are below 0.005.
LEFT_OUT, SECOND_ORDER = 0.05, 10.0
FALL_RMS = math.sqrt(1.1)  # 1 for the step itself, and 0.18^2, 0.2^2, .. for those that follow
CONTACT_LAW = "contact sinking, a fall in the first step, the polygon's corners, half a sagitta / cos(pressure angle)"
LAW = (
    "predicted: each closure's gap by its spring, by what RK4 leaves of it and by the exact reactions; "
    "5 % and ten times the error itself more"
)


def expected_error(machine: Machine, settings: MuJoCoSettings, start_angle: float = 0.0) -> ExpectedError:
    """Bounds for RK4 with a constant impedance, for links as bodies that have their weight and carry nothing else.

    The drive is a flywheel, whose rate varies by what the crank exchanges with the links over what it holds.
    """
    if not machine.kinematics.mechanism.cam_contacts and not older.closures_are_bounded():
        return ExpectedError(law=older.UNBOUNDED)
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
    bodies = pose_jets(kinematics.mechanism, kinematics.derivatives(kinematics.angles(CRANK_SAMPLES), 1))
    felt = np.zeros(CRANK_SAMPLES)
    for body in kinematics.mechanism.bodies:
        x, y = (jet.coefficients[1] for jet in bodies[body.name].point(body.centre_of_gravity))
        felt += body.mass * (x**2 + y**2) + body.inertia * bodies[body.name].phi.coefficients[1] ** 2
    return float(np.ptp(felt))


def has_law(settings: MuJoCoSettings) -> bool:
    """True for settings whose closures are followed: RK4, one constant impedance, critical damping."""
    if settings.dressing or not settings.gravity or settings.integrator != "RK4":
        return False
    # A time constant that is shorter MuJoCo raises, or RK4 cannot follow.
    if settings.solref[0] < LEAST_STEPS * settings.timestep:
        return False
    return settings.solimp[0] == settings.solimp[1] and settings.solref[1] == 1.0


def _bounds(machine: Machine, settings: MuJoCoSettings, start_angle: float) -> ExpectedError:
    none = ExpectedError()
    if machine.kinematics.mechanism.cam_contacts:
        return none if settings.dressing else _contact_error(machine, settings)
    if machine.kinematics.change_angles.size:
        return replace(none, law=NO_BOUND_AT_CHANGE_POINT)
    if not has_law(settings):
        return none
    errors, rounded = closure_errors(machine, settings, build(machine, settings), start_angle)
    position, velocity, acceleration = (errors * (1.0 + LEFT_OUT + SECOND_ORDER * errors[0]) + rounded).tolist()
    return ExpectedError(position, velocity, acceleration, law=LAW)


def _contact_error(machine: Machine, settings: MuJoCoSettings) -> ExpectedError:
    """Bounds for a contact of constant impedance, time constant in steps, under Euler."""
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
    # The fall's speed, in one step of a turn; what the contact makes of it is a fifth of that.
    fallen = FALL_RMS * fall / h / abs(machine.speed) / math.sqrt(settings.steps_per_revolution)
    slope = math.hypot(follower.facet_slope_rms(polygon), settling, fallen) + stale
    return ExpectedError(
        (max(sinking, fall) + corner + shape) / follower.lift, velocity_rms=slope / follower.lift, law=CONTACT_LAW
    )


def shape_error(machine: Machine, settings: MuJoCoSettings) -> float:
    """Largest error of the lift [m] that the collision mesh has, held still: facets, and single precision."""
    follower = FollowerMotion.from_machine(machine)
    polygon = cam_polygon(follower.contact.profile, settings.cam_vertices)
    single = float(np.finfo(np.float32).eps) * float(np.abs(polygon.vertices).max())
    return (polygon.error + single) / float(follower.cosine.min())
