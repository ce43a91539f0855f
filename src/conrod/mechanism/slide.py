"""A slide between two links as a block in its guide."""

from __future__ import annotations

from dataclasses import dataclass

from conrod.mechanism.mechanism import GROUND, Mechanism, Point, Prismatic, Revolute, joint_partner


@dataclass(frozen=True)
class Slide:
    """A block that slides along a line of its guide.

    Attributes:
        guide: body on which the block slides; the ground, if it is one of the joint's two.
        moving: body of the block.
        point: the block's point in the frame of `moving` [m].
        direction: direction of the guide's line in the frame of `guide` [rad].
    """

    guide: str
    moving: str
    point: Point
    direction: float


def guide_and_block(mechanism: Mechanism, joint: Prismatic) -> Slide:
    """Decide which body of a prismatic joint is its guide, and which its block."""
    guide, moving, point = joint.a, joint.b, joint.point_b
    if joint.b == GROUND:
        guide, moving, point = joint.b, joint.a, joint.point_a
    elif joint.a != GROUND:
        # A body with only one more joint, a pin, is taken for a block on that pin.
        for link, other in ((joint.a, joint.b), (joint.b, joint.a)):
            held = [one for one in mechanism.joints_on(other) if one is not joint]
            if len(held) == 1 and isinstance(held[0], Revolute):
                guide, moving, point = link, other, joint_partner(held[0], other)[2]
                break
    # `b` is rotated against `a` by the joint's angle.
    return Slide(guide, moving, point, joint.direction - (joint.angle if guide == joint.b else 0.0))
