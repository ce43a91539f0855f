"""Mechanism -> pymunk `Space`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pymunk

from conrod.cam import CamProfile
from conrod.engines.cam_polygon import CamPolygon, cam_polygon
from conrod.engines.engine import Machine
from conrod.engines.left_out_rod import DistanceJoint, ModelForm, model_form
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.mechanism import GROUND, CamContact, Joint, Mechanism, Point, Prismatic, Revolute, to_world
from conrod.motion import Array

ROUNDING = 0.9
WEDGE_FACETS = 240

Pushed = tuple[tuple[pymunk.Body, tuple[float, float]], ...]  # bodies with the constant force [N] on each


@dataclass(frozen=True)
class Build:
    """A space and its bodies, in the order of the bodies of the form's mechanism."""

    form: ModelForm
    space: pymunk.Space
    bodies: tuple[pymunk.Body, ...]
    # Constant forces have to be given again before every step, which clears them.
    pushed: Pushed

    @property
    def mechanism(self) -> Mechanism:
        """What the engine is given: the mechanism without links that are left out."""
        return self.form.mechanism

    @property
    def crank(self) -> pymunk.Body:
        """The driven body."""
        return self.bodies[self.mechanism.body_index[self.mechanism.crank]]

    def place(self, poses: Array, rates: Array) -> None:
        """Put the bodies into poses (3 n,) with rates (3 n,) of all links."""
        poses, rates = self.form.kept(poses), self.form.kept(rates)
        for i, (link, body) in enumerate(zip(self.mechanism.bodies, self.bodies, strict=True)):
            x, y, phi = poses[3 * i : 3 * i + 3]
            vx, vy, spin = rates[3 * i : 3 * i + 3]
            gx, gy = to_world((x, y, phi), link.centre_of_gravity)
            body.position, body.angle = (gx, gy), float(phi)
            body.velocity = (vx - spin * (gy - y), vy + spin * (gx - x))
            body.angular_velocity = float(spin)
        self.space.reindex_shapes_for_body(self.space.static_body)


def build(machine: Machine, settings: PymunkSettings) -> Build:
    """Translate, with the bodies in the exact pose of crank angle 0.

    A link on a slide from the ground cannot turn, so it gets an infinite moment and a groove at its centre of
    gravity. A driven crank is a kinematic body: its speed has no ripple.
    """
    form = model_form(machine.kinematics.mechanism, settings.rod)
    mechanism = form.mechanism
    space = pymunk.Space()
    space.iterations = settings.iterations
    space.gravity = mechanism.gravity if settings.gravity else (0.0, 0.0)
    space.collision_slop, space.collision_bias = settings.collision_slop, settings.collision_bias
    bodies = tuple(_body(mechanism, link.name) for link in mechanism.bodies)
    space.add(*bodies)
    pushed = tuple((bodies[mechanism.body_index[f.body]], f.force) for f in mechanism.forces)
    made = Build(form, space, bodies, pushed)
    start = machine.kinematics.start[0]
    made.place(start, np.zeros_like(start))
    for joint in mechanism.joints:
        if joint.name != mechanism.driver.joint:
            _add_joint(made, joint, settings)
    for distance in form.distances:
        _add(made, _rod(made, distance), settings)
    return made


def _body(mechanism: Mechanism, name: str) -> pymunk.Body:
    if name == mechanism.crank:
        return pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    link = mechanism.body(name)
    moment = math.inf if _slides_on_ground(mechanism, name) else link.inertia
    return pymunk.Body(link.mass, moment)


def _slides_on_ground(mechanism: Mechanism, name: str) -> bool:
    return any(isinstance(j, Prismatic) and {j.a, j.b} == {GROUND, name} for j in mechanism.joints)


def _add_joint(made: Build, joint: Joint, settings: PymunkSettings) -> None:
    match joint:
        case Revolute():
            pins = [
                _from_gravity_centre(made.mechanism, b, p)
                for b, p in ((joint.a, joint.point_a), (joint.b, joint.point_b))
            ]
            constraints: list[pymunk.Constraint] = [
                pymunk.PivotJoint(_link(made, joint.a), _link(made, joint.b), pins[0], pins[1])
            ]
        case Prismatic():
            constraints = _slide(made, joint)
        case CamContact():
            _add_shapes(made, joint, settings)
            constraints = []
    for constraint in constraints:
        _add(made, constraint, settings)


