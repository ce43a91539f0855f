"""Mechanism -> pymunk `Space`, with its bodies and joints."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from importlib.metadata import version
from itertools import pairwise
from typing import assert_never

import numpy as np
import pymunk

from conrod.engines.cam_polygon import CamPolygon, cam_polygon, contact_refusal
from conrod.engines.engine import Machine
from conrod.engines.numerics import centre_state
from conrod.engines.pymunk import PymunkSettings
from conrod.engines.pymunk.gears import gears_refusal, ties
from conrod.exact.motion import Array
from conrod.mechanism.cam_law import Profile
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, Mechanism, Point, Prismatic, Rack, Revolute, Rolling

VERSION = version("pymunk")  # what 7.0.0 says of itself is 2.0.0
Pushed = tuple[tuple[pymunk.Body, tuple[float, float]], ...]  # bodies with the constant force [N] on each


@dataclass(frozen=True)
class Build:
    """A space and its bodies, in the order of the mechanism's."""

    mechanism: Mechanism  # as the engine has it, see `shaft_centred`
    space: pymunk.Space
    bodies: tuple[pymunk.Body, ...]
    # Constant forces have to be given again before every step, which clears them.
    pushed: Pushed
    names: dict[pymunk.Constraint, str]  # the joint that each constraint is of
    driven: bool  # whether the crank is a kinematic body, whose turn is written

    @property
    def crank(self) -> pymunk.Body:
        """The driven body."""
        return self.bodies[self.mechanism.body_index[self.mechanism.crank]]

    def place(self, poses: Array, rates: Array) -> None:
        """Put the bodies into poses (3 n,) with rates (3 n,) of all links."""
        for i, (link, body) in enumerate(zip(self.mechanism.bodies, self.bodies, strict=True)):
            own = slice(3 * i, 3 * i + 3)
            gx, gy, turn, vx, vy, spin = centre_state(link, poses[own], rates[own])
            body.position, body.angle = (gx, gy), turn
            body.velocity, body.angular_velocity = (vx, vy), spin
        self.space.reindex_shapes_for_body(self.space.static_body)

    def hold(self, name: str, constraint: pymunk.Constraint) -> None:
        """Add a constraint, of a joint of this name."""
        self.names[constraint] = name
        self.space.add(constraint)

    def link(self, name: str) -> pymunk.Body:
        """The body of a link, or the ground."""
        return self.space.static_body if name == GROUND else self.bodies[self.mechanism.body_index[name]]

    def local(self, name: str, point: Point) -> Point:
        """A point of a link in pymunk's body frame, whose origin is the centre of gravity."""
        if name == GROUND:
            return point
        cx, cy = self.mechanism.body(name).centre_of_gravity
        return (point[0] - cx, point[1] - cy)


def shaft_centred(mechanism: Mechanism) -> Mechanism:
    """The mechanism with the crank's centre of gravity on its shaft.

    A kinematic body turns about its centre of gravity, and its mass acts on nothing: so where its real one lies does
    not matter, but the place about which it turns does.
    """
    shaft = mechanism.driven_joint.point_b
    bodies = tuple(
        replace(body, centre_of_gravity=shaft) if body.name == mechanism.crank else body for body in mechanism.bodies
    )
    return replace(mechanism, bodies=bodies)


# -- translation -------------------------------------------------------------------------------------------------------


ROUNDING = 0.9
WEDGE_FACETS = 240


def refusal(machine: Machine, settings: PymunkSettings) -> str | None:
    """None, or the reason why these settings cannot be used on this machine."""
    mechanism = machine.kinematics.mechanism
    return contact_refusal(mechanism) or gears_refusal(mechanism)


def build(machine: Machine, settings: PymunkSettings) -> Build:
    """Translate, with the bodies in the exact pose of crank angle 0.

    A link on a slide from the ground cannot turn, so it gets an infinite moment and a groove at its centre of
    gravity. A driven crank is a kinematic body: its speed has no ripple.
    """
    kinematics = machine.kinematics
    return _built(shaft_centred(kinematics.mechanism), settings, kinematics.start[0], driven=True)


def build_free(mechanism: Mechanism, settings: PymunkSettings, poses: Array) -> Build:
    """Translate, with the bodies in the given poses (3 n,) and a crank that is a body like every other one."""
    return _built(mechanism, settings, poses, driven=False)


def _built(mechanism: Mechanism, settings: PymunkSettings, start: Array, driven: bool) -> Build:
    space = pymunk.Space()
    space.iterations = settings.iterations
    space.gravity = mechanism.gravity if settings.gravity else (0.0, 0.0)
    space.collision_slop, space.collision_bias = settings.collision_slop, settings.collision_bias
    bodies = tuple(_body(mechanism, link.name, driven) for link in mechanism.bodies)
    space.add(*bodies)
    pushed = tuple((bodies[mechanism.body_index[name]], push) for name, push in mechanism.pushes.items())
    made = Build(mechanism, space, bodies, pushed, {}, driven)
    made.place(start, np.zeros_like(start))
    for joint in mechanism.joints:
        if not driven or joint.name != mechanism.driver.joint:
            _add_joint(made, joint, settings)
    # Phases are those of the start.
    for name, tie in ties(mechanism).items():
        (first, weight_first), (second, weight_second) = tie.items()
        ratio = -weight_second / weight_first
        turns = [float(start[3 * mechanism.body_index[body] + 2]) for body in (first, second)]
        gear = pymunk.GearJoint(made.link(first), made.link(second), ratio * turns[1] - turns[0], ratio)
        _add(made, name, gear, settings)
    return made


