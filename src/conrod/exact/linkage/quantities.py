"""Transmission and pressure angles of the driven links, with their extremes over all poses.

All classic quantities of a linkage together: those of a whole turn, and those at one crank angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.accelerations import PathParts, path_parts
from conrod.exact.linkage.centres import InstantCentre, KennedyLine, instant_centres, kennedy_lines
from conrod.exact.linkage.course import Course, CrankRange, course_of, crank_range
from conrod.exact.linkage.outputs import Output, outputs
from conrod.exact.linkage.points import linkage_points
from conrod.exact.linkage.polygon import Polygon, acceleration_polygon, velocity_polygon
from conrod.exact.linkage.state import LinkageState, link_numbers, linkage_state
from conrod.exact.motion import Array
from conrod.exact.transmission import Push, pushes

# An extreme is closed in upon by so many parts of its interval, so many times: to rounding of its value.
PARTS, TIMES = 16, 10


@dataclass(frozen=True)
class Extreme:
    """A value [rad] and the crank angle [rad] where it is taken."""

    value: float
    angle: float


@dataclass(frozen=True)
class TransmissionAngle:
    """The transmission angle of a driven link.

    Attributes:
        driven: the link.
        through: the rod, block or cam that pushes it.
        least, greatest: of the angle in [0, pi] between the line of the push and the normal of the path, over all poses
            (`conrod.exact.transmission.Push.angle`).
    """

    driven: str
    through: str
    least: Extreme
    greatest: Extreme

    @property
    def worst(self) -> Extreme:
        """The least acute transmission angle (Alt): at zero the linkage is locked."""
        other = Extreme(math.pi - self.greatest.value, self.greatest.angle)
        return min(self.least, other, key=lambda extreme: extreme.value)

    @property
    def greatest_pressure_angle(self) -> Extreme:
        """A right angle less the worst transmission angle."""
        return Extreme(0.5 * math.pi - self.worst.value, self.worst.angle)


def transmission_angles(course: Course) -> tuple[TransmissionAngle, ...]:
    """Of every driven link that is guided by the ground; empty where none is pushed by a rod, a block or a cam."""
    found = []
    samples = pushes(course.kinematics, course.samples)
    for k, push in enumerate(samples):
        angles = partial(_angle, course, k)
        least, greatest = _least(course, push.angle, angles, 1.0), _least(course, push.angle, angles, -1.0)
        found.append(TransmissionAngle(push.driven, push.through, least, greatest))
    return tuple(sorted(found, key=lambda angle: (angle.driven, angle.through)))


def pushes_at(kinematics: Kinematics, state: LinkageState) -> list[Push]:
    """The pushes in the pose of a state, by driven link; their arrays have one row."""
    return sorted(pushes(kinematics, state.derivatives[0]), key=lambda push: (push.driven, push.through))


def _angle(course: Course, k: int, parameter: Array) -> Array:
    return pushes(course.kinematics, course.poses(parameter))[k].angle


def _least(course: Course, samples: Array, at: Callable[[Array], Array], sign: float) -> Extreme:
    """The value that is least times a sign, from those at the samples and between them."""
    parameter, values = course.parameter, sign * samples
    k = int(values.argmin())
    low, high = float(parameter[max(k - 1, 0)]), float(parameter[min(k + 1, len(parameter) - 1)])
    if course.periodic and k in {0, len(parameter) - 1}:
        low, high = -float(parameter[1]), float(parameter[1])
    value, place = float(values[k]), float(parameter[k])
    for _ in range(TIMES):
        some = np.linspace(low, high, PARTS + 1)
        here = sign * at(some)
        j = int(here.argmin())
        if here[j] < value:
            value, place = float(here[j]), float(some[j])
        low, high = float(some[max(j - 1, 0)]), float(some[min(j + 1, PARTS)])
    angle = float(course.crank_angle(course.poses(np.array([place])))[0])
    return Extreme(sign * value, angle % (2.0 * math.pi) if course.periodic else angle)


@dataclass(frozen=True)
class TurnQuantities:
    """Quantities of a linkage over a turn, its driver's span, or all that it reaches.

    Attributes:
        numbers: of the links, by name; the ground is 1.
        mobility: degrees of freedom by Gruebler's count.
        crank_range: limits of the input.
        outputs: strokes, dead centres and time ratios of the links that are guided in the ground.
        transmission: transmission and pressure angles of those that are pushed by a rod, a block or a cam.
    """

    numbers: dict[str, int]
    mobility: int
    crank_range: CrankRange
    outputs: tuple[Output, ...]
    transmission: tuple[TransmissionAngle, ...]


@dataclass(frozen=True)
class PointQuantities:
    """Motion of a point where links meet, or that is observed.

    Attributes:
        name: its letter, or what it is called in the mechanism.
        links: that it is a point of.
        place: (2,) [m].
        velocity: (2,) [m/s].
        parts: of its acceleration, by its path.
    """

    name: str
    links: tuple[str, ...]
    place: Array
    velocity: Array
    parts: PathParts


@dataclass(frozen=True)
class InstantQuantities:
    """Quantities of a linkage at a crank angle.

    Attributes:
        state: motion of every link; its angular velocities and accelerations.
        points: motion of the pins between moving links, and of the observed points.
        pushes: how the driven links are pushed; their arrays have one row.
        centres: the instant centres, n (n - 1) / 2 of them.
        lines: how well Kennedy's theorem holds for every three links.
        velocities: the velocity polygon.
        accelerations: the acceleration polygon.
    """

    state: LinkageState
    points: tuple[PointQuantities, ...]
    pushes: tuple[Push, ...]
    centres: tuple[InstantCentre, ...]
    lines: tuple[KennedyLine, ...]
    velocities: Polygon
    accelerations: Polygon


def turn_quantities(kinematics: Kinematics) -> TurnQuantities:
    """Those of a turn.

    Raises:
        InvalidInput: the mechanism cannot be assembled at crank angle 0, or does not reach its driver's span.
    """
    mechanism, course = kinematics.mechanism, course_of(kinematics)
    return TurnQuantities(
        link_numbers(mechanism),
        mechanism.mobility,
        crank_range(kinematics),
        outputs(course),
        transmission_angles(course),
    )


def instant_quantities(
    kinematics: Kinematics, angle: float, speed: float, acceleration: float = 0.0
) -> InstantQuantities:
    """Those at a crank angle [rad], speed [rad/s] and angular acceleration [rad/s^2] of the crank.

    Raises:
        InvalidInput: the linkage does not reach the angle.
    """
    state = linkage_state(kinematics, angle, speed, acceleration)
    centres = instant_centres(state)
    return InstantQuantities(
        state,
        _points(state),
        tuple(pushes_at(kinematics, state)),
        centres,
        kennedy_lines(state, centres),
        velocity_polygon(state),
        acceleration_polygon(state),
    )


def _points(state: LinkageState) -> tuple[PointQuantities, ...]:
    found = []
    for point in linkage_points(state.mechanism).points:
        carrier = point.carriers[0]
        link = state.links[carrier.link]
        links = tuple(carrier.link for carrier in point.carriers)
        parts = path_parts(state, carrier.link, carrier.point)
        place, velocity = link.place(carrier.point), link.velocity_at(carrier.point)
        found.append(PointQuantities(point.name, links, place, velocity, parts))
    return tuple(found)
