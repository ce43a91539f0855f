"""Slides and their travel: a slide has a guide and a block, whichever of its links a mechanism names first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.exact.linkage.accelerations import coincident_point
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mechanism, Point, Prismatic
from conrod.report.drawing.machine_parts import unit


@dataclass(frozen=True)
class Slide:
    """A block's point on its guide.

    Attributes:
        guide: the body that the block slides on; the ground, if it is one of the two.
        moving: the other body.
        point: of `moving`, in its own frame [m].
        direction: of the guide's line in the frame of `guide` [rad].
    """

    guide: str
    moving: str
    point: Point
    direction: float


def slide_of(mechanism: Mechanism, joint: Prismatic) -> Slide:
    """The guide and the block of a prismatic joint, as a course draws them."""
    sliding = coincident_point(mechanism, joint)
    assert sliding is not None
    guide, moving, point = sliding
    if GROUND in (joint.a, joint.b):
        guide, moving = (joint.a, joint.b) if joint.a == GROUND else (joint.b, joint.a)
        point = joint.point_b if joint.b == moving else joint.point_a
    # `b` is turned against `a` by the joint's angle.
    return Slide(guide, moving, point, joint.direction - (joint.angle if guide == joint.b else 0.0))


def ways(slide: Slide, guides: Array, movings: Array) -> Array:
    """Ways (T,) of the block along its guide's line from the guide's origin, from poses (T, 3) of the two."""
    cos, sin = np.cos(movings[:, 2]), np.sin(movings[:, 2])
    x, y = slide.point
    block = movings[:, :2] + np.column_stack([cos * x - sin * y, sin * x + cos * y])
    turns = guides[:, 2] + slide.direction
    return np.asarray(((block - guides[:, :2]) * np.column_stack([np.cos(turns), np.sin(turns)])).sum(axis=1))


def slot_ends(block: Array, direction: float, reach: tuple[float, float]) -> Array:
    """The two ends (2, 2) of a slot around a block, along a direction [rad] in the plane."""
    return np.asarray(block + np.outer(reach, unit(direction)))
