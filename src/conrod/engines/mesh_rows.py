"""Rolling pairs in the coordinates of a spanning tree, where their equations are linear.

Turns of bodies are sums of the turns of pins. The line of centres of two wheels turns with whatever body both are
pinned to, and the way of a wheel along a rack is that of the slides between them: then nothing in the equation depends
on the pose, and an engine that ties coordinates linearly has it exactly.
"""

from __future__ import annotations

import math

import numpy as np

from conrod.engines.tree import Branch, Tree
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mechanism, Mesh, Point, Prismatic, Rack, Revolute, Rolling

SAME_PLACE = 1e-12  # of the largest coordinate of a point on a body


def mesh_row(tree: Tree, mesh: Mesh) -> Array:
    """Share of each joint coordinate of a tree in what rolls off a pair: (nv,) [m/rad] of pins, [m/m] of slides.

    Raises:
        InvalidInput: the pair's equation is not linear in them; says why.
    """
    turn_a, turn_b = turn_row(tree, mesh.a), turn_row(tree, mesh.b)
    if isinstance(mesh, Rolling):
        carrier = carrier_of(tree.mechanism, mesh)
        if carrier is None:
            raise InvalidInput(f"{mesh.name}: no one body carries the pins of both {mesh.a} and {mesh.b}")
        line = (mesh.radius_a + mesh.radius_b) * turn_row(tree, carrier)
        return np.asarray(mesh.radius_a * turn_a + mesh.radius_b * turn_b - line)
    return np.asarray(_way_row(tree, mesh) + mesh.radius * (turn_a - turn_b))


def tree_refusal(tree: Tree) -> str | None:
    """None, or the reason why an engine that ties joint coordinates linearly cannot have the rolling pairs."""
    for mesh in tree.mechanism.meshes:
        try:
            mesh_row(tree, mesh)
        except InvalidInput as reason:
            return f"{reason}: what rolls off is then not linear in the joints' coordinates"
    return None


def carrier_of(mechanism: Mechanism, mesh: Rolling) -> str | None:
    """The body that both centres of a rolling pair are pinned to, or are points of; the ground before any other."""
    first = holders(mechanism, mesh.a, mesh.point_a)
    second = holders(mechanism, mesh.b, mesh.point_b)
    common = [body for body in first if body in second]
    return min(common, key=lambda body: body != GROUND, default=None)


def holders(mechanism: Mechanism, body: str, point: Point) -> dict[str, Point]:
    """Bodies that a point of a body does not move on, itself among them, each with the place where it is on them."""
    found, waiting = {body: point}, [body]
    while waiting:
        here = waiting.pop()
        for joint in mechanism.joints:
            if not isinstance(joint, Revolute) or here not in (joint.a, joint.b):
                continue
            ends = [(joint.a, joint.point_a), (joint.b, joint.point_b)]
            (_, own), (other, there) = ends if joint.a == here else ends[::-1]
            if other not in found and _same(own, found[here]):
                found[other] = there
                waiting.append(other)
    return found


def _same(first: Point, second: Point) -> bool:
    size = max(1e-3, *(abs(v) for v in (*first, *second)))
    return math.dist(first, second) <= SAME_PLACE * size


def _path(tree: Tree, body: str) -> list[int]:
    """Branches from a body down to the ground, by number."""
    carried = {branch.child: k for k, branch in enumerate(tree.branches)}
    path = []
    while body != GROUND:
        path.append(carried[body])
        body = tree.branches[path[-1]].parent
    return path


def turn_row(tree: Tree, body: str) -> Array:
    """Share of each joint coordinate of a tree in the turn of a body (nv,)."""
    row = np.zeros(len(tree.branches))
    for k in _path(tree, body):
        if isinstance(tree.branches[k].joint, Revolute):
            row[k] = tree.branches[k].sense
    return row


def _way_row(tree: Tree, mesh: Rack) -> Array:
    """Of the way of the wheel's centre along the rack, against the rack."""
    for body in holders(tree.mechanism, mesh.a, mesh.point_a):
        to_centre, to_rack = set(_path(tree, body)), set(_path(tree, mesh.b))
        between = to_centre ^ to_rack
        if all(isinstance(tree.branches[k].joint, Prismatic) for k in between):
            line = tree.start_pose(mesh.b)[2] + mesh.direction
            row = np.zeros(len(tree.branches))
            for k in between:
                branch = tree.branches[k]
                row[k] = (1.0 if k in to_centre else -1.0) * math.cos(_direction(tree, branch) - line)
            return row
    raise InvalidInput(f"{mesh.name}: more than slides lies between the centre of {mesh.a} and {mesh.b}")


def _direction(tree: Tree, branch: Branch) -> float:
    """Direction [rad] in which a slide's coordinate grows, in the start pose."""
    turned = 0.0 if branch.sense > 0 else math.pi
    return float(tree.slide_direction(branch) + tree.start_pose(branch.parent)[2] + turned)
