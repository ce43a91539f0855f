"""Degrees of freedom and constraints of a built space, along the machine's exact motion.

Every body counts with three coordinates, x and y of its centre of gravity and its turn. Rows are what the space holds
them by: its constraints, read from it; the place of a kinematic body, which is prescribed as its turn is, which is the
drive; a turn without inertia to turn it, of a body of infinite moment; one for the contact of cam and roller.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
import pymunk

from conrod.engines.engine import Machine
from conrod.engines.mobility import MobilityCount, Row, count_mobility
from conrod.engines.pymunk.built import Build
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.space import build
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Prismatic

Gradient = Mapping[pymunk.Body, tuple[float, float, float]]  # of a row, by the coordinates of the bodies


def space_mobility(machine: Machine, settings: PymunkSettings, angle: Array) -> MobilityCount:
    """The count at the exact poses of crank angles (T,) [rad].

    Raises:
        InvalidInput: the machine cannot be given in the form that the settings ask for.
    """
    rows, jacobians = list[Row](), list[Array]()
    made = build(machine, settings)
    for pose in machine.kinematics.poses(angle):
        made.place(pose, np.zeros_like(pose))
        found = list(_rows(made))
        rows = [row for row, _ in found]
        jacobians.append(np.array([_by_coordinates(made, gradient) for _, gradient in found]))
    return count_mobility(rows, np.array(jacobians))


def _by_coordinates(made: Build, gradient: Gradient) -> list[float]:
    # What a body of the ground would contribute moves nothing.
    return [entry for body in made.bodies for entry in gradient.get(body, (0.0, 0.0, 0.0))]


def _rows(made: Build) -> Iterator[tuple[Row, Gradient]]:
    shaft = made.mechanism.driver.joint
    for k, part in enumerate("xy"):
        yield Row(shaft, part), {made.crank: (1.0 - k, float(k), 0.0)}
    for slide in made.mechanism.joints:
        if isinstance(slide, Prismatic) and GROUND in (slide.a, slide.b):
            body = made.link(slide.b if slide.a == GROUND else slide.a)
            if math.isinf(body.moment):
                yield Row(slide.name, "turn"), {body: (0.0, 0.0, 1.0)}
    for constraint in made.space.constraints:
        for part, gradient in _constraint_rows(constraint):
            yield Row(made.names[constraint], part), gradient
    for contact in made.mechanism.cam_contacts:
        distance = _contact_row(made, contact)
        if distance is not None:
            yield Row(contact.name, "distance"), distance


def _constraint_rows(constraint: pymunk.Constraint) -> Iterator[tuple[str, Gradient]]:
    a, b = constraint.a, constraint.b
    match constraint:
        case pymunk.PivotJoint():
            for part, along in (("x", (1.0, 0.0)), ("y", (0.0, 1.0))):
                yield part, _apart(constraint, constraint.anchor_a, along)
        case pymunk.PinJoint():
            way = b.local_to_world(constraint.anchor_b) - a.local_to_world(constraint.anchor_a)
            yield "distance", _apart(constraint, constraint.anchor_a, tuple(way.normalized()))
        case pymunk.GrooveJoint():
            groove = constraint.groove_b - constraint.groove_a
            across = groove.normalized().perpendicular()
            # The point of the groove that the anchor is at moves with the groove's body.
            anchor = a.world_to_local(b.local_to_world(constraint.anchor_b))
            yield "across", _apart(constraint, anchor, tuple(across.rotated(a.angle)))
        case pymunk.GearJoint():
            yield "turn", {a: (0.0, 0.0, -1.0), b: (0.0, 0.0, constraint.ratio)}
        case _:
            raise TypeError(f"{type(constraint).__name__} is no joint that a mechanism is built with")


def _apart(
    constraint: pymunk.PivotJoint | pymunk.PinJoint | pymunk.GrooveJoint,
    anchor: pymunk.Vec2d | tuple[float, float],
    along: tuple[float, ...],
) -> Gradient:
    """Of the distance between two points in a direction: an anchor of the first body, and the second one's own."""
    x, y = along
    (ax, ay), (bx, by) = anchor_arm(constraint.a, anchor), anchor_arm(constraint.b, constraint.anchor_b)
    return {constraint.a: (-x, -y, ay * x - ax * y), constraint.b: (x, y, bx * y - by * x)}


def anchor_arm(body: pymunk.Body, anchor: pymunk.Vec2d | tuple[float, float]) -> tuple[float, float]:
    """The way from a body's centre of gravity to one of its points, in the document's directions [m]."""
    arm = pymunk.Vec2d(*anchor).rotated(body.angle)
    return arm.x, arm.y


def _contact_row(made: Build, contact: CamContact) -> Gradient | None:
    """Of the distance of cam and roller, by the engine's own nearest point; None where the shapes are taken away."""
    cam, follower = made.link(contact.a), made.link(contact.b)
    made.space.reindex_shapes_for_body(cam)
    centre = follower.local_to_world(made.local(contact.b, contact.roller_centre))
    # A body keeps shapes that are taken from the space; those of links have no rounding.
    profile = [s for s in cam.shapes if isinstance(s, pymunk.Poly) and s.radius > 0.0 and s.space is not None]
    if not profile:
        return None
    nearest = min((shape.point_query(centre) for shape in profile), key=lambda found: found.distance)
    x, y = nearest.gradient
    (ax, ay), (bx, by) = (nearest.point - cam.position), (centre - follower.position)
    return {cam: (-x, -y, ay * x - ax * y), follower: (x, y, bx * y - by * x)}
