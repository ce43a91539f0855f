"""Translate a mechanism with settings to a pymunk `Space` with its bodies and joints."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, assert_never

import numpy as np

from conrod.engines.cam_polygon import CamPolygon, cam_polygon, contact_refusal
from conrod.engines.engine import DeferredLibrary, Machine
from conrod.engines.numerics import centre_state
from conrod.engines.pymunk import CONTACT_EDITS, DISTANCE_RODS, LIGHT_RODS, LOOP_EDITS, PymunkSettings
from conrod.engines.pymunk.distance_rods import (
    NO_ROD,
    DistanceRod,
    body_columns,
    find_rods,
    with_light_rods,
    without_rods,
)
from conrod.engines.pymunk.gears import gear_ties, gears_refusal
from conrod.engines.variants import NO_CONTACT, NO_LOOPS
from conrod.exact.motion import Array
from conrod.mechanism.cam_law import Profile
from conrod.mechanism.mechanism import GROUND, CamContact, Joint, Mechanism, Point, Prismatic, Rack, Revolute, Rolling

if TYPE_CHECKING:
    import pymunk

    ConstantForces = tuple[tuple[pymunk.Body, tuple[float, float]], ...]  # bodies, and the constant force [N] on each
else:
    pymunk = DeferredLibrary("pymunk")


@dataclass(frozen=True)
class PymunkSpace:
    """A space with the bodies and constraints of a mechanism."""

    mechanism: Mechanism  # as the engine has it, see `with_crank_centred`; without links that are distance joints
    space: pymunk.Space
    bodies: tuple[pymunk.Body, ...]
    # Applied again before every step, which clears them.
    constant_forces: ConstantForces
    names: dict[pymunk.Constraint, str]  # name of each constraint's joint
    driven: bool  # whether the crank is a kinematic body whose angle is written
    whole: Mechanism  # with all links
    rods: tuple[DistanceRod, ...] = ()  # links without a body

    @property
    def crank(self) -> pymunk.Body:
        """The crank's body."""
        return self.bodies[self.mechanism.body_index[self.mechanism.crank]]

    def set_states(self, poses: Array, rates: Array) -> None:
        """Set the bodies to poses (3 n,) and rates (3 n,) of all links."""
        if self.rods:
            columns = body_columns(self.whole, self.mechanism)
            poses, rates = poses[columns], rates[columns]
        for i, (link, body) in enumerate(zip(self.mechanism.bodies, self.bodies, strict=True)):
            own = slice(3 * i, 3 * i + 3)
            gx, gy, turn, vx, vy, spin = centre_state(link, poses[own], rates[own])
            body.position, body.angle = (gx, gy), turn
            body.velocity, body.angular_velocity = (vx, vy), spin
        self.space.reindex_shapes_for_body(self.space.static_body)

    def rod_rotations(self, state: Array) -> list[float]:
        """Rotations [rad] of the rods without a body, in a state (3 n,) of all links."""
        return [float(state[3 * self.whole.body_index[rod.link] + 2]) for rod in self.rods]

    def add_constraint(self, name: str, constraint: pymunk.Constraint) -> None:
        """Add a constraint of the joint of this name."""
        self.names[constraint] = name
        self.space.add(constraint)

    def body_of(self, name: str) -> pymunk.Body:
        """The body of a link, or the ground's."""
        return self.space.static_body if name == GROUND else self.bodies[self.mechanism.body_index[name]]

    def to_body_frame(self, name: str, point: Point) -> Point:
        """A point of a link in pymunk's body frame, whose origin is the centre of gravity."""
        if name == GROUND:
            return point
        cx, cy = self.mechanism.body(name).centre_of_gravity
        return (point[0] - cx, point[1] - cy)


