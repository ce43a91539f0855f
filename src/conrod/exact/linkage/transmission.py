"""Transmission angles of driven links: how well a mechanism transmits force.

A transmission angle lies between the line along which a driven link is pushed (through both pins of a rod, across a
slot, or normal to a cam) and the normal to the path of the pushed point (Alt's definition; for a cam it is 90 degrees
minus the pressure angle). At zero the mechanism is locked.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from conrod.exact.joint_equations import pose_jet
from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.crank_range import SampledMotion
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, CamContact, Mechanism, Point, Prismatic, Revolute, joint_partner
from conrod.mechanism.units import REVOLUTION

# The interval around an extreme is divided into `SUBDIVISIONS`, `REFINEMENTS` times: its value is then exact to
# rounding.
SUBDIVISIONS, REFINEMENTS = 16, 10
SIGNS = (1.0, -1.0)  # factors of the angle whose minima are its least and its greatest value
RodEnd: TypeAlias = tuple[str, Point, Point, Point]  # the partner, its pin, the rod's own pin there, and its other one


@dataclass(frozen=True)
class Push:
    """Line of the force on a driven link and path of the pushed point, at T poses."""

    driven: str  # the link that is pushed; the ground guides it
    through: str  # the rod, the block or the cam that pushes it
    line: Array  # along which it is pushed, (T, 2) of any length
    path: Array  # direction in which the point that is pushed moves, (T, 2) of any length

    @property
    def angle(self) -> Array:
        """Transmission angle (T,) [rad] in [0, pi], between the line and the normal on the right of the path.

        For a rod that drives a rocker it lies between the rod and the line from the rocker's pivot to their pin, and
        passes smoothly through a right angle, the best value. Its sine is the share of the push along the path.
        """
        normal = np.column_stack([self.path[:, 1], -self.path[:, 0]])
        return np.asarray(np.arctan2(np.abs(self._inner(self.path)), self._inner(normal)))

    def _inner(self, other: Array) -> Array:
        """Cosine (T,) of the angle between the line and another vector (T, 2)."""
        inner = np.sum(self.line * other, axis=1)
        return np.asarray(inner / np.linalg.norm(self.line, axis=1) / np.linalg.norm(other, axis=1))


def pushes(kinematics: Kinematics, poses: Array) -> list[Push]:
    """Pushes on all driven links that the ground guides, by a cam, rod or block, at poses (T, 3 n)."""
    found = [*_cam_pushes(kinematics, poses), *_rod_pushes(kinematics.mechanism, poses)]
    return sorted(found, key=lambda push: (push.driven, push.through))


@dataclass(frozen=True)
class Extreme:
    """An extreme value [rad] and the crank angle [rad] where it occurs."""

    value: float
    angle: float


@dataclass(frozen=True)
class TransmissionAngle:
    """Extremes of the transmission angle of one driven link.

    Attributes:
        least, greatest: extremes over all poses of the angle in [0, pi] between the line of the push and the normal of
            the path (`Push.angle`).
    """

    driven: str  # the link
    through: str  # the rod, block or cam that pushes it
    least: Extreme
    greatest: Extreme

    @property
    def worst(self) -> Extreme:
        """Smallest acute transmission angle (Alt); at zero the linkage is locked."""
        other = Extreme(math.pi - self.greatest.value, self.greatest.angle)
        return min(self.least, other, key=lambda extreme: extreme.value)

    @property
    def greatest_pressure_angle(self) -> Extreme:
        """Largest pressure angle: a right angle less the worst transmission angle."""
        return Extreme(0.5 * math.pi - self.worst.value, self.worst.angle)


def transmission_angles(course: SampledMotion) -> tuple[TransmissionAngle, ...]:
    """Transmission angles of all driven links that the ground guides; empty if none is pushed."""
    samples = pushes(course.kinematics, course.samples)
    if not samples:
        return ()
    extremes = _row_minima(course, np.array([sign * push.angle for push in samples for sign in SIGNS]))
    return tuple(
        TransmissionAngle(push.driven, push.through, least, Extreme(-greatest.value, greatest.angle))
        for push, least, greatest in zip(samples, extremes[::2], extremes[1::2], strict=True)
    )


def _row_minima(course: SampledMotion, values: Array) -> list[Extreme]:
    """Minimum of each row of values (E, T), refined between the samples; each push has a row for either sign.

    All are refined together, because the cost of solving for poses hardly depends on their number.
    """
    angles, rows, last = course.angles, np.arange(len(values)), values.shape[1] - 1
    k = values.argmin(axis=1)
    low, high = angles[np.maximum(k - 1, 0)], angles[np.minimum(k + 1, last)]
    if course.kinematics.repeats:
        around = (k == 0) | (k == last)
        low, high = np.where(around, -angles[1], low), np.where(around, angles[1], high)
    value, place = values[rows, k], angles[k]
    for _ in range(REFINEMENTS):
        some = np.linspace(low, high, SUBDIVISIONS + 1, axis=1)
        found = [
            push.angle.reshape(some.shape) for push in pushes(course.kinematics, course.kinematics.poses(some.ravel()))
        ]
        here = np.array([SIGNS[e % 2] * found[e // 2][e] for e in rows])
        j = here.argmin(axis=1)
        less = here[rows, j] < value
        value, place = np.where(less, here[rows, j], value), np.where(less, some[rows, j], place)
        low, high = some[rows, np.maximum(j - 1, 0)], some[rows, np.minimum(j + 1, SUBDIVISIONS)]
    place = place % REVOLUTION if course.kinematics.repeats else place
    return [Extreme(*extreme) for extreme in zip(value.tolist(), place.tolist(), strict=True)]


def _cam_pushes(kinematics: Kinematics, poses: Array) -> Iterator[Push]:
    """Pushes of cams on followers that the ground guides."""
    mechanism = kinematics.mechanism
    row = 0
    for joint in mechanism.joints:
        if isinstance(joint, CamContact) and mechanism.guide(joint.b) is not None:
            column = 3 * mechanism.body_index[joint.b]
            line = kinematics.jacobian(poses)[:, row, column : column + 2]
            yield Push(joint.b, joint.a, line, _path_direction(mechanism, poses, joint.b, joint.b, joint.roller_centre))
        row += kinematics.equations_of(joint)


def _rod_pushes(mechanism: Mechanism, poses: Array) -> Iterator[Push]:
    """Pushes of rods and blocks on links that the ground guides."""
    away = _joints_from_crank(mechanism)
    for rod in mechanism.bodies:
        ends = _rod_ends(mechanism, rod.name)
        # Of two rockers on a rod, the one farther from the crank is driven.
        farthest = max((away[driven] for driven, *_ in ends), default=0)
        for driven, point, own, other in ends:
            # A rod that is reached through a link does not push that link, but is moved by it.
            if away[driven] >= max(farthest, away[rod.name]) and mechanism.guide(driven) is not None:
                line = _point_place(mechanism, poses, rod.name, own) - _point_place(mechanism, poses, rod.name, other)
                yield Push(driven, rod.name, line, _path_direction(mechanism, poses, driven, driven, point))
        yield from _block_pushes(mechanism, rod.name, away, poses)


def _block_pushes(mechanism: Mechanism, block: str, away: Mapping[str, int], poses: Array) -> Iterator[Push]:
    """Push of a block that turns on one link and slides in another: across the slide, through its pin."""
    joints = mechanism.joints_on(block)
    slide = next((j for j in joints if isinstance(j, Prismatic) and GROUND not in (j.a, j.b)), None)
    pin = next((j for j in joints if isinstance(j, Revolute) and GROUND not in (j.a, j.b)), None)
    if slide is None or pin is None or len(joints) != 2:
        return
    driven = max(joint_partner(slide, block)[0], joint_partner(pin, block)[0], key=away.__getitem__)
    if driven != mechanism.crank and mechanism.guide(driven) is not None:
        turn = poses[:, 3 * mechanism.body_index[slide.a] + 2] + (slide.direction + 0.5 * math.pi)
        path = _path_direction(mechanism, poses, driven, block, joint_partner(pin, block)[2])
        yield Push(driven, block, np.column_stack([np.cos(turn), np.sin(turn)]), path)


def _joints_from_crank(mechanism: Mechanism) -> dict[str, int]:
    """Number of joints from the crank to each link, through moving links."""
    away, front = {mechanism.crank: 0}, [mechanism.crank]
    for link in front:
        for joint in mechanism.joints:
            other = joint.b if joint.a == link else joint.a if joint.b == link else GROUND
            if other != GROUND and other not in away:
                away[other] = away[link] + 1
                front.append(other)
    return {body.name: away.get(body.name, len(mechanism.bodies)) for body in mechanism.bodies}


def _rod_ends(mechanism: Mechanism, name: str) -> list[RodEnd]:
    """Driven ends of a body with two pins and no other joint; empty for other bodies."""
    joints = mechanism.joints_on(name)
    ends = [joint_partner(joint, name) for joint in joints if isinstance(joint, Revolute)]
    if len(joints) != 2 or len(ends) != 2 or GROUND in (ends[0][0], ends[1][0]):
        return []
    return [
        (partner, point, own, other)
        for (partner, point, own), (_, _, other) in zip(ends, ends[::-1], strict=True)
        if partner != mechanism.crank
    ]


def _path_direction(mechanism: Mechanism, poses: Array, driven: str, body: str, point: Point) -> Array:
    """Direction (T, 2) of a guided body's velocity at one of its points."""
    joint = mechanism.guide(driven)
    if isinstance(joint, Prismatic):
        direction = np.array([math.cos(joint.direction), math.sin(joint.direction)])
        return np.broadcast_to(direction, (len(poses), 2))
    assert joint is not None
    arm = _point_place(mechanism, poses, body, point) - np.asarray(joint_partner(joint, driven)[1])
    return np.column_stack([-arm[:, 1], arm[:, 0]])


def _point_place(mechanism: Mechanism, poses: Array, name: str, point: Point) -> Array:
    """Position (T, 2) [m] of a body's point."""
    x, y = pose_jet(mechanism, [poses], name).point(point)
    return np.column_stack([np.broadcast_to(c.coefficients[0], len(poses)) for c in (x, y)])
