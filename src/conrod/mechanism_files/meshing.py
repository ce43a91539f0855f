"""What rolls, fitted to how it stands at the start."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from conrod.errors import InvalidInput
from conrod.mechanism import Joint, Mechanism, Pose, to_world
from conrod.rolling import Rack, Rolling

# Of the distance of two centres: what written digits may leave between it and the radii.
TOUCHING = 1e-6


def fitted(joint: Joint, poses: Mapping[str, Pose]) -> Joint:
    """A joint that rolls, with the offset that start poses leave; any other one as it is."""
    if not isinstance(joint, Rolling | Rack):
        return joint
    a, b = (poses.get(body, (0.0, 0.0, 0.0)) for body in (joint.a, joint.b))
    (ax, ay), (bx, by) = to_world(a, joint.point_a), to_world(b, joint.point_b)
    if isinstance(joint, Rolling):
        alpha = math.atan2(by - ay, bx - ax)
        return replace(joint, offset=joint.radius_a * (a[2] - alpha) + joint.radius_b * (b[2] - alpha))
    direction = b[2] + joint.direction
    way = (ax - bx) * math.cos(direction) + (ay - by) * math.sin(direction)
    return replace(joint, offset=way + joint.radius * (a[2] - b[2]))


def check_touching(mechanism: Mechanism, poses: Mapping[str, Pose]) -> None:
    """Refuse circles that do not touch what they roll on, at exact poses.

    Raises:
        InvalidInput: names the joint and both distances.
    """
    for joint in mechanism.meshes:
        a, b = (poses.get(body, (0.0, 0.0, 0.0)) for body in (joint.a, joint.b))
        (ax, ay), (bx, by) = to_world(a, joint.point_a), to_world(b, joint.point_b)
        if isinstance(joint, Rolling):
            wanted, found = joint.distance, math.hypot(bx - ax, by - ay)
        else:
            direction = b[2] + joint.direction
            wanted = joint.radius
            found = (ay - by) * math.cos(direction) - (ax - bx) * math.sin(direction)
        if abs(found - wanted) > TOUCHING * wanted:
            raise InvalidInput(
                f"joints.{joint.name}: the radii want the centre at {wanted:.9g} m, but the other joints hold it at "
                f"{found:.9g} m"
            )
