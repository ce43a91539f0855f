"""What rolls, fitted to how it stands at the start."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from conrod.errors import InvalidInput
from conrod.mechanism import Joint, Pose, to_world
from conrod.mechanism_files.numbers import LENGTH
from conrod.rolling import Rack, Rolling


def fitted(joint: Joint, poses: Mapping[str, Pose]) -> Joint:
    """A joint that rolls, with the offset that start poses leave; any other one as it is.

    Raises:
        InvalidInput: there is no line of centres to count turns against.
    """
    if not isinstance(joint, Rolling | Rack):
        return joint
    a, b = (poses.get(body, (0.0, 0.0, 0.0)) for body in (joint.a, joint.b))
    (ax, ay), (bx, by) = to_world(a, joint.point_a), to_world(b, joint.point_b)
    if isinstance(joint, Rolling):
        if math.dist((ax, ay), (bx, by)) < LENGTH.lowest:
            raise InvalidInput(f"joints.{joint.name}: the two centres are one and the same place at the start")
        alpha = math.atan2(by - ay, bx - ax)
        return replace(joint, offset=joint.radius_a * (a[2] - alpha) + joint.radius_b * (b[2] - alpha))
    direction = b[2] + joint.direction
    way = (ax - bx) * math.cos(direction) + (ay - by) * math.sin(direction)
    return replace(joint, offset=way + joint.radius * (a[2] - b[2]))
