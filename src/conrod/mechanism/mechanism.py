"""The declarative description of a planar mechanism, from which every reference and every engine model is made.

Coordinates: each moving body has a pose (x, y, phi), the position [m] of its frame's origin and its rotation [rad],
counter-clockwise positive, in the document's frame. The ground's pose is (0, 0, 0).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

from conrod.errors import InvalidInput, Named
from conrod.mechanism.cam_law import Profile
from conrod.mechanism.loads import Load
from conrod.mechanism.units import check_number

GROUND = "ground"
RADIUS_RANGE = (1e-9, 1e9)  # [m], of rolling wheels
MASS_RANGE = (1e-9, 1e12)  # [kg]
INERTIA_RANGE = (1e-18, 1e24)  # [kg m^2]
MAX_SPAN = 1e3  # [rad]

Point: TypeAlias = tuple[float, float]  # [m], in the frame of a body
Pose: TypeAlias = tuple[float, float, float]  # x [m], y [m], phi [rad]


@dataclass(frozen=True)
class Body:
    """A rigid link."""

    name: str
    mass: float  # [kg]
    inertia: float  # [kg m^2], about the centre of gravity
    centre_of_gravity: Point = (0.0, 0.0)

    def __post_init__(self) -> None:
        # Engines abort the interpreter, or compute nonsense, on invalid masses.
        check_number(f"mass of {self.name}", self.mass, *MASS_RANGE, "kg")
        check_number(f"inertia of {self.name}", self.inertia, *INERTIA_RANGE, "kg m²")


@dataclass(frozen=True)
class Revolute:
    """A pin: `point_a` of body `a` and `point_b` of body `b` coincide."""

    name: str
    a: str
    b: str
    point_a: Point
    point_b: Point


@dataclass(frozen=True)
class Prismatic:
    """A slide: `point_b` of `b` stays on the line through `point_a` of `a`, and `b` does not turn against `a`."""

    name: str
    a: str
    b: str
    point_a: Point
    point_b: Point
    direction: float  # [rad], of the line, in the frame of `a`
    angle: float = 0.0  # [rad], phi of `b` minus phi of `a`


@dataclass(frozen=True)
class CamContact:
    """A roller of body `b` rests on the cam profile of body `a`."""

    name: str
    a: str
    b: str
    profile: Profile  # in the frame of `a`
    roller_centre: Point  # in the frame of `b`
    roller_radius: float  # [m]

    def __post_init__(self) -> None:
        made_for = getattr(self.profile, "roller_radius", self.roller_radius)
        if made_for != self.roller_radius:
            raise InvalidInput(
                f"roller_radius = {self.roller_radius:g} m: the cam's profile is made for a roller of {made_for:g} m"
            )


@dataclass(frozen=True)
class Rolling:
    """Two circles that roll on each other without slip: a pair of gears, or a wheel on a round track.

    Other joints hold the centres at the distance |radius_a + radius_b|. With the direction alpha of the line from the
    centre on `a` to that on `b`, what rolls off is radius_a (phi_a - alpha) + radius_b (phi_b - alpha) = offset: turns
    count against the line of centres, so it may stand still or go round with a carrier.

    A circle that holds the other inside it (a ring gear, a concave track) has a negative radius.
    """

    name: str
    a: str
    b: str
    point_a: Point  # the centres
    point_b: Point
    radius_a: float  # [m]
    radius_b: float  # [m]
    offset: float = 0.0  # [m], up to whole turns of the line of centres

    def __post_init__(self) -> None:
        for radius in (self.radius_a, self.radius_b):
            check_number(f"radius of {self.name}", abs(radius), *RADIUS_RANGE, "m")
        largest = max((self.radius_a, self.radius_b), key=abs)
        if self.radius_a + self.radius_b == 0.0 or (min(self.radius_a, self.radius_b) < 0.0 < largest):
            raise InvalidInput(
                f"{self.name}: radii {self.radius_a:g} m and {self.radius_b:g} m; the negative one, of the circle that "
                "holds the other, must be the larger"
            )
        if max(self.radius_a, self.radius_b) < 0.0:
            raise InvalidInput(f"{self.name}: of two circles that roll on each other, one at most holds the other")

    @property
    def distance(self) -> float:
        """Distance between the centres [m]."""
        return abs(self.radius_a + self.radius_b)


@dataclass(frozen=True)
class Rack:
    """A wheel of body `a` that rolls without slip on a straight line of body `b`: a rack, or a flat track.

    Other joints hold the wheel's centre on the left of the line, one radius from it. With its displacement s along the
    line, what rolls off is s + radius (phi_a - phi_b) = offset.
    """

    name: str
    a: str
    b: str
    point_a: Point  # the wheel's centre
    point_b: Point  # on the line
    radius: float  # [m]
    direction: float  # [rad], of the line, in the frame of `b`
    offset: float = 0.0  # [m]

    def __post_init__(self) -> None:
        check_number(f"radius of {self.name}", self.radius, *RADIUS_RANGE, "m")


LowerPair: TypeAlias = Revolute | Prismatic
Mesh: TypeAlias = Rolling | Rack
HigherPair: TypeAlias = CamContact | Mesh
Joint: TypeAlias = LowerPair | HigherPair


@dataclass(frozen=True)
class Driver:
    """Drive of a revolute joint, with phi_b - phi_a = start + sense x crank angle.

    Attributes:
        span: first and last crank angle [rad] of the single pass of an input that cannot turn fully; None for one that
            turns.
    """

    joint: str
    sense: int = 1  # +1: the crank angle counts counter-clockwise, -1: clockwise
    start: float = 0.0  # [rad]
    span: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.span is None:
            return
        for angle in self.span:
            check_number(f"driver {self.joint}: an end of its span", angle, -MAX_SPAN, MAX_SPAN, "rad")
        if not self.span[0] <= 0.0 <= self.span[1] or self.span[0] == self.span[1]:
            first, last = map(math.degrees, self.span)
            raise InvalidInput(
                f"driver {self.joint}: from {first:.6g} to {last:.6g} deg: it must grow, and hold the crank angle 0, "
                "at which the bodies' poses are given"
            )


@dataclass(frozen=True)
class ObservedPoint:
    """A point of a body whose motion is compared."""

    name: str
    body: str
    point: Point = (0.0, 0.0)


@dataclass(frozen=True)
class ConstantForce:
    """A force of constant direction at the centre of gravity of a body."""

    body: str
    force: tuple[float, float]  # [N]


@dataclass(frozen=True)
class Mechanism:
    """A planar mechanism with one driven crank.

    Attributes:
        forces: constant forces.
        loads: springs, dampers, friction, forces and torques that follow a law. A crank at a prescribed angle moves
            alike with and without them.
    """

    name: str
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    driver: Driver
    poses: Mapping[str, Pose]  # approximate pose of each body at crank angle 0; picks the assembly branch
    observed: tuple[ObservedPoint, ...]
    gravity: tuple[float, float] = (0.0, 0.0)  # acceleration of free fall [m/s^2], in the document's frame
    forces: tuple[ConstantForce, ...] = field(default=())
    loads: tuple[Load, ...] = ()

    @cached_property
    def body_index(self) -> dict[str, int]:
        """Index of each moving body in a stacked pose vector."""
        return Named({body.name: i for i, body in enumerate(self.bodies)}, "body")

    def body(self, name: str) -> Body:
        """Body by its name; UnknownName, a KeyError, for the ground or an unknown name."""
        return self.bodies[self.body_index[name]]

    @cached_property
    def constant_forces(self) -> dict[str, tuple[float, float]]:
        """Sum of the constant forces [N] on each body that has any."""
        found: dict[str, tuple[float, float]] = {}
        for one in self.forces:
            x, y = found.get(one.body, (0.0, 0.0))
            found[one.body] = (x + one.force[0], y + one.force[1])
        return found

    def constant_force_on(self, body: str) -> tuple[float, float]:
        """Sum of the constant forces [N] on a body."""
        return self.constant_forces.get(body, (0.0, 0.0))

    def joints_on(self, body: str) -> list[Joint]:
        """All joints of a body."""
        return [joint for joint in self.joints if body in (joint.a, joint.b)]

    def guide(self, body: str) -> LowerPair | None:
        """The pin or slide that connects a body to the ground; None if it has none."""
        pairs = (joint for joint in self.joints_on(body) if isinstance(joint, LowerPair))
        return next((joint for joint in pairs if GROUND in (joint.a, joint.b)), None)

    @cached_property
    def driven_joint(self) -> Revolute:
        """The revolute joint that the driver turns."""
        joint = next(joint for joint in self.joints if joint.name == self.driver.joint)
        if not isinstance(joint, Revolute) or joint.a != GROUND:
            raise TypeError(f"driver of {self.name}: {joint.name!r} must be a revolute joint from the ground")
        return joint

    @property
    def crank(self) -> str:
        """Name of the driven body."""
        return self.driven_joint.b

    def crank_turn(self, angle: float) -> float:
        """Rotation phi [rad] of the crank's body at a crank angle [rad]."""
        return self.driver.start + self.driver.sense * angle

    @property
    def cam_contacts(self) -> tuple[CamContact, ...]:
        """All cam contacts."""
        return tuple(joint for joint in self.joints if isinstance(joint, CamContact))

    @property
    def meshes(self) -> tuple[Mesh, ...]:
        """All rolling pairs."""
        return tuple(joint for joint in self.joints if isinstance(joint, Mesh))

    @property
    def mobility(self) -> int:
        """Degrees of freedom by Gruebler's count, M = 3 (n - 1) - 2 f1 - f2 (document 004, equation (1)).

        A rolling pair counts as a higher pair, because other joints hold its centres apart.
        """
        higher_pairs = sum(isinstance(joint, HigherPair) for joint in self.joints)
        lower_pairs = len(self.joints) - higher_pairs
        return 3 * len(self.bodies) - 2 * lower_pairs - higher_pairs


def joint_partner(joint: LowerPair, body: str) -> tuple[str, Point, Point]:
    """The body that a joint connects to a given one, the joint's point on it, and that on the given body [m]."""
    return (joint.a, joint.point_a, joint.point_b) if joint.b == body else (joint.b, joint.point_b, joint.point_a)


def pin_points(mechanism: Mechanism, body: str) -> list[Point]:
    """Pins on a body, as points in the body's frame [m]."""
    return [joint_partner(joint, body)[2] for joint in mechanism.joints_on(body) if isinstance(joint, Revolute)]


def to_world(pose: Pose, point: Point) -> Point:
    """Position (x, y) [m] of a body's point in the document's frame."""
    x, y, phi = pose
    c, s = math.cos(phi), math.sin(phi)
    return (x + c * point[0] - s * point[1], y + s * point[0] + c * point[1])
