"""Mechanism -> Box2D `b2World`."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from conrod.engines.box2d.settings import Box2DSettings
from conrod.engines.cam_polygon import CamPolygon, cam_polygon, contact_refusal
from conrod.engines.centres import centre_state
from conrod.engines.engine import Machine
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, LowerPair, Mechanism, Point, Revolute

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
