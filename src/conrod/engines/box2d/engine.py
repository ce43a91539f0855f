"""Box2D, as one of conrod's engines: a mechanism becomes a `b2World`, it steps, conrod records.

Nothing is written into the engine after the start but the crank's own angle."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from conrod.engines.box2d import BOX2D_PRESETS, Box2DSettings
from conrod.engines.cam_polygon import CamPolygon, cam_polygon, contact_refusal
from conrod.engines.capabilities import TIMED_REFERENCE
from conrod.engines.engine import PIECE_STEPS, Engine, Machine, run_extent
from conrod.engines.numerics import centre_state, frames_from_centres
from conrod.engines.run import RecordedStretch, record_pieces, stamped_states
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, LowerPair, Mechanism, Point, Prismatic, Revolute
from conrod.runs.trajectory import BodyTracks, Piece, PointTracks, Track

with warnings.catch_warnings():
    # Types made by SWIG warn that they have no module; where warnings are errors, that ends the interpreter.
    warnings.simplefilter("ignore", DeprecationWarning)
    import Box2D

LIBRARY_VERSION: str = Box2D.__version__
ROUNDING = 0.9  # of a cam's least radius, that is taken off it and put onto the roller
FEWEST = 16  # facets
# In its units: points of a chain that are nearer are one for it; and what it adds around all edges.
SLOP, SKIN = 1.01 * Box2D.b2_linearSlop, 1.01 * Box2D.b2_polygonRadius


@dataclass(frozen=True)
class Build:
    """A world and its bodies, in the order of `mechanism.bodies`; their origins are their centres of gravity.

    Attributes:
        mechanism: with the crank's centre of gravity on its shaft, about which a kinematic body turns; it has no mass.
    """

    mechanism: Mechanism
    world: Any
    bodies: tuple[Any, ...]
    scale: float

    @property
    def crank(self) -> Any:
        """The driven body."""
        return self.bodies[self.mechanism.body_index[self.mechanism.crank]]


def refusal(machine: Machine, settings: Box2DSettings) -> str | None:
    """None, or the reason why these settings cannot be used on this machine."""
    mechanism = machine.kinematics.mechanism
    if mechanism.loads:
        return "box2d is given gravity and constant forces, no loads that follow a law"
    if mechanism.meshes:
        return "box2d is given pins, slides and cams, and no wheels that roll"
    reason = contact_refusal(mechanism)
    if reason or all(_outline(contact, settings) for contact in mechanism.cam_contacts):
        return reason
    return (
        f"box2d: a cam's facets have to be {SLOP:.2g} of its units long, of which a metre is {settings.length_scale:g}"
    )


def build(mechanism: Mechanism, settings: Box2DSettings, poses: Array, rates: Array) -> Build:
    """Translate, with the bodies in poses (3 n,) at rates (3 n,); the crank is a kinematic body."""
    shaft, scale = mechanism.driven_joint.point_b, settings.length_scale
    bodies = [replace(b, centre_of_gravity=shaft) if b.name == mechanism.crank else b for b in mechanism.bodies]
    mechanism = replace(mechanism, bodies=tuple(bodies))
    gravity = tuple(scale * part for part in mechanism.gravity)
    world = Box2D.b2World(gravity=gravity, continuousPhysics=settings.continuous_physics)
    world.SetAllowSleeping(settings.sleeping)  # its keyword doSleep has no effect
    world.autoClearForces = False  # constant ones are given once
    states = zip(poses.reshape(-1, 3), rates.reshape(-1, 3), strict=True)
    made = Build(mechanism, world, tuple(_body(world, mechanism, k, scale, *s) for k, s in enumerate(states)), scale)
    by_name = {GROUND: world.CreateStaticBody(), **dict(zip(mechanism.body_index, made.bodies, strict=True))}
    for joint in mechanism.joints:
        if joint.name != mechanism.driver.joint:
            _add_joint(made, by_name, joint, settings)
    if settings.all_iterations:
        _add_unclosable(made, by_name[GROUND])
    return made


def _body(world: Any, mechanism: Mechanism, index: int, scale: float, pose: Array, rate: Array) -> Any:
    link = mechanism.bodies[index]
    x, y, turn, vx, vy, spin = centre_state(link, pose, rate)
    placed = {"position": (scale * x, scale * y), "angle": turn, "angularVelocity": spin}
    if link.name == mechanism.crank:
        return world.CreateKinematicBody(**placed)
    body = world.CreateDynamicBody(linearVelocity=(scale * vx, scale * vy), **placed)
    body.massData = Box2D.b2MassData(mass=link.mass, center=(0.0, 0.0), I=scale**2 * link.inertia)
    push = mechanism.push_on(link.name)
    body.ApplyForceToCenter((scale * push[0], scale * push[1]), True)
    return body


def _add_joint(made: Build, bodies: Mapping[str, Any], joint: Joint, settings: Box2DSettings) -> None:
    if isinstance(joint, CamContact):
        _add_shapes(made, bodies, joint, settings)
        return
    assert isinstance(joint, LowerPair)  # or the machine is refused
    ends = {
        "bodyA": bodies[joint.a],
        "bodyB": bodies[joint.b],
        "localAnchorA": _local(made, joint.a, joint.point_a),
        "localAnchorB": _local(made, joint.b, joint.point_b),
    }
    if isinstance(joint, Revolute):
        made.world.CreateRevoluteJoint(**ends)
        return
    axis = (math.cos(joint.direction), math.sin(joint.direction))
    made.world.CreatePrismaticJoint(**ends, localAxisA=axis, referenceAngle=joint.angle)


def _add_shapes(made: Build, bodies: Mapping[str, Any], joint: CamContact, settings: Box2DSettings) -> None:
    """Cam and roller, the only shapes; smooth and without restitution. A polygon may have 16 corners, a chain any."""
    outline = _outline(joint, settings)
    assert outline is not None  # or the machine is refused
    rim = Box2D.b2LoopShape(vertices=[_local(made, joint.a, (float(x), float(y))) for x, y in outline.vertices])
    radius = made.scale * (joint.roller_radius + outline.radius) - Box2D.b2_polygonRadius
    roller = Box2D.b2CircleShape(radius=radius, pos=_local(made, joint.b, joint.roller_centre))
    for name, shape in ((joint.a, rim), (joint.b, roller)):
        bodies[name].CreateFixture(shape=shape, friction=0.0, restitution=0.0, density=0.0)


def _outline(joint: CamContact, settings: Box2DSettings) -> CamPolygon | None:
    """The cam inset by nine tenths of its least radius: the roller is larger by as much, and its nose nearly exact.

    Half as many facets are taken, and half again, until they are long enough for Box2D; None where they never are.
    """
    count, scale = settings.cam_vertices, settings.length_scale
    while count >= FEWEST:
        outline = cam_polygon(joint.profile, count, ROUNDING * joint.profile.least_radius)
        shortest = np.linalg.norm(outline.vertices - np.roll(outline.vertices, 1, axis=0), axis=1).min()
        if scale * shortest > SLOP and scale * (joint.roller_radius + outline.radius) > SKIN:
            return outline
        count //= 2
    return None


def _local(made: Build, name: str, point: Point) -> Point:
    """A point of a link from its centre of gravity, in Box2D's units."""
    x, y = (0.0, 0.0) if name == GROUND else made.mechanism.body(name).centre_of_gravity
    return (made.scale * (point[0] - x), made.scale * (point[1] - y))


