"""The Box2D engine: translates a mechanism to a `b2World`, steps it and records.

After the start, only the crank's own angle is written into the engine.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from conrod.comparison.trajectory import BodyTracks, Piece, PointTracks, Track
from conrod.engines.box2d import BOX2D_PRESETS, Box2DSettings
from conrod.engines.cam_polygon import CamPolygon, cam_polygon, contact_refusal
from conrod.engines.capabilities import TIMED_REFERENCE
from conrod.engines.engine import PIECE_STEPS, Engine, Machine, run_extent
from conrod.engines.numerics import centre_state, frames_from_centres
from conrod.engines.run import RecordedPiece, record_pieces, stamped_states
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, LowerPair, Mechanism, Point, Prismatic, Revolute

with warnings.catch_warnings():
    # Types made by SWIG warn that they have no module; where warnings are errors, that ends the interpreter.
    warnings.simplefilter("ignore", DeprecationWarning)
    import Box2D

LIBRARY_VERSION: str = Box2D.__version__
ROUNDED_SHARE = 0.9  # of a cam's least radius, by which the cam is inset and the roller enlarged
MIN_CAM_FACETS = 16
# In Box2D units: closer points of a chain are merged; and the skin that Box2D adds around all shapes.
MIN_FACET_LENGTH, MIN_ROLLER_RADIUS = 1.01 * Box2D.b2_linearSlop, 1.01 * Box2D.b2_polygonRadius


@dataclass(frozen=True)
class Box2DWorld:
    """A world with the bodies of a mechanism in their order; their origins are the centres of gravity.

    Attributes:
        mechanism: the mechanism with the crank's centre of gravity on its shaft, about which a kinematic body rotates.
        scale: Box2D units per metre.
    """

    mechanism: Mechanism
    world: Any
    bodies: tuple[Any, ...]
    scale: float

    @property
    def crank(self) -> Any:
        """The crank's body."""
        return self.bodies[self.mechanism.body_index[self.mechanism.crank]]


def refusal(machine: Machine, settings: Box2DSettings) -> str | None:
    """Return the reason why these settings cannot be used on this machine, or None."""
    mechanism = machine.kinematics.mechanism
    if mechanism.loads:
        return "box2d is given gravity and constant forces, no loads that follow a law"
    if mechanism.meshes:
        return "box2d is given pins, slides and cams, and no wheels that roll"
    reason = contact_refusal(mechanism)
    if reason or all(_cam_outline(contact, settings) for contact in mechanism.cam_contacts):
        return reason
    return (
        f"box2d: a cam's facets have to be {MIN_FACET_LENGTH:.2g} of its units long, of which a metre is "
        f"{settings.length_scale:g}"
    )


def build(mechanism: Mechanism, settings: Box2DSettings, poses: Array, rates: Array) -> Box2DWorld:
    """Build the world with the bodies in poses (3 n,) at rates (3 n,); the crank is a kinematic body."""
    shaft, scale = mechanism.driven_joint.point_b, settings.length_scale
    bodies = [replace(b, centre_of_gravity=shaft) if b.name == mechanism.crank else b for b in mechanism.bodies]
    mechanism = replace(mechanism, bodies=tuple(bodies))
    gravity = tuple(scale * part for part in mechanism.gravity)
    world = Box2D.b2World(gravity=gravity, continuousPhysics=settings.continuous_physics)
    world.SetAllowSleeping(settings.sleeping)  # its keyword doSleep has no effect
    world.autoClearForces = False  # constant forces are applied once
    states = zip(poses.reshape(-1, 3), rates.reshape(-1, 3), strict=True)
    made = Box2DWorld(
        mechanism, world, tuple(_create_body(world, mechanism, k, scale, *s) for k, s in enumerate(states)), scale
    )
    by_name = {GROUND: world.CreateStaticBody(), **dict(zip(mechanism.body_index, made.bodies, strict=True))}
    for joint in mechanism.joints:
        if joint.name != mechanism.driver.joint:
            _add_joint(made, by_name, joint, settings)
    if settings.all_iterations:
        _add_unclosable_joints(made, by_name[GROUND])
    return made


def _create_body(world: Any, mechanism: Mechanism, index: int, scale: float, pose: Array, rate: Array) -> Any:
    """Create the body of a link in a pose (3,) at rates (3,)."""
    link = mechanism.bodies[index]
    x, y, turn, vx, vy, spin = centre_state(link, pose, rate)
    placed = {"position": (scale * x, scale * y), "angle": turn, "angularVelocity": spin}
    if link.name == mechanism.crank:
        return world.CreateKinematicBody(**placed)
    body = world.CreateDynamicBody(linearVelocity=(scale * vx, scale * vy), **placed)
    body.massData = Box2D.b2MassData(mass=link.mass, center=(0.0, 0.0), I=scale**2 * link.inertia)
    push = mechanism.constant_force_on(link.name)
    body.ApplyForceToCenter((scale * push[0], scale * push[1]), True)
    return body