def _add(made: Build, constraint: pymunk.Constraint, settings: PymunkSettings) -> None:
    constraint.error_bias = settings.error_bias
    constraint.collide_bodies = False
    made.space.add(constraint)


def _rod(made: Build, joint: DistanceJoint) -> pymunk.PinJoint:
    a = _from_gravity_centre(made.mechanism, joint.a, joint.point_a)
    b = _from_gravity_centre(made.mechanism, joint.b, joint.point_b)
    rod = pymunk.PinJoint(_link(made, joint.a), _link(made, joint.b), a, b)
    rod.distance = joint.length  # without it the distance is measured, and has the rounding of the start pose
    return rod


def _slide(made: Build, joint: Prismatic) -> list[pymunk.Constraint]:
    a, b = _link(made, joint.a), _link(made, joint.b)
    reach = 100.0 * _size(made.mechanism)
    anchor = _from_gravity_centre(made.mechanism, joint.a, joint.point_a)
    along = (reach * math.cos(joint.direction), reach * math.sin(joint.direction))
    ends = [(anchor[0] + k * along[0], anchor[1] + k * along[1]) for k in (-1.0, 1.0)]
    point = _from_gravity_centre(made.mechanism, joint.b, joint.point_b)
    constraints: list[pymunk.Constraint] = [pymunk.GrooveJoint(a, b, ends[0], ends[1], point)]
    if joint.a != GROUND:
        constraints.append(pymunk.GearJoint(a, b, joint.angle, 1.0))
    return constraints


def _size(mechanism: Mechanism) -> float:
    return max(max(abs(x), abs(y)) for x, y, _ in mechanism.poses.values()) or 1.0


def _add_shapes(made: Build, joint: CamContact, settings: PymunkSettings) -> None:
    """Cam and roller, the only shapes; smooth and without restitution."""
    cam, follower = _link(made, joint.a), _link(made, joint.b)
    outline = rounded_polygon(joint.profile, settings.cam_vertices)
    shapes: list[pymunk.Shape] = [pymunk.Poly(cam, wedge, radius=outline.radius) for wedge in wedges(outline)]
    centre = _from_gravity_centre(made.mechanism, joint.b, joint.roller_centre)
    shapes.append(pymunk.Circle(follower, joint.roller_radius, centre))
    for shape in shapes:
        shape.friction, shape.elasticity = 0.0, 0.0
    made.space.add(*shapes)


def rounded_polygon(profile: CamProfile, vertices: int) -> CamPolygon:
    """The cam inset and rounded again by nine tenths of its least radius: the nose is then nearly exact."""
    return cam_polygon(profile, vertices, ROUNDING * min(arc.radius for arc in profile.arcs))


def wedges(outline: CamPolygon) -> list[list[tuple[float, float]]]:
    """The polygon as wedges from its middle; Chipmunk caches vertex numbers in eight bits."""
    corners, middle = outline.vertices, outline.vertices.mean(axis=0)
    count = math.ceil(len(corners) / WEDGE_FACETS)
    cuts = np.rint(np.linspace(0, len(corners), count + 1)).astype(int)
    rims = [corners[np.arange(first, last + 1) % len(corners)] for first, last in pairwise(cuts)]
    return [[(float(x), float(y)) for x, y in (*rim, middle)] for rim in rims]


def _link(made: Build, name: str) -> pymunk.Body:
    return made.space.static_body if name == GROUND else made.bodies[made.mechanism.body_index[name]]


def _from_gravity_centre(mechanism: Mechanism, name: str, point: Point) -> Point:
    """A point in pymunk's body frame, whose origin is the centre of gravity."""
    if name == GROUND:
        return point
    cx, cy = mechanism.body(name).centre_of_gravity
    return (point[0] - cx, point[1] - cy)
