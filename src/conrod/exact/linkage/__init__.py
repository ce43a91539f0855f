"""All classic quantities of a linkage together: those of a whole turn, and those at one crank angle."""

from __future__ import annotations

from dataclasses import dataclass

from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.centres import InstantCentre, instant_centres
from conrod.exact.linkage.course import CrankRange, course_of, crank_range
from conrod.exact.linkage.outputs import Output, outputs
from conrod.exact.linkage.points import linkage_points
from conrod.exact.linkage.polygon import PathParts, Polygon, acceleration_polygon, path_parts, velocity_polygon
from conrod.exact.linkage.state import LinkageState, link_numbers, linkage_state
from conrod.exact.linkage.transmission import Push, TransmissionAngle, pushes, transmission_angles
from conrod.exact.motion import Array


@dataclass(frozen=True)
class TurnQuantities:
    """Quantities of a linkage over a turn, its driver's span, or all that it reaches.

    Attributes:
        transmission: transmission and pressure angles of those that are pushed by a rod, a block or a cam.
    """

    numbers: dict[str, int]  # of the links, by name; the ground is 1
    mobility: int  # degrees of freedom by Gruebler's count
    crank_range: CrankRange  # limits of the input
    outputs: tuple[Output, ...]  # strokes, dead centres and time ratios of the links that are guided in the ground
    transmission: tuple[TransmissionAngle, ...]


@dataclass(frozen=True)
class PointQuantities:
    """Motion of a point where links meet, or that is observed."""

    name: str  # its letter, or what it is called in the mechanism
    links: tuple[str, ...]  # that it is a point of
    place: Array  # (2,) [m]
    velocity: Array  # (2,) [m/s]
    parts: PathParts  # of its acceleration, by its path


@dataclass(frozen=True)
class InstantQuantities:
    """Quantities of a linkage at a crank angle."""

    state: LinkageState  # motion of every link; its angular velocities and accelerations
    points: tuple[PointQuantities, ...]  # motion of the pins between moving links, and of the observed points
    pushes: tuple[Push, ...]  # how the driven links are pushed; their arrays have one row
    centres: tuple[InstantCentre, ...]  # the instant centres, n (n - 1) / 2 of them
    velocities: Polygon  # the velocity polygon
    accelerations: Polygon  # the acceleration polygon


def turn_quantities(kinematics: Kinematics) -> TurnQuantities:
    """Those of a turn."""
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
    """Those at a crank angle [rad], speed [rad/s] and angular acceleration [rad/s^2] of the crank."""
    state = linkage_state(kinematics, angle, speed, acceleration)
    return InstantQuantities(
        state,
        _points(state),
        tuple(sorted(pushes(kinematics, state.derivatives[0]), key=lambda push: (push.driven, push.through))),
        instant_centres(state),
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
