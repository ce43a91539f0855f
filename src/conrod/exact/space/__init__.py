"""A machine in space as plain numbers, independent of any engine: bodies, joints, closures and observed points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from conrod.exact.motion import Array
from conrod.mechanism.units import REVOLUTION

# Number of coordinates and of rates of each joint kind.
COORDINATES = {"hinge": 1, "slide": 1, "ball": 4, "free": 7}
RATES = {"hinge": 1, "slide": 1, "ball": 3, "free": 6}


@dataclass(frozen=True, eq=False)
class SpatialJoint:
    """A joint between a body and its parent.

    Attributes:
        kind: hinge, slide, ball or free.
        coordinate, rate: index of its first number among all coordinates and all rates.
        anchor, axis: (3,) in the body's frame, or (3, T) with one for each sample; a hinge turns positively about its
            axis.
        reference: coordinate at which the body is in its reference pose.
        armature, damping, stiffness, spring: properties of the joint; `spring` is the rest coordinate of its spring.
        range: limits of its coordinate; None if it has none.
    """

    name: str
    kind: str
    body: int
    coordinate: int
    rate: int
    anchor: Array
    axis: Array
    reference: float = 0.0
    armature: float = 0.0
    damping: float = 0.0
    stiffness: float = 0.0
    spring: float = 0.0
    range: tuple[float, float] | None = None

    @property
    def unit(self) -> str:
        """Unit of the joint's coordinate: rad or m."""
        return "m" if self.kind == "slide" else "rad"

    @property
    def coordinates(self) -> slice:
        """Slice of this joint's numbers among all coordinates."""
        return slice(self.coordinate, self.coordinate + COORDINATES[self.kind])

    @property
    def rates(self) -> slice:
        """Slice of this joint's rates among all rates."""
        return slice(self.rate, self.rate + RATES[self.kind])

    @cached_property
    def rodrigues(self) -> tuple[Array, Array, Array]:
        """Matrices (3, 3, 1) K, K^2 and I + K^2 of Rodrigues' formula, K = [axis]x; (3, 3, T) of axes (3, T)."""
        x, y, z = self.axis
        zero = np.zeros_like(x)
        skew = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])
        if skew.ndim == 3:
            square = np.einsum("ijt,jkt->ikt", skew, skew)
            return skew, square, np.eye(3)[:, :, None] + square
        square = skew @ skew
        return skew[:, :, None], square[:, :, None], (np.eye(3) + square)[:, :, None]


@dataclass(frozen=True, eq=False)
class SpatialBody:
    """A rigid body.

    Attributes:
        parent: number of the parent body, which comes before this one. Number 0 is the ground.
        place, turn: position (3,) [m] and rotation (3, 3) of its frame in the parent's at the reference pose.
        joints: joints in the order in which they move the body; empty if it is fixed to the parent.
        centre: centre of gravity (3,) [m], in the body's frame.
        inertia: about the centre of gravity (3, 3) [kg m^2], along the body's axes.
    """

    name: str
    parent: int
    place: Array
    turn: Array
    joints: tuple[SpatialJoint, ...]
    mass: float
    centre: Array
    inertia: Array

    @cached_property
    def is_turned(self) -> bool:
        """True if its frame is not along its parent's at the reference pose."""
        return not np.array_equal(self.turn, np.eye(3))


@dataclass(frozen=True, eq=False)
class SpatialPoint:
    """A point fixed to a body, at `offset` (3,) [m] in its frame."""

    body: int
    offset: Array


@dataclass(frozen=True, eq=False)
class SpatialClosure:
    """Constraint equations that close a loop.

    Attributes:
        kind: connect (two points coincide), weld (two frames coincide), joint or tendon (a polynomial coupling).
        points: points on both bodies that a connect or weld holds together.
        turn: rotation (3, 3) from the first body's frame to the second's that a weld holds.
        sums: of a coupling: factors of hinge and slide coordinates, by the joint's rate, in the dependent and in the
            independent sum; the second may be empty.
        references: reference values of both sums.
        polynomial: (5,) coefficients of dependent sum - reference in powers of independent sum - reference.
    """

    name: str
    kind: str
    points: tuple[SpatialPoint, ...] = ()
    turn: Array | None = None
    sums: tuple[dict[int, float], ...] = ()
    references: tuple[float, ...] = ()
    polynomial: tuple[float, ...] = ()

    @property
    def rows(self) -> int:
        """Number of scalar equations of the closure."""
        return {"connect": 3, "weld": 6}.get(self.kind, 1)


