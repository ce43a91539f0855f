"""A machine in space with fewer bodies: those that do not move against their parents are merged into them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import COORDINATES, RATES, SpatialBody, SpatialClosure, SpatialJoint, SpatialPoint, SpatialTree
from conrod.exact.space.forward_kinematics import forward_kinematics


@dataclass(frozen=True, eq=False)
class _Part:
    """A body as a part of a body of the smaller tree: its number there; origin (3,) [m] and rotation (3, 3) in it."""

    number: int
    origin: Array
    turn: Array

    def place_of(self, point: SpatialPoint) -> SpatialPoint:
        return SpatialPoint(self.number, self.origin + self.turn @ point.offset)


def merge_rigid_parts(tree: SpatialTree, pose: Array, held: Collection[str]) -> SpatialTree:
    """Return the same machine without held joints, and without bodies that then do not move against their parents.

    Engines differ in whether they take a body without a joint, and none needs a joint that never moves.

    Args:
        pose: closed coordinates (nq, 1), at which the held joints stay; the smaller machine starts there.
        held: names of joints that do not move.

    Raises:
        InvalidInput: a body has a held joint beside one that moves.
    """
    poses = forward_kinematics(tree, pose)
    places = [np.asarray(one[0])[:, 0] for one in poses.places]
    turns = [np.asarray(one[0])[:, :, 0] for one in poses.turns]
    parts, bodies = [_Part(0, np.zeros(3), np.eye(3))], [tree.bodies[0]]
    for number, body in enumerate(tree.bodies[1:], 1):
        above = parts[body.parent]
        if body.joints and not any(joint.name in held for joint in body.joints):
            parts.append(_Part(len(bodies), np.zeros(3), np.eye(3)))
            place, turn = above.origin + above.turn @ body.place, above.turn @ body.turn
            bodies.append(replace(body, parent=above.number, place=place, turn=turn))
            continue
        if moving := [joint.name for joint in body.joints if joint.name not in held]:
            raise InvalidInput(f"{body.name}: {moving[0]} moves it beside a joint that is held: drive both, or none")
        back = turns[body.parent].T
        place, turn = back @ (places[number] - places[body.parent]), back @ turns[number]
        part = _Part(above.number, above.origin + above.turn @ place, above.turn @ turn)
        parts.append(part)
        if part.number:
            bodies[part.number] = _with_mass_of(bodies[part.number], body, part)
    joints, kept = _renumber_joints(tree, held)
    numbered = tuple(
        replace(body, joints=tuple(replace(joints[one.name], body=number) for one in body.joints))
        for number, body in enumerate(bodies)
    )
    closures = tuple(
        made for one in tree.closures if (made := _closure_of_parts(one, tree, parts, joints, pose)) is not None
    )
    points = {name: parts[point.body].place_of(point) for name, point in tree.points.items()}
    return SpatialTree(numbered, closures, points, tree.gravity, pose[kept, 0], tree.unmodelled)


def _with_mass_of(body: SpatialBody, other: SpatialBody, part: _Part) -> SpatialBody:
    """A body with the mass and the inertia of another body that is fixed to it."""
    mass = body.mass + other.mass
    if not other.mass > 0.0:
        return body
    centre = part.origin + part.turn @ other.centre
    middle = (body.mass * body.centre + other.mass * centre) / mass
    inertia = np.zeros((3, 3))
    for own, place, about in (
        (body.mass, body.centre, body.inertia),
        (other.mass, centre, part.turn @ other.inertia @ part.turn.T),
    ):
        arm = place - middle
        inertia += about + own * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return replace(body, mass=mass, centre=middle, inertia=inertia)


def _renumber_joints(tree: SpatialTree, held: Collection[str]) -> tuple[dict[str, SpatialJoint], list[int]]:
    """The joints that are left, by name, with numbers of their own; and their coordinates' numbers in the old tree."""
    made, kept, rate = dict[str, SpatialJoint](), list[int](), 0
    for joint in tree.joints:
        if joint.name in held:
            continue
        made[joint.name] = replace(joint, coordinate=len(kept), rate=rate)
        kept += range(joint.coordinate, joint.coordinate + COORDINATES[joint.kind])
        rate += RATES[joint.kind]
    return made, kept


def _closure_of_parts(
    closure: SpatialClosure, tree: SpatialTree, parts: list[_Part], joints: dict[str, SpatialJoint], pose: Array
) -> SpatialClosure | None:
    """A closure between the bodies of the smaller tree; None where nothing that it holds moves."""
    if closure.points:
        one, other = (parts[point.body] for point in closure.points)
        if one.number == other.number:
            return None
        points = tuple(parts[point.body].place_of(point) for point in closure.points)
        turn = None if closure.turn is None else one.turn @ closure.turn @ other.turn.T
        return replace(closure, points=points, turn=turn)
    by_rate = {joint.rate: joint for joint in tree.joints}
    sums, references = list[dict[int, float]](), list[float]()
    for terms, reference in zip(closure.sums, closure.references, strict=True):
        left = {rate: factor for rate, factor in terms.items() if by_rate[rate].name in joints}
        fixed = sum(f * pose[by_rate[rate].coordinate, 0] for rate, f in terms.items() if rate not in left)
        sums.append({joints[by_rate[rate].name].rate: factor for rate, factor in left.items()})
        references.append(float(reference - fixed))
    if not any(sums):
        return None
    polynomial = closure.polynomial
    if not sums[1]:  # its independent joints stand still
        at = -references[1] if closure.sums[1] else 0.0
        polynomial = (float(np.polynomial.Polynomial(polynomial)(at)), 0.0, 0.0, 0.0, 0.0)
    return replace(closure, sums=tuple(sums), references=tuple(references), polynomial=polynomial)
