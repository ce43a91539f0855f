"""Classic quantities of a linkage: those of a whole turn, and the motion of all links at one crank angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.course import CrankRange, course_of, crank_range
from conrod.exact.linkage.outputs import Output, outputs
from conrod.exact.linkage.transmission import TransmissionAngle, transmission_angles
from conrod.exact.motion import Array, Motion


@dataclass(frozen=True)
class TurnQuantities:
    """Quantities of a linkage over a turn, its driver's span, or all that it reaches.

    Attributes:
        transmission: transmission and pressure angles of those that are pushed by a rod, a block or a cam.
    """

    crank_range: CrankRange  # limits of the input
    outputs: tuple[Output, ...]  # strokes, dead centres and time ratios of the links that are guided in the ground
    transmission: tuple[TransmissionAngle, ...]


@dataclass(frozen=True)
class LinkMotion:
    """Motion of one link; each array is (3,)."""

    link: str  # its name
    pose: Array  # place of its frame's origin and turn [m, m, rad]
    rate: Array  # of the pose [m/s, m/s, rad/s]
    acceleration: Array  # of the pose [m/s^2, m/s^2, rad/s^2]


@dataclass(frozen=True)
class InstantQuantities:
    """Motion of a linkage at a crank angle."""

    angle: float  # of the crank [rad]
    speed: float  # of the crank [rad/s]
    links: tuple[LinkMotion, ...]  # that move
    points: Motion  # of the observed points; one row


def turn_quantities(kinematics: Kinematics) -> TurnQuantities:
    """Those of a turn."""
    course = course_of(kinematics)
    return TurnQuantities(crank_range(kinematics), outputs(course), transmission_angles(course))


def instant_quantities(kinematics: Kinematics, angle: float, speed: float) -> InstantQuantities:
    """Those at a crank angle [rad] and a constant speed [rad/s] of the crank."""
    at = np.array([angle])
    in_time = [d.reshape(-1, 3) * speed**k for k, d in enumerate(kinematics.derivatives(at, 2))]
    links = [
        LinkMotion(body.name, *(rows[i] for rows in in_time)) for i, body in enumerate(kinematics.mechanism.bodies)
    ]
    return InstantQuantities(angle, speed, tuple(links), kinematics.motion(at, speed))
