"""Rolling pairs by pymunk's `GearJoint`, which ties the turns of two bodies: ratio x turn of b - turn of a = phase."""

from __future__ import annotations

import pymunk

from conrod.engines.mesh_rows import carrier_of
from conrod.engines.pymunk.built import Build
from conrod.errors import InvalidInput
from conrod.mechanism import GROUND, Mechanism, Prismatic
from conrod.motion import Array
from conrod.rolling import Rack, Rolling

RACK_REFUSAL = "pymunk has no joint that ties the way along a line to a turn, which a rack needs"


def gears_refusal(mechanism: Mechanism) -> str | None:
    """None, or the reason why a mechanism's rolling pairs cannot be given to pymunk."""
    for mesh in mechanism.meshes:
        if isinstance(mesh, Rack):
            return f"{mesh.name}: {RACK_REFUSAL}"
        if len(_turning(mechanism, mesh)) != 2:
            return f"{mesh.name}: {_three_turn(mechanism, mesh)}"
    return None


def gear_joint(made: Build, mesh: Rolling, start: Array) -> pymunk.GearJoint:
    """The joint of a pair of which two bodies turn: the wheels, or one of them and what carries it round the other.

    Args:
        start: exact poses (3 n,) of all links at crank angle 0, which have the phase.

    Raises:
        InvalidInput: three bodies turn, or one.
    """
    turning = _turning(made.mechanism, mesh)
    if len(turning) != 2:
        raise InvalidInput(f"{made.mechanism.name}: {mesh.name}: {_three_turn(made.mechanism, mesh)}")
    (first, weight_first), (second, weight_second) = turning.items()
    ratio = -weight_second / weight_first
    poses, index = made.form.kept(start), made.mechanism.body_index
    phase = ratio * float(poses[3 * index[second] + 2]) - float(poses[3 * index[first] + 2])
    return pymunk.GearJoint(made.link(first), made.link(second), phase, ratio)


def _turning(mechanism: Mechanism, mesh: Rolling) -> dict[str, float]:
    """What the turns of bodies add to what rolls off [m/rad], of those that turn; empty where the line is not held."""
    carrier = carrier_of(mechanism, mesh)
    if carrier is None:
        return {}
    weights: dict[str, float] = {}
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


def _three_turn(mechanism: Mechanism, mesh: Rolling) -> str:
    carrier = carrier_of(mechanism, mesh)
    if carrier is None:
        return f"no one body carries the pins of both {mesh.a} and {mesh.b}, so that no turns alone tell what rolls off"
    turning = " and ".join(_turning(mechanism, mesh))
    return f"pymunk's gear joint ties the turns of two bodies; here those of {turning} belong together"
