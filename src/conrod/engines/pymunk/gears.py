"""Rolling pairs by pymunk's `GearJoint`, which ties the turns of two bodies: ratio x turn of b - turn of a = phase.

Where wheels go round on a carrier that turns as well, the turns of three bodies belong together. Such equations are
then solved for each other: in a planetary gear whose sun stands still the planet's turn follows from the arm's, and so
does the ring's. The result is the same equations, of two bodies each.
"""

from __future__ import annotations

import numpy as np

from conrod.engines.spanning_tree import carrier_body
from conrod.errors import InvalidInput
from conrod.mechanism.mechanism import GROUND, Mechanism, Mesh, Prismatic, Rack

RACK_REFUSAL = "pymunk has no joint that ties the way along a line to a turn, which a rack needs"
# What is left of a weight [m] that rounding alone keeps from being zero, of the largest.
ROUNDING = 1e-12

Weights = dict[str, float]  # what the turns of bodies add to what rolls off [m/rad]


def gears_refusal(mechanism: Mechanism) -> str | None:
    """None, or the reason why a mechanism's rolling pairs cannot be given to pymunk."""
    try:
        ties(mechanism)
    except InvalidInput as reason:
        return str(reason)
    return None


def ties(mechanism: Mechanism) -> dict[str, Weights]:
    """The two bodies whose turns each pair ties, with their weights; of pairs solved for each other one for another.

    Raises:
        InvalidInput: pymunk cannot have a pair; says why.
    """
    direct = {mesh.name: _weights(mechanism, mesh) for mesh in mechanism.meshes}
    if all(len(weights) == 2 for weights in direct.values()):
        return direct
    solved = _solved(mechanism, list(direct.values()))
    for weights in solved:
        if len(weights) != 2:
            bodies = " and ".join(weights) or "none"
            raise InvalidInput(f"pymunk's gear joint ties the turns of two bodies; here {bodies} hang together")
    return dict(zip(direct, solved, strict=True))


def _solved(mechanism: Mechanism, rows: list[Weights]) -> list[Weights]:
    """The equations in reduced row echelon form: each turn by those that none tells, the crank's last."""
    turning = {body for row in rows for body in row}
    bodies = [body for body in mechanism.body_index if body in turning - {mechanism.crank}]
    bodies += [mechanism.crank] if mechanism.crank in turning else []
    matrix = np.array([[row.get(body, 0.0) for body in bodies] for row in rows])
    least = ROUNDING * np.abs(matrix).max(initial=0.0)
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


def _weights(mechanism: Mechanism, mesh: Mesh) -> Weights:
    """Of those bodies that turn."""
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
    still = _still(mechanism)
    return {body: weight for body, weight in weights.items() if weight != 0.0 and body not in still}


def _still(mechanism: Mechanism) -> set[str]:
    """Bodies that cannot turn: the ground, and what slides from it."""
    found, before = {GROUND}, 0
    while len(found) > before:
        before = len(found)
        for joint in mechanism.joints:
            if isinstance(joint, Prismatic) and found & {joint.a, joint.b}:
                found |= {joint.a, joint.b}
    return found