def with_crank_centred(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with the crank's centre of gravity on its shaft.

    A kinematic body rotates about its centre of gravity, and its mass acts on nothing: so the position of the real one
    does not matter, but the place about which the crank rotates does.
    """
    shaft = mechanism.driven_joint.point_b
    bodies = tuple(
        replace(body, centre_of_gravity=shaft) if body.name == mechanism.crank else body for body in mechanism.bodies
    )
    return replace(mechanism, bodies=bodies)


# -- translation -------------------------------------------------------------------------------------------------------


ROUNDED_SHARE = 0.9  # of a cam's least radius of curvature, by which its polygon is inset and rounded
MAX_WEDGE_FACETS = 240


def refusal(machine: Machine, settings: PymunkSettings) -> str | None:
    """Return the reason why these settings cannot be used on this machine, or None."""
    mechanism = machine.kinematics.mechanism
    return contact_refusal(mechanism) or gears_refusal(mechanism) or edit_refusal(mechanism, settings)


def edit_refusal(mechanism: Mechanism, settings: PymunkSettings) -> str | None:
    """Return the reason why an edit of the settings does not apply to the mechanism, or None."""
    for name in settings.dressing:
        if name in LOOP_EDITS and mechanism.cam_contacts:
            return f"{name}: {NO_LOOPS}"
        if name in CONTACT_EDITS and not mechanism.cam_contacts:
            return f"{name}: {NO_CONTACT}"
        if name in (DISTANCE_RODS, LIGHT_RODS) and not find_rods(mechanism):
            return f"{name}: {NO_ROD}"
    return None


def build(machine: Machine, settings: PymunkSettings) -> PymunkSpace:
    """Build the space of a driven machine, with the bodies in the exact pose at crank angle 0.

    A link on a slide of the ground cannot rotate, so it gets an infinite moment and a groove at its centre of gravity.
    The driven crank is a kinematic body, so its speed has no ripple. Rods are what the settings' edits make of them.
    """
    kinematics = machine.kinematics
    return _build_space(with_crank_centred(kinematics.mechanism), settings, kinematics.start[0], driven=True)


def build_free(mechanism: Mechanism, settings: PymunkSettings, poses: Array) -> PymunkSpace:
    """Build the space of a machine without a drive, with the bodies in given poses (3 n,)."""
    return _build_space(mechanism, settings, poses, driven=False)


def _build_space(mechanism: Mechanism, settings: PymunkSettings, start: Array, driven: bool) -> PymunkSpace:
    """Build the space with all bodies, joints, gears and shapes."""
    whole = with_light_rods(mechanism) if LIGHT_RODS in settings.dressing else mechanism
    rods = find_rods(whole) if DISTANCE_RODS in settings.dressing else ()
    mechanism = without_rods(whole, rods) if rods else whole
    space = pymunk.Space()
    space.iterations = settings.iterations
    space.gravity = mechanism.gravity if settings.gravity else (0.0, 0.0)
    space.collision_slop, space.collision_bias = settings.collision_slop, settings.collision_bias
    bodies = tuple(_create_body(mechanism, link.name, driven) for link in mechanism.bodies)
    space.add(*bodies)
    pushed = tuple((bodies[mechanism.body_index[name]], push) for name, push in mechanism.constant_forces.items())
    made = PymunkSpace(mechanism, space, bodies, pushed, {}, driven, whole, rods)
    made.set_states(start, np.zeros_like(start))
    for joint in mechanism.joints:
        if not driven or joint.name != mechanism.driver.joint:
            _add_joint(made, joint, settings)
    # Phases are those of the start.
    for name, tie in gear_ties(whole).items():
        (first, weight_first), (second, weight_second) = tie.items()
        ratio = -weight_second / weight_first
        turns = [float(start[3 * whole.body_index[body] + 2]) for body in (first, second)]
        gear = pymunk.GearJoint(made.body_of(first), made.body_of(second), ratio * turns[1] - turns[0], ratio)
        _add_constraint(made, name, gear, settings)
    for rod in rods:
        _add_constraint(made, rod.link, _pin_joint(made, rod), settings)
    return made


def _create_body(mechanism: Mechanism, name: str, driven: bool) -> pymunk.Body:
    """Create the body of a link."""
    if driven and name == mechanism.crank:
        return pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    link = mechanism.body(name)
    return pymunk.Body(link.mass, math.inf if isinstance(mechanism.guide(name), Prismatic) else link.inertia)


def _add_joint(made: PymunkSpace, joint: Joint, settings: PymunkSettings) -> None:
    """Add the constraints, or the contact shapes, of a joint."""
    match joint:
        case Revolute():
            pins = [made.to_body_frame(b, p) for b, p in ((joint.a, joint.point_a), (joint.b, joint.point_b))]
            constraints: list[pymunk.Constraint] = [
                pymunk.PivotJoint(made.body_of(joint.a), made.body_of(joint.b), pins[0], pins[1])
            ]
        case Prismatic():
            constraints = _slide_constraints(made, joint)
        case CamContact():
            _add_shapes(made, joint, settings)
            constraints = []
        case Rolling() | Rack():  # added together, as gears
            constraints = []
        case _:
            assert_never(joint)
    for constraint in constraints:
        _add_constraint(made, joint.name, constraint, settings)


def _pin_joint(made: PymunkSpace, rod: DistanceRod) -> pymunk.PinJoint:
    """The distance joint of a rod without a body."""
    anchors = made.to_body_frame(rod.a, rod.point_a), made.to_body_frame(rod.b, rod.point_b)
    joint = pymunk.PinJoint(made.body_of(rod.a), made.body_of(rod.b), *anchors)
    joint.distance = rod.length  # the one that pymunk measures has the rounding of the start pose
    return joint


def _add_constraint(made: PymunkSpace, name: str, constraint: pymunk.Constraint, settings: PymunkSettings) -> None:
    """Add a constraint with the settings' error bias."""
    constraint.error_bias = settings.error_bias
    constraint.collide_bodies = False
    made.add_constraint(name, constraint)


def _slide_constraints(made: PymunkSpace, joint: Prismatic) -> list[pymunk.Constraint]:
    """Groove of a slide, and a gear that ties the angles unless the ground holds them."""
    a, b = made.body_of(joint.a), made.body_of(joint.b)
    reach = 100.0 * _size(made.mechanism)
    anchor, point = made.to_body_frame(joint.a, joint.point_a), made.to_body_frame(joint.b, joint.point_b)
    grounded = GROUND in (joint.a, joint.b)
    if not grounded:
        anchor, point = _move_line_to_centres(joint, anchor, point)
    along = (reach * math.cos(joint.direction), reach * math.sin(joint.direction))
    ends = [(anchor[0] + k * along[0], anchor[1] + k * along[1]) for k in (-1.0, 1.0)]
    constraints: list[pymunk.Constraint] = [pymunk.GrooveJoint(a, b, ends[0], ends[1], point)]
    if not grounded:  # a body on a slide of the ground has an infinite moment
        constraints.append(pymunk.GearJoint(a, b, joint.angle, 1.0))
    return constraints


def _move_line_to_centres(joint: Prismatic, anchor: Point, point: Point) -> tuple[Point, Point]:
    """Shift a slide across: its line to the guide's centre of gravity, its point level with the slider's.

    Chipmunk (cpGrooveJoint.c) divides by the mass along each direction before it drops the part along the groove. Its
    solver then converges to a state in which part of the speed along the groove is left across it, at any number of
    iterations, unless that mass couples no direction with the other: the arm of the impulse is along the groove or
    across it on either body. As the slide ties the angles together, its line and its point may be moved across
    together.

    Args:
        anchor, point: points of the line and of the slider [m], each in its body's frame at the centre of gravity.
    """
    across = (-math.sin(joint.direction), math.cos(joint.direction))
    line = anchor[0] * across[0] + anchor[1] * across[1]
    turned = joint.direction - joint.angle
    across_slider = (-math.sin(turned), math.cos(turned))
    off = point[0] * across_slider[0] + point[1] * across_slider[1] - line
    middle = (anchor[0] - line * across[0], anchor[1] - line * across[1])
    return middle, (off * across_slider[0], off * across_slider[1])


def _size(mechanism: Mechanism) -> float:
    """Largest coordinate [m] of a body in the start pose; 1 if all are 0."""
    return max(max(abs(x), abs(y)) for x, y, _ in mechanism.poses.values()) or 1.0


def _add_shapes(made: PymunkSpace, joint: CamContact, settings: PymunkSettings) -> None:
    """Add the shapes of cam and roller, the only shapes: without friction and restitution."""
    cam, follower = made.body_of(joint.a), made.body_of(joint.b)
    outline = rounded_polygon(joint.profile, settings.cam_vertices)
    shapes: list[pymunk.Shape] = [pymunk.Poly(cam, wedge, radius=outline.radius) for wedge in wedges(outline)]
    centre = made.to_body_frame(joint.b, joint.roller_centre)
    shapes.append(pymunk.Circle(follower, joint.roller_radius, centre))
    for shape in shapes:
        shape.friction, shape.elasticity = 0.0, 0.0
    made.space.add(*shapes)


def rounded_polygon(profile: Profile, vertices: int) -> CamPolygon:
    """The cam inset and rounded by nine tenths of its least radius, which makes its nose nearly exact."""
    return cam_polygon(profile, vertices, ROUNDED_SHARE * profile.least_radius)


def wedges(outline: CamPolygon) -> list[list[tuple[float, float]]]:
    """Wedges of the polygon from its middle, each of few enough vertices: Chipmunk caches their numbers in 8 bits."""
    corners, middle = outline.vertices, outline.vertices.mean(axis=0)
    count = math.ceil(len(corners) / MAX_WEDGE_FACETS)
    cuts = np.rint(np.linspace(0, len(corners), count + 1)).astype(int)
    rims = [corners[np.arange(first, last + 1) % len(corners)] for first, last in pairwise(cuts)]
    return [[(float(x), float(y)) for x, y in (*rim, middle)] for rim in rims]