@dataclass(frozen=True, eq=False)
class SpatialTree:
    """A machine in space as a tree of bodies, cut open at its closures.

    Attributes:
        bodies: number 0 is the ground; parents before children.
        points: observed points by name.
        gravity: (3,) [m/s^2].
        start: coordinates (nq,) of the pose that assembly starts from: angles and lengths, quaternions of balls,
            position and quaternion of free joints.
        unmodelled: descriptions of what else acts in the model but is left out of forces.
    """

    bodies: tuple[SpatialBody, ...]
    closures: tuple[SpatialClosure, ...]
    points: dict[str, SpatialPoint]
    gravity: Array
    start: Array
    unmodelled: tuple[str, ...] = ()

    @cached_property
    def joints(self) -> tuple[SpatialJoint, ...]:
        """All joints, in the order of their coordinates."""
        return tuple(sorted((j for body in self.bodies for j in body.joints), key=lambda j: j.coordinate))

    @cached_property
    def freedom(self) -> int:
        """Number of rates of all joints, nv."""
        return sum(RATES[joint.kind] for joint in self.joints)

    @cached_property
    def joints_above(self) -> tuple[tuple[SpatialJoint, ...], ...]:
        """All joints that move a body, for each body from the ground outwards."""
        chains: list[tuple[SpatialJoint, ...]] = [()]
        for body in self.bodies[1:]:
            chains.append((*chains[body.parent], *body.joints))
        return tuple(chains)

    @cached_property
    def rows(self) -> dict[str, slice]:
        """Rows of each closure's equations, by its name."""
        ends = np.cumsum([0, *(closure.rows for closure in self.closures)]).tolist()
        return {c.name: slice(a, b) for c, a, b in zip(self.closures, ends, ends[1:], strict=False)}

    @cached_property
    def extent(self) -> float:
        """Longest arm [m] from a joint of a loop to a point that its body carries; angles are weighed by it."""
        carried: list[list[Array]] = [[] for _ in self.bodies]
        for body in self.bodies[1:]:
            carried[body.parent] += [body.place + body.turn @ joint.anchor for joint in body.joints] or [body.place]
        for closure in self.closures:
            for point in closure.points:
                carried[point.body].append(point.offset)
        centres = [
            [j.anchor for j in body.joints if j.kind != "slide" and j in self.loop_joints] for body in self.bodies
        ]
        arms = (p - c for around, points in zip(centres, carried, strict=True) for c in around for p in points)
        return max((float(np.linalg.norm(arm)) for arm in arms), default=0.0) or 1.0

    @cached_property
    def loop_joints(self) -> tuple[SpatialJoint, ...]:
        """Joints that closures depend on: on the path between a closure's two points, or in its sums."""
        rates = set[int]().union(*map(self._loop_rates, self.closures))
        return tuple(joint for joint in self.joints if joint.rate in rates)

    def _loop_rates(self, closure: SpatialClosure) -> set[int]:
        """Indices of the first rates of all joints that a closure depends on."""
        between = [{joint.rate for joint in self.joints_above[point.body]} for point in closure.points]
        return set.symmetric_difference(*between) if between else {rate for s in closure.sums for rate in s}

    def with_joint(self, other: SpatialJoint) -> SpatialTree:
        """Replace the joint of a name by one of the same kind; angles are weighed by the extent without it."""
        bodies = list(self.bodies)
        joints = tuple(other if one.name == other.name else one for one in bodies[other.body].joints)
        bodies[other.body] = replace(bodies[other.body], joints=joints)
        made = replace(self, bodies=tuple(bodies))
        # What a cached property has found is kept in this dictionary.
        vars(made).update(extent=self.extent, freedom=self.freedom, rows=self.rows)
        return made

    def closures_linked_to(self, joint: SpatialJoint) -> frozenset[str]:
        """Names of the closures that depend on a joint, directly or through further closures and joints."""
        rates, linked = {joint.rate}, set[str]()
        while found := [c for c in self.closures if c.name not in linked and rates & self._loop_rates(c)]:
            linked |= {closure.name for closure in found}
            rates = rates.union(*map(self._loop_rates, found))
        return frozenset(linked)


# -- coordinates and displacements -------------------------------------------------------------------------------------


def unit_displacements(tree: SpatialTree, joint: SpatialJoint, numbers: Mapping[str, int]) -> Array:
    """Displacement [m] by a unit change of each coordinate or rate of a joint: 1, the extent [m] for rotations.

    Args:
        numbers: `COORDINATES` or `RATES`, the number of each kind of joint.
    """
    straight = {"slide": 1, "free": 3}.get(joint.kind, 0)
    return np.array([1.0] * straight + [tree.extent] * (numbers[joint.kind] - straight))


def displace(tree: SpatialTree, coordinates: Array, displacement: Array) -> Array:
    """Coordinates (nq, T) after displacements (nv, T) of all joints; balls rotate in their own frame."""
    made = np.array(coordinates)
    for joint in tree.joints:
        q, v = joint.coordinate, joint.rate
        if joint.kind == "free":
            made[q : q + 3] += displacement[v : v + 3]
            q, v = q + 3, v + 3
        if joint.kind in ("free", "ball"):
            made[q : q + 4] = _rotate_quaternion(made[q : q + 4], displacement[v : v + 3])
        else:
            made[q] += displacement[v]
    return made


def _rotate_quaternion(quaternion: Array, displacement: Array) -> Array:
    """Unit quaternions (4, T) after rotation by vectors (3, T) [rad] in the body's frame."""
    angle = np.linalg.norm(displacement, axis=0)
    b, c = np.cos(0.5 * angle), 0.5 * np.sinc(angle / REVOLUTION) * displacement
    a, v = quaternion[0], quaternion[1:]
    made = np.concatenate([(a * b - (v * c).sum(axis=0))[None], a * c + b * v + np.cross(v, c, axis=0)])
    return np.asarray(made / np.linalg.norm(made, axis=0))
