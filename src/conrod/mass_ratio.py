"""The ratio of masses that decides how fast an iteration from link to link converges."""

from __future__ import annotations

import math

from conrod.mechanism import GROUND, Mechanism, Point, Prismatic, Revolute


def mass_ratio(mechanism: Mechanism) -> float:
    """Heaviest link over the lightest that a joint feels, the driven link apart; 1 where that is alone."""
    masses = [body.mass for body in mechanism.bodies if body.name != mechanism.crank]
    felt = [
        _felt_mass(mechanism, body, point)
        for joint in mechanism.joints
        if isinstance(joint, Revolute)
        for body, point in ((joint.a, joint.point_a), (joint.b, joint.point_b))
        if body not in (GROUND, mechanism.crank)
    ]
    return max(masses) / min([*masses, *felt]) if masses else 1.0


def _felt_mass(mechanism: Mechanism, name: str, point: Point) -> float:
    """Mass [kg] of a link as felt at a point: 1 / (1/m + d^2/I), d from its centre of gravity."""
    body = mechanism.body(name)
    if any(isinstance(j, Prismatic) and name in (j.a, j.b) for j in mechanism.joints):
        return body.mass  # cannot turn
    distance = math.hypot(point[0] - body.centre_of_gravity[0], point[1] - body.centre_of_gravity[1])
    return 1.0 / (1.0 / body.mass + distance**2 / body.inertia)