def _add_joint(made: Box2DWorld, bodies: Mapping[str, Any], joint: Joint, settings: Box2DSettings) -> None:
    """Add a joint, or the contact shapes of a cam."""
    if isinstance(joint, CamContact):
        _add_shapes(made, bodies, joint, settings)
        return
    assert isinstance(joint, LowerPair)  # or the machine is refused
    ends = {
        "bodyA": bodies[joint.a],
        "bodyB": bodies[joint.b],
        "localAnchorA": _to_body_frame(made, joint.a, joint.point_a),
        "localAnchorB": _to_body_frame(made, joint.b, joint.point_b),
    }
    if isinstance(joint, Revolute):
        made.world.CreateRevoluteJoint(**ends)
        return
    axis = (math.cos(joint.direction), math.sin(joint.direction))
    made.world.CreatePrismaticJoint(**ends, localAxisA=axis, referenceAngle=joint.angle)


def _add_shapes(made: Box2DWorld, bodies: Mapping[str, Any], joint: CamContact, settings: Box2DSettings) -> None:
    """Add the shapes of cam and roller, the only shapes: without friction and restitution.

    The cam is a chain, as a polygon has at most 16 corners.
    """
    outline = _cam_outline(joint, settings)
    assert outline is not None  # or the machine is refused
    rim = Box2D.b2LoopShape(vertices=[_to_body_frame(made, joint.a, (float(x), float(y))) for x, y in outline.vertices])
    radius = made.scale * (joint.roller_radius + outline.radius) - Box2D.b2_polygonRadius
    roller = Box2D.b2CircleShape(radius=radius, pos=_to_body_frame(made, joint.b, joint.roller_centre))
    for name, shape in ((joint.a, rim), (joint.b, roller)):
        bodies[name].CreateFixture(shape=shape, friction=0.0, restitution=0.0, density=0.0)


def _cam_outline(joint: CamContact, settings: Box2DSettings) -> CamPolygon | None:
    """The cam's polygon, inset by nine tenths of its least radius, with facets long enough for Box2D; else None.

    The roller is larger by the inset, which makes the cam's nose nearly exact. The number of facets is halved until
    they are long enough.
    """
    count, scale = settings.cam_vertices, settings.length_scale
    while count >= MIN_CAM_FACETS:
        outline = cam_polygon(joint.profile, count, ROUNDED_SHARE * joint.profile.least_radius)
        shortest = np.linalg.norm(outline.vertices - np.roll(outline.vertices, 1, axis=0), axis=1).min()
        if scale * shortest > MIN_FACET_LENGTH and scale * (joint.roller_radius + outline.radius) > MIN_ROLLER_RADIUS:
            return outline
        count //= 2
    return None


def _to_body_frame(made: Box2DWorld, name: str, point: Point) -> Point:
    """A point of a link from its centre of gravity, in Box2D's length unit."""
    x, y = (0.0, 0.0) if name == GROUND else made.mechanism.body(name).centre_of_gravity
    return (made.scale * (point[0] - x), made.scale * (point[1] - y))


def _add_unclosable_joints(made: Box2DWorld, ground: Any) -> None:
    """Add a stray body pinned to two places at once, so that no position iterations are left out.

    b2Island::Solve ends them when no joint of the island is open by more than b2_linearSlop. A rope that is never taut
    puts the body into the crank's island, and acts on nothing.
    """
    stray = made.world.CreateDynamicBody(gravityScale=0.0)
    stray.massData = Box2D.b2MassData(mass=1.0, center=(0.0, 0.0), I=1.0)
    for x in (-1.0, 1.0):
        made.world.CreateRevoluteJoint(bodyA=ground, bodyB=stray, localAnchorA=(x, 0.0), localAnchorB=(0.0, 0.0))
    still = {"localAnchorA": (0.0, 0.0), "localAnchorB": (0.0, 0.0)}
    made.world.CreateRopeJoint(bodyA=stray, bodyB=made.crank, maxLength=1e30, **still)


# -- runs --------------------------------------------------------------------------------------------------------------


REVOLUTION = 2.0 * math.pi
PRECEDING_SAMPLES = 2  # before a piece of a run, from which its first velocities and accelerations follow


