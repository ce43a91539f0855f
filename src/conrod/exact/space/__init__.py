"""A machine in space as plain numbers: bodies, joints, closures and observed points. It knows no engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from conrod.exact.motion import Array

# Numbers that a joint's place in the coordinates takes, and rates that it has.
COORDINATES = {"hinge": 1, "slide": 1, "ball": 4, "free": 7}
RATES = {"hinge": 1, "slide": 1, "ball": 3, "free": 6}


@dataclass(frozen=True, eq=False)
class SpatialJoint:
    """A joint between a body and its parent.

    Attributes:
        kind: hinge, slide, ball or free.
        coordinate, rate: where its numbers begin among all coordinates and all rates.
        anchor, axis: (3,) in the body's frame; a hinge turns positively about its axis.
        reference: coordinate at which the body is where its frame has it.
        armature, damping, stiffness, spring: of its own load, spring's rest coordinate last.
        range: that its coordinate may go through; None where it has no limit.
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
        """Of its coordinate: rad or m."""
        return "m" if self.kind == "slide" else "rad"

    @property
    def coordinates(self) -> slice:
        """Its places among all coordinates."""
        return slice(self.coordinate, self.coordinate + COORDINATES[self.kind])

    @property
    def rates(self) -> slice:
        """Its places among all rates."""
        return slice(self.rate, self.rate + RATES[self.kind])


@dataclass(frozen=True, eq=False)
class SpatialBody:
    """A rigid body.

    Attributes:
        parent: number of the body that it hangs on; it comes before this one. Number 0 is the ground.
        place, turn: of its frame in the parent's at the reference pose, (3,) [m] and (3, 3).
        joints: in the order in which they move it; none where it is fixed to the parent.
        centre: of gravity (3,) [m], in the body's frame.
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


@dataclass(frozen=True, eq=False)
class SpatialPoint:
    """A point fixed to a body, at `offset` (3,) [m] in its frame."""

    body: int
    offset: Array


@dataclass(frozen=True, eq=False)
class Closure:
    """Constraint equations that close a loop: `rows` of them.

    Attributes:
        kind: connect (two points are one), weld (two frames are one), joint or tendon (a polynomial coupling).
        points: of a connect or weld, on both bodies.
        turn: of a weld, from the first body's frame to the second's (3, 3).
        sums: of a coupling: dependent and independent sum of the coordinates of hinges and slides, factors by the
            joint's rate; the second may be empty.
        references: of both sums.
        polynomial: (5,) the dependent sum less its reference, in the independent one less its.
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
        """Number of its scalar equations."""
        return {"connect": 3, "weld": 6}.get(self.kind, 1)


@dataclass(frozen=True, eq=False)
class SpatialTree:
    """A machine in space, cut open at its closures.

    Attributes:
        bodies: number 0 is the ground; parents before children.
        points: observed points by name.
        gravity: (3,) [m/s^2].
        start: coordinates (nq,) of the pose that it is assembled from: angles and lengths, quaternions of balls, place
            and quaternion of free joints.
        unmodelled: what else acts in the model, in words, that forces are not computed with.
    """

    bodies: tuple[SpatialBody, ...]
    closures: tuple[Closure, ...]
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
        """Number of rates of all joints."""
        return sum(RATES[joint.kind] for joint in self.joints)

    @cached_property
    def above(self) -> tuple[tuple[SpatialJoint, ...], ...]:
        """For each body all joints that move it."""
        chains: list[tuple[SpatialJoint, ...]] = [()]
        for body in self.bodies[1:]:
            chains.append((*chains[body.parent], *body.joints))
        return tuple(chains)

    @cached_property
    def rows(self) -> dict[str, slice]:
        """Places of each closure's equations."""
        ends = np.cumsum([0, *(closure.rows for closure in self.closures)]).tolist()
        return {c.name: slice(a, b) for c, a, b in zip(self.closures, ends, ends[1:], strict=False)}

    @cached_property
    def extent(self) -> float:
        """Length [m] that angles are weighed against: the longest from where a loop's body turns to what it carries."""
        carried: list[list[Array]] = [[] for _ in self.bodies]
        for body in self.bodies[1:]:
            carried[body.parent] += [body.place + body.turn @ joint.anchor for joint in body.joints] or [body.place]
        for closure in self.closures:
            for point in closure.points:
                carried[point.body].append(point.offset)
        centres = [[j.anchor for j in body.joints if j.kind != "slide" and j in self.looped] for body in self.bodies]
        arms = (p - c for around, points in zip(centres, carried, strict=True) for c in around for p in points)
        return max((float(np.linalg.norm(arm)) for arm in arms), default=0.0) or 1.0

    @cached_property
    def looped(self) -> tuple[SpatialJoint, ...]:
        """Joints that closures are sensitive to: between the two points of one, or in its sums."""
        rates = set[int]()
        for closure in self.closures:
            between = [{joint.rate for joint in self.above[point.body]} for point in closure.points]
            rates |= set.symmetric_difference(*between) if between else {rate for s in closure.sums for rate in s}
        return tuple(joint for joint in self.joints if joint.rate in rates)


# -- coordinates, and movements by joint rates -------------------------------------------------------------------------


def lengths(tree: SpatialTree, joint: SpatialJoint, numbers: Mapping[str, int]) -> Array:
    """For each of a joint's coordinates or rates: 1 of a length, the extent [m] of a turn."""
    straight = {"slide": 1, "free": 3}.get(joint.kind, 0)
    return np.array([1.0] * straight + [tree.extent] * (numbers[joint.kind] - straight))


def moved(tree: SpatialTree, coordinates: Array, way: Array) -> Array:
    """Coordinates (nq, T) after a movement (nv, T) of all joints, balls by the turn that it is in their own frame."""
    made = np.array(coordinates)
    for joint in tree.joints:
        q, v = joint.coordinate, joint.rate
        if joint.kind == "free":
            made[q : q + 3] += way[v : v + 3]
            q, v = q + 3, v + 3
        if joint.kind in ("free", "ball"):
            made[q : q + 4] = _turned_by(made[q : q + 4], way[v : v + 3])
        else:
            made[q] += way[v]
    return made


def _turned_by(quaternion: Array, way: Array) -> Array:
    """Unit quaternions (4, T) after turns by vectors (3, T) in their own frame."""
    angle = np.linalg.norm(way, axis=0)
    b, c = np.cos(0.5 * angle), 0.5 * np.sinc(angle / (2.0 * np.pi)) * way
    a, v = quaternion[0], quaternion[1:]
    made = np.concatenate([(a * b - (v * c).sum(axis=0))[None], a * c + b * v + np.cross(v, c, axis=0)])
    return np.asarray(made / np.linalg.norm(made, axis=0))