def _body(mechanism: Mechanism, name: str, driven: bool) -> pymunk.Body:
    if driven and name == mechanism.crank:
        return pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    link = mechanism.body(name)
    return pymunk.Body(link.mass, math.inf if isinstance(mechanism.guide(name), Prismatic) else link.inertia)


def _add_joint(made: Build, joint: Joint, settings: PymunkSettings) -> None:
    match joint:
        case Revolute():
            pins = [made.local(b, p) for b, p in ((joint.a, joint.point_a), (joint.b, joint.point_b))]
            constraints: list[pymunk.Constraint] = [
                pymunk.PivotJoint(made.link(joint.a), made.link(joint.b), pins[0], pins[1])
            ]
        case Prismatic():
            constraints = _slide(made, joint)
        case CamContact():
            _add_shapes(made, joint, settings)
            constraints = []
        case Rolling() | Rack():  # all together, by the turns that they tie
            constraints = []
        case _:
            assert_never(joint)
    for constraint in constraints:
        _add(made, joint.name, constraint, settings)


def _add(made: Build, name: str, constraint: pymunk.Constraint, settings: PymunkSettings) -> None:
    constraint.error_bias = settings.error_bias
    constraint.collide_bodies = False
    made.hold(name, constraint)


def _slide(made: Build, joint: Prismatic) -> list[pymunk.Constraint]:
    a, b = made.link(joint.a), made.link(joint.b)
    reach = 100.0 * _size(made.mechanism)
    anchor, point = made.local(joint.a, joint.point_a), made.local(joint.b, joint.point_b)
    grounded = GROUND in (joint.a, joint.b)
    if not grounded:
        anchor, point = _through_centres(joint, anchor, point)
    along = (reach * math.cos(joint.direction), reach * math.sin(joint.direction))
    ends = [(anchor[0] + k * along[0], anchor[1] + k * along[1]) for k in (-1.0, 1.0)]
    constraints: list[pymunk.Constraint] = [pymunk.GrooveJoint(a, b, ends[0], ends[1], point)]
    if not grounded:  # a body on a slide of the ground has no moment to turn by
        constraints.append(pymunk.GearJoint(a, b, joint.angle, 1.0))
    return constraints


def _through_centres(joint: Prismatic, anchor: Point, point: Point) -> tuple[Point, Point]:
    """The same slide by a line through the guide's centre of gravity and a point straight across from the slider's.

    Chipmunk (cpGrooveJoint.c) divides by the mass that it feels before it drops what acts along the groove. Its solver
    then settles where part of the speed along it is left across it, for any number of iterations, unless that mass
    couples neither direction with the other: the arm of the impulse is along the groove or across it on either body.
    As the slide holds the turns together, its line and its point may be moved across together.

    Args:
        anchor, point: of the line and of the slider [m], from the centre of gravity of either body.
    """
    across = (-math.sin(joint.direction), math.cos(joint.direction))
    line = anchor[0] * across[0] + anchor[1] * across[1]
    turned = joint.direction - joint.angle
    across_slider = (-math.sin(turned), math.cos(turned))
    off = point[0] * across_slider[0] + point[1] * across_slider[1] - line
    middle = (anchor[0] - line * across[0], anchor[1] - line * across[1])
    return middle, (off * across_slider[0], off * across_slider[1])


def _size(mechanism: Mechanism) -> float:
    return max(max(abs(x), abs(y)) for x, y, _ in mechanism.poses.values()) or 1.0


def _add_shapes(made: Build, joint: CamContact, settings: PymunkSettings) -> None:
    """Cam and roller, the only shapes; smooth and without restitution."""
    cam, follower = made.link(joint.a), made.link(joint.b)
    outline = rounded_polygon(joint.profile, settings.cam_vertices)
    shapes: list[pymunk.Shape] = [pymunk.Poly(cam, wedge, radius=outline.radius) for wedge in wedges(outline)]
    centre = made.local(joint.b, joint.roller_centre)
    shapes.append(pymunk.Circle(follower, joint.roller_radius, centre))
    for shape in shapes:
        shape.friction, shape.elasticity = 0.0, 0.0
    made.space.add(*shapes)


def rounded_polygon(profile: Profile, vertices: int) -> CamPolygon:
    """The cam inset and rounded again by nine tenths of its least radius: the nose is then nearly exact."""
    return cam_polygon(profile, vertices, ROUNDING * profile.least_radius)


def wedges(outline: CamPolygon) -> list[list[tuple[float, float]]]:
    """The polygon as wedges from its middle; Chipmunk caches vertex numbers in eight bits."""
    corners, middle = outline.vertices, outline.vertices.mean(axis=0)
    count = math.ceil(len(corners) / WEDGE_FACETS)
    cuts = np.rint(np.linspace(0, len(corners), count + 1)).astype(int)
    rims = [corners[np.arange(first, last + 1) % len(corners)] for first, last in pairwise(cuts)]
    return [[(float(x), float(y)) for x, y in (*rim, middle)] for rim in rims]
