"""The dimensions that a drawing carries, read off the mechanism itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from conrod.mechanism.cam_law import LawProfile
from conrod.mechanism.mechanism import GROUND, CamContact, Mechanism, Point, Pose, Prismatic, pins_of, to_world
from conrod.report import numbers

Poses = Mapping[str, Pose]


@dataclass(frozen=True)
class Length:
    """A dimension line beside the line from `start` to `stop` [m]; `aside` of the drawing's size to its left.

    Its second extension line begins at `stop_from`, where that is not `stop`; its text stands at `text_at` of the line.
    """

    text: str
    start: Point
    stop: Point
    aside: float
    stop_from: Point | None = None
    text_at: float = 0.5


@dataclass(frozen=True)
class Radius:
    """An arrow from a centre [m] to its circle, in a direction [rad]; `text_at` of the radius from the centre."""

    text: str
    centre: Point
    radius: float
    direction: float
    text_at: float = 0.55


Dimension = Length | Radius
SYMMETRIC = 4  # arcs of a symmetric cam


def dimensions(mechanism: Mechanism, poses: Poses) -> tuple[Dimension, ...]:
    """Lengths of the links between their pins, offsets of the slides from the shaft, radii of the cams."""
    lines: list[Dimension] = []
    for body in mechanism.bodies:
        lines += _link(body.name, mechanism, poses)
    for joint in mechanism.joints:
        match joint:
            case Prismatic() if joint.a == GROUND and not mechanism.cam_contacts:
                lines += _offset(joint, mechanism, poses)
            case CamContact():
                lines += _cam(joint, poses)
            case _:
                pass
    return tuple(lines)


def _link(name: str, mechanism: Mechanism, poses: Poses) -> list[Dimension]:
    """The length of a link with two pins."""
    # Several links may share a pin.
    pins = [to_world(poses[name], point) for point in dict.fromkeys(pins_of(mechanism, name))]
    if len(pins) != 2 or math.dist(*pins) == 0.0:
        return []
    text = f"{name} {_mm(math.dist(*pins))}"
    if name == mechanism.crank:
        # On the side that the crank angle leaves free.
        return [Length(text, pins[0], pins[1], 0.07 * mechanism.driver.sense)]
    # On the outer side of the link's bend with the line to the shaft.
    shaft = to_world(poses[mechanism.crank], mechanism.driven_joint.point_b)
    bend = (pins[0][0] - shaft[0]) * (pins[1][1] - pins[0][1]) - (pins[0][1] - shaft[1]) * (pins[1][0] - pins[0][0])
    return [Length(text, pins[0], pins[1], -0.07 if bend > 0.0 else 0.07)]


def _offset(slide: Prismatic, mechanism: Mechanism, poses: Poses) -> list[Dimension]:
    """The distance of a slide's line from the shaft, drawn at the slider; nothing where the line passes through it."""
    shaft = to_world(poses[mechanism.crank], mechanism.driven_joint.point_b)
    slider = to_world(poses[slide.b], slide.point_b)
    nx, ny = -math.sin(slide.direction), math.cos(slide.direction)
    away = (slider[0] - shaft[0]) * nx + (slider[1] - shaft[1]) * ny
    if abs(away) < 1e-9 * math.dist(slider, shaft):
        return []
    foot = (slider[0] - away * nx, slider[1] - away * ny)
    return [Length(f"offset {_mm(abs(away))}", slider, foot, -0.08, stop_from=shaft)]


def _cam(contact: CamContact, poses: Poses) -> tuple[Dimension, ...]:
    """Radii of a profile of one arc, of nose, flank, base and flank, or of a law's base circle; and the roller's."""
    cam = poses[contact.a]
    roller = to_world(poses[contact.b], contact.roller_centre)
    of_roller = Radius(f"roller {_mm(contact.roller_radius)}", roller, contact.roller_radius, math.radians(30.0), 1.9)
    profile = contact.profile
    if isinstance(profile, LawProfile):
        direction = cam[2] + profile.begin - profile.sense * profile.lowest_angle
        return (Radius(f"base {_mm(profile.base_radius)}", (cam[0], cam[1]), profile.base_radius, direction), of_roller)
    if len(profile.arcs) == 1:
        arc = profile.arcs[0]
        return (Radius(f"one circle {_mm(arc.radius)}", to_world(cam, arc.centre), arc.radius, cam[2]), of_roller)
    if len(profile.arcs) != SYMMETRIC:
        return (of_roller,)
    nose, flank, base, _ = profile.arcs
    axis = cam[2]
    return (
        Radius(f"base {_mm(base.radius)}", to_world(cam, base.centre), base.radius, axis + math.radians(130.0)),
        Radius(f"nose {_mm(nose.radius)}", to_world(cam, nose.centre), nose.radius, axis),
        # The flank's arrow ends in the middle of the flank turned away from the roller.
        Radius(
            f"flank {_mm(flank.radius)}",
            to_world(cam, (flank.centre[0], -flank.centre[1])),
            flank.radius,
            axis - 0.5 * (flank.start + flank.stop),
            0.6,
        ),
        Length(f"centre distance {_mm(math.hypot(*nose.centre))}", (cam[0], cam[1]), to_world(cam, nose.centre), -0.32),
        of_roller,
    )


def _mm(length: float) -> str:
    return "{} {}".format(*numbers.in_shown_unit(length, "m"))