def _add_unclosable(made: Build, ground: Any) -> None:
    """A body of its own that is pinned to two places at once, and so keeps the positions' iteration going.

    b2Island::Solve ends it where no joint of the island is farther open than b2_linearSlop. A rope that is never taut
    makes the body one of the crank's island, and acts on nothing.
    """
    stray = made.world.CreateDynamicBody(gravityScale=0.0)
    stray.massData = Box2D.b2MassData(mass=1.0, center=(0.0, 0.0), I=1.0)
    for x in (-1.0, 1.0):
        made.world.CreateRevoluteJoint(bodyA=ground, bodyB=stray, localAnchorA=(x, 0.0), localAnchorB=(0.0, 0.0))
    still = {"localAnchorA": (0.0, 0.0), "localAnchorB": (0.0, 0.0)}
    made.world.CreateRopeJoint(bodyA=stray, bodyB=made.crank, maxLength=1e30, **still)


# -- runs --------------------------------------------------------------------------------------------------------------


TURN = 2.0 * math.pi
KEPT = 2  # samples before a stretch of a run, from which its velocities and accelerations follow


class Stepper:
    """A machine in the exact state of its start, or a crank angle [rad]; calling it advances it by so many steps.

    The engine sums speed x step, in single precision; counted steps keep the crank where it belongs. Its angle is
    written without whole turns, which would take digits from it, unless a slide holds another link's turn to it.
    """

    def __init__(self, machine: Machine, settings: Box2DSettings, angle: float | None = None) -> None:
        angle = run_extent(machine, 1, 1.0)[0] if angle is None else angle
        poses, slopes = machine.kinematics.derivatives(np.array([angle]), 1)
        self.made = build(machine.kinematics.mechanism, settings, poses[0], slopes[0] * machine.speed)
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
            self._whole = TURN * round(turn / TURN) if self._counted else 0.0
            crank.angle = turn - self._whole
            self._steps += 1
            step(length, *iterations)

    def states(self) -> Iterator[Array]:
        """Centres of gravity with turns [m, rad], and their rates (2, 3 n), as they are now and after every step.

        They are not numbers where the engine did not get to.
        """
        try:
            while True:
                yield self._state()
                self(1)
        except AssertionError:  # which Box2D's own checks are raised as
            while True:
                yield np.full((2, 3 * len(self.made.bodies)), math.nan)

    def _state(self) -> Array:
        scale, states = self.made.scale, list[tuple[float, ...]]()
        for body in self.made.bodies:
            place, rate = body.worldCenter, body.linearVelocity
            states.append(
                (place[0] / scale, place[1] / scale, body.angle, rate[0] / scale, rate[1] / scale, body.angularVelocity)
            )
        found = np.array(states)
        found[self._crank, 2] += self._whole
        return np.array([found[:, :3].ravel(), found[:, 3:].ravel()])


