"""The dimensions that a drawing carries: a scene's length parameters, placed on its mechanism."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from conrod.mechanism import CamContact, Mechanism, Point, Pose, Revolute, to_world
from conrod.report import numbers
from conrod.scenes import CamFollower, Saw, Scene, ShearPress

Poses = Mapping[str, Pose]


@dataclass(frozen=True)
class Length:
    """A dimension line beside the line from `start` to `stop` [m]; `aside` of the drawing's size to its left.

    Its second extension line begins at `stop_from`, where that is not `stop`.
    """

    text: str
    start: Point
    stop: Point
    aside: float
    stop_from: Point | None = None


@dataclass(frozen=True)
class Radius:
    """An arrow from a centre [m] to its circle, in a direction [rad]; `text_at` of the radius from the centre."""

    text: str
    centre: Point
    radius: float
    direction: float
    text_at: float = 0.55


Dimension = Length | Radius


def dimensions(scene: Scene, mechanism: Mechanism, poses: Poses) -> tuple[Dimension, ...]:
    """What is to be dimensioned; nothing for a scene that is not known here."""
    match scene:
        case ShearPress():
            return _crank_and_rod(scene.crank, scene.rod, mechanism, poses)
        case Saw():
            shaft = _pin(mechanism, "shaft", poses)
            x, y, _ = poses["slider"]
            offset = Length(f"offset {_mm(scene.offset)}", (x, y), (x, shaft[1]), -0.08, stop_from=shaft)
            return (*_crank_and_rod(scene.crank, scene.rod, mechanism, poses), offset)
        case CamFollower():
            return _cam(scene, mechanism.cam_contacts[0], poses)
        case _:
            return ()


def _crank_and_rod(crank: float, rod: float, mechanism: Mechanism, poses: Poses) -> tuple[Dimension, ...]:
    shaft, pin, end = (_pin(mechanism, name, poses) for name in ("shaft", "crank-pin", "slider-pin"))
    # The rod on the outer side of its bend with the crank; the crank on the side that the crank angle leaves free.
    bend = (pin[0] - shaft[0]) * (end[1] - pin[1]) - (pin[1] - shaft[1]) * (end[0] - pin[0])
    outer = -1.0 if bend > 0.0 else 1.0
    return (
        Length(f"crank {_mm(crank)}", shaft, pin, 0.07 * mechanism.driver.sense),
        Length(f"rod {_mm(rod)}", pin, end, 0.07 * outer),
    )


def _pin(mechanism: Mechanism, name: str, poses: Poses) -> Point:
    joint = next(j for j in mechanism.joints if j.name == name)
    assert isinstance(joint, Revolute)
    return to_world(poses[joint.b], joint.point_b)


def _cam(scene: CamFollower, contact: CamContact, poses: Poses) -> tuple[Dimension, ...]:
    cam = poses[contact.a]
    roller = to_world(poses[contact.b], contact.roller_centre)
    of_roller = Radius(f"roller {_mm(contact.roller_radius)}", roller, contact.roller_radius, math.radians(30.0), 1.9)
    if scene.is_one_circle:
        arc = contact.profile.arcs[0]
        return (Radius(f"one circle {_mm(arc.radius)}", to_world(cam, arc.centre), arc.radius, cam[2]), of_roller)
    nose, flank, base, _ = contact.profile.arcs
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
        Length(f"centre distance {_mm(scene.centre_distance)}", (cam[0], cam[1]), to_world(cam, nose.centre), -0.32),
        of_roller,
    )


def _mm(length: float) -> str:
    return "{} {}".format(*numbers.in_shown_unit(length, "m"))
