"""Rolling pairs as pymunk's `GearJoint`, which ties the angles of two bodies: ratio x angle b - angle a = phase.

Where wheels roll on a carrier that rotates too, one equation has the angles of three bodies. Such equations are solved
for each other: in a planetary gear with a fixed sun the planet's angle follows from the arm's, and so does the ring's.
The result is the same equations, with two bodies each.
"""

from __future__ import annotations

import numpy as np

from conrod.engines.spanning_tree import carrier_body
from conrod.errors import InvalidInput
from conrod.mechanism.mechanism import GROUND, Mechanism, Mesh, Prismatic, Rack

RACK_REFUSAL = "pymunk has no joint that ties the way along a line to a turn, which a rack needs"
# Of the largest weight: a smaller one is zero but for rounding.
WEIGHT_ROUNDING = 1e-12

Weights = dict[str, float]  # length that rolls off per angle of each body [m/rad]


def gears_refusal(mechanism: Mechanism) -> str | None:
    """Return the reason why pymunk cannot have the mechanism's rolling pairs, or None."""
    try:
        gear_ties(mechanism)
    except InvalidInput as reason:
        return str(reason)
    return None


def gear_ties(mechanism: Mechanism) -> dict[str, Weights]:
    """For each rolling pair, two bodies and the weights of their angles in an equivalent set of equations.

    Raises:
        InvalidInput: pymunk cannot have a pair; says why.
    """
    direct = {mesh.name: _rotation_weights(mechanism, mesh) for mesh in mechanism.meshes}
    if all(len(weights) == 2 for weights in direct.values()):
        return direct
    solved = _reduce_rows(mechanism, list(direct.values()))
    for weights in solved:
        if len(weights) != 2:
            bodies = " and ".join(weights) or "none"
            raise InvalidInput(f"pymunk's gear joint ties the turns of two bodies; here {bodies} hang together")
    return dict(zip(direct, solved, strict=True))


def _reduce_rows(mechanism: Mechanism, rows: list[Weights]) -> list[Weights]:
    """Reduced row echelon form of the equations, with the crank's angle as the last unknown."""
    turning = {body for row in rows for body in row}
    bodies = [body for body in mechanism.body_index if body in turning - {mechanism.crank}]
    bodies += [mechanism.crank] if mechanism.crank in turning else []
    matrix = np.array([[row.get(body, 0.0) for body in bodies] for row in rows])
    least = WEIGHT_ROUNDING * np.abs(matrix).max(initial=0.0)
    done = 0
    for column in range(len(bodies)):
        pivot = done + int(np.argmax(np.abs(matrix[done:, column]))) if done < len(rows) else done
        if done == len(rows) or abs(matrix[pivot, column]) <= least:
            continue
        matrix[[done, pivot]] = matrix[[pivot, done]]
        others = np.arange(len(rows)) != done
        matrix[others] -= np.outer(matrix[others, column] / matrix[done, column], matrix[done])
        done += 1
    return [{b: float(w) for b, w in zip(bodies, row, strict=True) if abs(w) > least} for row in matrix]


def _rotation_weights(mechanism: Mechanism, mesh: Mesh) -> Weights:
    """Coefficients [m/rad] of the bodies' angles in the rolling equation of a pair of gears.

    With radii a and b (negative for a ring gear) and carrier c: a phi_a + b phi_b - (a + b) phi_c = constant. Bodies
    that cannot rotate are left out.
    """
    if isinstance(mesh, Rack):
        raise InvalidInput(f"{mesh.name}: {RACK_REFUSAL}")
    carrier = carrier_body(mechanism, mesh)
    if carrier is None:
        raise InvalidInput(
            f"{mesh.name}: no one body carries the pins of both {mesh.a} and {mesh.b}, so that turns do not tell "
            "what rolls off"
        )
    weights: Weights = {}
    ends = ((mesh.a, mesh.radius_a), (mesh.b, mesh.radius_b), (carrier, -(mesh.radius_a + mesh.radius_b)))
    for body, weight in ends:
        weights[body] = weights.get(body, 0.0) + weight
    still = _bodies_without_rotation(mechanism)
    return {body: weight for body, weight in weights.items() if weight != 0.0 and body not in still}


def _bodies_without_rotation(mechanism: Mechanism) -> set[str]:
    """Names of the bodies that cannot rotate: the ground, and those connected to it by slides."""
    found, before = {GROUND}, 0
    while len(found) > before:
        before = len(found)
        for joint in mechanism.joints:
            if isinstance(joint, Prismatic) and found & {joint.a, joint.b}:
                found |= {joint.a, joint.b}
    return found
