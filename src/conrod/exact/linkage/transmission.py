"""Transmission angles of driven links: how well a mechanism passes force on."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from conrod.exact.joint_equations import pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.course import Course
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mechanism, Point, Prismatic, Revolute, beside

SAMPLES = 3600
# An extreme is closed in upon by so many parts of its interval, so many times: to rounding of its value.
PARTS, TIMES = 16, 10


def least_transmission_angle(kinematics: Kinematics) -> float | None:
    """Least transmission angle [rad] over a turn or the driver's span; None where nothing pushes a link.

    The angle between the line along which a driven link is pushed (through both pins of a rod, across a slot, or normal
    to a cam) and the normal to the path of the point that is pushed (Alt's definition; for a cam it is 90 degrees
    minus the pressure angle). At zero the mechanism is locked.
    """
    poses = kinematics.poses(kinematics.angles(SAMPLES))
    sines = [float(push.share.min()) for push in pushes(kinematics, poses)]
    return math.asin(min([1.0, *sines])) if sines else None


@dataclass(frozen=True)
class Push:
    """The push on a driven link, at T poses."""

    driven: str  # the link that is pushed; the ground guides it
    through: str  # the rod, the block or the cam that pushes it
    line: Array  # along which it is pushed, (T, 2) of any length
    path: Array  # direction in which the point that is pushed moves, (T, 2) of any length

    @property
    def share(self) -> Array:
        """Share (T,) of the push along the path: the sine of the transmission angle."""
        return np.abs(self._inner(self.path))

    @property
    def angle(self) -> Array:
        """Angle (T,) [rad] in [0, pi] between the line and the normal on the right of the path.

        Of a rod that drives a rocker, between the rod and the line from the rocker's pivot to their pin: it passes
        through a right angle, the best value, smoothly, and its sine is `share`.
        """
        normal = np.column_stack([self.path[:, 1], -self.path[:, 0]])
        return np.asarray(np.arctan2(self.share, self._inner(normal)))

    def _inner(self, other: Array) -> Array:
        inner = np.sum(self.line * other, axis=1)
        return np.asarray(inner / np.linalg.norm(self.line, axis=1) / np.linalg.norm(other, axis=1))


def pushes(kinematics: Kinematics, poses: Array) -> list[Push]:
    """Every driven link that is guided by the ground, and pushed by a cam, a rod or a block, at poses (T, 3 n)."""
    return [*_cam_pushes(kinematics, poses), *_rod_pushes(kinematics.mechanism, poses)]


@dataclass(frozen=True)
class Extreme:
    """A value [rad] and the crank angle [rad] where it is taken."""

    value: float
    angle: float


@dataclass(frozen=True)
class TransmissionAngle:
    """The transmission angle of a driven link.

    Attributes:
        least, greatest: of the angle in [0, pi] between the line of the push and the normal of the path, over all poses
            (`Push.angle`).
    """

    driven: str  # the link
    through: str  # the rod, block or cam that pushes it
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


def _cam_pushes(kinematics: Kinematics, poses: Array) -> Iterator[Push]:
    mechanism = kinematics.mechanism
    row = 0
    for joint in mechanism.joints:
        if joint in mechanism.cam_contacts:
            column = 3 * mechanism.body_index[joint.b]
            path = _path(mechanism, poses, joint.b, _place(mechanism, poses, joint.b, joint.roller_centre))
            if path is not None:
                yield Push(joint.b, joint.a, kinematics.jacobian(poses)[:, row, column : column + 2], path)
        row += kinematics.equations_of(joint)


def _rod_pushes(mechanism: Mechanism, poses: Array) -> Iterator[Push]:
    away = _joints_from_crank(mechanism)
    for rod in mechanism.bodies:
        ends = _rod_ends(mechanism, rod.name)
        # Of two rockers on a rod, the one farther from the crank is driven.
        farthest = max((away[driven] for driven, *_ in ends), default=0)
        for driven, point, own, other in ends:
            # A rod that is reached by way of a link does not push that one: it is itself moved by it.
            if away[driven] < farthest or away[driven] < away[rod.name]:
                continue
            path = _path(mechanism, poses, driven, _place(mechanism, poses, driven, point))
            if path is not None:
                line = _place(mechanism, poses, rod.name, own) - _place(mechanism, poses, rod.name, other)
                yield Push(driven, rod.name, line, path)
        yield from _block_pushes(mechanism, poses, rod.name, away)


def _block_pushes(mechanism: Mechanism, poses: Array, block: str, away: Mapping[str, int]) -> Iterator[Push]:
    """A block on a pin of one link that slides in another: it pushes at right angles to the slide, through its pin."""
    joints = [j for j in mechanism.joints_on(block) if GROUND not in (j.a, j.b)]
    slide = next((j for j in joints if isinstance(j, Prismatic)), None)
    pin = next((j for j in joints if isinstance(j, Revolute)), None)
    if slide is None or pin is None or len(joints) != 2 or len(mechanism.joints_on(block)) != 2:
        return
    links = (beside(slide, block)[0], beside(pin, block)[0])
    driven = max(links, key=away.__getitem__)
    place = _place(mechanism, poses, block, beside(pin, block)[2])
    path = None if driven == mechanism.crank else _path(mechanism, poses, driven, place)
    if path is not None:
        across = slide.direction + 0.5 * math.pi
        turn = poses[:, 3 * mechanism.body_index[slide.a] + 2] + across
        yield Push(driven, block, np.column_stack([np.cos(turn), np.sin(turn)]), path)


def _joints_from_crank(mechanism: Mechanism) -> dict[str, int]:
    """Number of joints from the crank to each link, by way of moving links."""
    away, front = {mechanism.crank: 0}, [mechanism.crank]
    for link in front:
        for joint in mechanism.joints:
            other = joint.b if joint.a == link else joint.a if joint.b == link else GROUND
            if other != GROUND and other not in away:
                away[other] = away[link] + 1
                front.append(other)
    return {body.name: away.get(body.name, len(mechanism.bodies)) for body in mechanism.bodies}


def _rod_ends(mechanism: Mechanism, name: str) -> list[tuple[str, Point, Point, Point]]:
    """Of a body with two pins and nothing else: each driven partner, its pin, and the rod's own pin and other pin."""
    joints = mechanism.joints_on(name)
    ends = [beside(joint, name) for joint in joints if isinstance(joint, Revolute)]
    if len(joints) != 2 or len(ends) != 2 or GROUND in (ends[0][0], ends[1][0]):
        return []
    return [
        (partner, point, own, other)
        for (partner, point, own), (_, _, other) in zip(ends, ends[::-1], strict=True)
        if partner != mechanism.crank
    ]


def _path(mechanism: Mechanism, poses: Array, name: str, place: Array) -> Array | None:
    """Direction (T, 2) in which the point of a body at a place (T, 2) [m] moves; None without a guide in the ground."""
    for joint in mechanism.joints_on(name):
        if GROUND not in (joint.a, joint.b):
            continue
        if isinstance(joint, Prismatic):
            direction = np.array([math.cos(joint.direction), math.sin(joint.direction)])
            return np.broadcast_to(direction, (len(poses), 2))
        if isinstance(joint, Revolute):
            arm = place - np.asarray(beside(joint, name)[1])
            return np.column_stack([-arm[:, 1], arm[:, 0]])
    return None


def _place(mechanism: Mechanism, poses: Array, name: str, point: Point) -> Array:
    x, y = pose_jets(mechanism, [poses])[name].point(point)
    return np.column_stack([np.broadcast_to(c.coefficients[0], len(poses)) for c in (x, y)])