class Box2DStepper:
    """Stepper of a machine, from the exact state at its start or at a crank angle [rad]; a call advances it by steps.

    The engine sums speed x step in single precision, so the crank's angle is written from the step index, without whole
    revolutions, which would take digits from it, unless a slide ties another link's angle to it.
    """

    def __init__(self, machine: Machine, settings: Box2DSettings, angle: float | None = None) -> None:
        angle = run_extent(machine, 1, 1.0)[0] if angle is None else angle
        poses, derivative = machine.kinematics.derivatives(np.array([angle]), 1)
        self.made = build(machine.kinematics.mechanism, settings, poses[0], derivative[0] * machine.speed)
        mechanism = self.made.mechanism
        self._start, self._spin = mechanism.crank_turn(angle), mechanism.driver.sense * machine.speed
        self._settings, self._steps, self._whole = settings, 0, 0.0
        self._counted = not any(isinstance(joint, Prismatic) for joint in mechanism.joints_on(mechanism.crank))
        self._crank = mechanism.body_index[mechanism.crank]

    def __call__(self, steps: int) -> None:
        crank, step, settings = self.made.crank, self.made.world.Step, self._settings
        length, iterations = settings.timestep, (settings.velocity_iterations, settings.position_iterations)
        for _ in range(steps):
            turn = self._start + self._spin * length * self._steps
            self._whole = REVOLUTION * round(turn / REVOLUTION) if self._counted else 0.0
            crank.angle = turn - self._whole
            self._steps += 1
            step(length, *iterations)

    def states(self) -> Iterator[Array]:
        """Yield positions with angles and their rates (2, 3 n) of the centres of gravity, now and after every step.

        They are NaN after the engine has failed.
        """
        try:
            while True:
                yield self._read_state()
                self(1)
        except AssertionError:  # from Box2D's own checks
            while True:
                yield np.full((2, 3 * len(self.made.bodies)), math.nan)

    def _read_state(self) -> Array:
        """Present positions with angles and their rates (2, 3 n) of the centres of gravity, in SI."""
        scale, states = self.made.scale, list[tuple[float, ...]]()
        for body in self.made.bodies:
            place, rate = body.worldCenter, body.linearVelocity
            states.append(
                (place[0] / scale, place[1] / scale, body.angle, rate[0] / scale, rate[1] / scale, body.angularVelocity)
            )
        found = np.array(states)
        found[self._crank, 2] += self._whole
        return np.array([found[:, :3].ravel(), found[:, 3:].ravel()])


def stamped_tracks(
    machine: Machine, mechanism: Mechanism, h: float, times: Array, centres: Array, rates: Array
) -> RecordedPiece:
    """Motion of bodies and observed points, each at the instant it belongs to.

    A step makes the velocities fit the joints at the present positions, and then moves the bodies: v_n fits x_(n-1),
    and belongs to t_(n-1), a whole step before it is read. The position iterations that then close the joints change
    positions alone. Acceleration is the difference of two velocities and belongs to the middle between their instants.

    Args:
        mechanism: the mechanism as the world has it.
        h: step [s].
        times: times of the samples (T,) [s].
        centres, rates: positions with angles and their rates of the centres of gravity as read (T, 3 n).
    """
    poses, speeds = frames_from_centres(mechanism, centres[:-1], rates[1:])  # at one instant each
    bends = np.diff(speeds, axis=0) / h
    middle = 0.5 * (times[:-2] + times[1:-1]), 0.5 * (poses[:-1] + poses[1:]), 0.5 * (speeds[:-1] + speeds[1:])
    here = frames_from_centres(mechanism, centres, rates)
    bodies = BodyTracks(
        stamped_states(mechanism, times, *here, np.zeros_like(here[0])),
        stamped_states(mechanism, times[:-1], poses, speeds, np.zeros_like(poses)),
        stamped_states(mechanism, *middle, bends),
    )
    places = machine.kinematics.point_derivatives([here[0]])
    velocities = machine.kinematics.point_derivatives([poses, speeds])
    points = {
        name: PointTracks(
            Track(bodies.position.instants, place),
            Track(bodies.velocity.instants, velocities[name][1]),
            Track(bodies.acceleration.instants, np.diff(velocities[name][1], axis=0) / h),
        )
        for name, (place,) in places.items()
    }
    return RecordedPiece(bodies, points)


def run(
    machine: Machine, settings: Box2DSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE_STEPS
) -> Iterator[Piece]:
    """Run a machine at constant crank speed, and yield its pieces of `steps` steps."""
    stepper, known = Box2DStepper(machine, settings, start_angle), list[Array]()
    states = stepper.states()

    def record(_: int, times: Array) -> RecordedPiece:
        """Read the samples at times (T,) [s]; the first of these times may have samples already."""
        known[:] = known[-PRECEDING_SAMPLES:]
        known.extend(islice(states, len(times) - len(known)))
        read = np.array(known).swapaxes(0, 1)
        return stamped_tracks(machine, stepper.made.mechanism, settings.timestep, times, *read)

    return record_pieces(machine, settings, LIBRARY_VERSION, revolutions, start_angle, steps, record, PRECEDING_SAMPLES)


class Box2DEngine(Engine[Box2DSettings]):
    """Box2D through its `b2World`, in single precision: impulses for velocities, then position iterations."""

    name = "box2d"
    version = LIBRARY_VERSION
    presets = BOX2D_PRESETS
    refusal = staticmethod(refusal)
    run = staticmethod(run)
    stepper = Box2DStepper

    def reference_loop(self) -> Box2DStepper:
        """Stepper of the fixed slider-crank, the unit of timings, at 1000 steps per revolution."""
        return Box2DStepper(TIMED_REFERENCE, Box2DSettings.stock(TIMED_REFERENCE, 1000))


BOX2D_ENGINE = Box2DEngine()