def tracks(
    machine: Machine, mechanism: Mechanism, h: float, times: Array, centres: Array, rates: Array
) -> RecordedStretch:
    """States of the bodies and motion of the observed points, each at the instants that it belongs to.

    A step makes the velocities fit the joints where the bodies are, and then moves these: v_n fits x_(n-1), and belongs
    to t_(n-1), a whole step before it is read. What then closes the joints again (the positions' iteration) moves the
    bodies alone. Acceleration is the difference of two velocities and belongs to the middle between their instants.

    Args:
        mechanism: whose bodies' centres of gravity these are.
        times: (T,) [s], of the samples.
        centres, rates: as read at the samples (T, 3 n).
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
    return RecordedStretch(bodies, points)


def run(
    machine: Machine, settings: Box2DSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE_STEPS
) -> Iterator[Piece]:
    """A run at constant crank speed in pieces of so many steps."""
    stepper, known = Stepper(machine, settings, start_angle), list[Array]()
    states = stepper.states()

    def record(_: int, times: Array) -> RecordedStretch:
        known[:] = known[-KEPT:]
        known.extend(islice(states, len(times) - len(known)))
        read = np.array(known).swapaxes(0, 1)
        return tracks(machine, stepper.made.mechanism, settings.timestep, times, *read)

    return record_pieces(machine, settings, LIBRARY_VERSION, revolutions, start_angle, steps, record, KEPT)


class Box2DEngine(Engine[Box2DSettings]):
    """Box2D by way of its `b2World`, in single precision: impulses for velocities, then an iteration of positions."""

    name = "box2d"
    version = LIBRARY_VERSION
    presets = BOX2D_PRESETS
    refusal = staticmethod(refusal)
    run = staticmethod(run)
    stepper = Stepper

    def reference_loop(self) -> Stepper:
        """The slider-crank at its start, 1000 steps a turn."""
        return Stepper(TIMED_REFERENCE, Box2DSettings.stock(TIMED_REFERENCE, 1000))


BOX2D_ENGINE = Box2DEngine()
