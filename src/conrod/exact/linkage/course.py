"""Poses of a linkage followed by their own arc length (Keller's pseudo-arclength continuation).

Where the crank cannot turn fully, its angle stops being a good parameter at its limits: the linkage moves there and the
crank does not. Arc length goes through the limits as through any other pose.

All poses that a linkage passes, the crank's whole turn or what it reaches of one, and the limits of its input.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array

TURN = 2.0 * math.pi
STEP, LEAST_STEP = 0.05, 1e-9  # of arc length, lengths in units of the mechanism's size, angles in radians
SMOOTH = 0.98  # the least cosine between the tangents at both ends of a step
SHORT = 1e-7
LONGEST = 200.0
NEWTON_STEPS, NEWTON_DONE = 12, 1e-8  # it converges quadratically: the square is left
HALVINGS = 60

End = Literal["limit", "change point", "none"]
Place: TypeAlias = tuple[float, Array, Array]  # arc length, poses (3 n,), their tangent (3 n,)


def whole_range(kinematics: Kinematics) -> tuple[End, list[Place], End]:
    """Places from the least to the greatest crank angle, no more than a turn either way, and what ends them."""
    first = tangents(kinematics, kinematics.start, None)
    # Towards growing crank angles.
    first *= np.sign(_crank_rate(kinematics, first)[0])
    ahead, stop_end = _trace(kinematics, kinematics.start[0], first[0], +1.0)
    if stop_end == "none":
        return "none", ahead, "none"
    behind, start_end = _trace(kinematics, kinematics.start[0], first[0], -1.0)
    return start_end, [*reversed(behind), (0.0, kinematics.start[0], first[0]), *ahead], stop_end


def crank_angle(kinematics: Kinematics, poses: Array) -> Array:
    """Crank angles (T,) [rad] of poses (T, 3 n)."""
    driver, crank = kinematics.mechanism.driver, kinematics.mechanism.body_index[kinematics.mechanism.crank]
    return np.asarray(driver.sense * (poses[:, 3 * crank + 2] - driver.start))


def bisect(low: float, high: float, still: Callable[[float], bool]) -> float:
    """Where a statement that holds at `low` stops holding on the way to `high`."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle in {low, high}:
            break
        low, high = (middle, high) if still(middle) else (low, middle)
    return 0.5 * (low + high)


def _trace(kinematics: Kinematics, start: Array, tangent: Array, sense: float) -> tuple[list[Place], End]:
    """Places (arc length, poses, tangent) from a start to the end of the crank's range, and what ends it.

    After a whole turn nothing does.
    """
    places: list[Place] = []
    length, poses, along, step = 0.0, start, tangent, STEP
    scale, branch = _scale(kinematics), _branch(kinematics, start[None])

    def reached(step: float) -> tuple[Array, Array]:
        there = corrected(kinematics, (poses + sense * step * along)[None], along[None])
        return there[0], tangents(kinematics, there, along[None])[0]

    def end_at(step: float) -> End | None:
        try:
            there, slope = reached(step)
        except InvalidInput:
            return None
        if float(along / scale @ (slope / scale)) < SMOOTH:
            return None
        if _crank_rate(kinematics, slope[None])[0] <= 0.0:
            return "limit"
        return "none" if _branch(kinematics, there[None]) == branch else "change point"

    while abs(length) < LONGEST:
        end = end_at(step)
        if end is None and step > LEAST_STEP:
            step *= 0.5  # the step was too long
            continue
        if end is None:
            return places, "change point"
        if end != "none":
            step = bisect(0.0, step, lambda step: end_at(step) == "none")
            # Where two curves of poses cross, Newton's iteration has no one way to go: stop short of it.
            step = max(0.0, step - SHORT) if end == "change point" else step
        poses, along = reached(step)
        length += sense * step
        places.append((length, poses, along))
        if end != "none" or abs(crank_angle(kinematics, poses[None])[0]) >= TURN:
            return places, end
        step = min(STEP, 2.0 * step)
    raise InvalidInput(f"{kinematics.mechanism.name}: the limits of its crank angle were not found")


def _scale(kinematics: Kinematics) -> Array:
    return np.tile([kinematics.size, kinematics.size, 1.0], len(kinematics.mechanism.bodies))


def tangents(kinematics: Kinematics, poses: Array, towards: Array | None) -> Array:
    """Tangents (T, 3 n) of the curve of poses, of length 1 in units of the mechanism's size, the way of others."""
    scale = _scale(kinematics)
    joints = (kinematics.jacobian(poses) * scale)[:, :-1]
    along = np.linalg.svd(joints)[2][:, -1]
    if towards is not None:
        along = along * np.where(np.sum(along * towards / scale, axis=1) < 0.0, -1.0, 1.0)[:, None]
    return np.asarray(along * scale)


def _branch(kinematics: Kinematics, poses: Array) -> float:
    """Sign of the determinant of all equations; it changes where two branches meet, and at a limit of the crank."""
    return float(np.sign(np.linalg.det(kinematics.jacobian(poses) * _scale(kinematics)))[0])


def _crank_rate(kinematics: Kinematics, tangents: Array) -> Array:
    """How fast the crank angle grows along tangents (T, 3 n)."""
    crank = kinematics.mechanism.body_index[kinematics.mechanism.crank]
    return np.asarray(kinematics.mechanism.driver.sense * tangents[:, 3 * crank + 2])


def corrected(kinematics: Kinematics, guess: Array, along: Array) -> Array:
    """Poses (T, 3 n) that fit the joints, at the same place along given tangents as a guess.

    Raises:
        InvalidInput: Newton's iteration does not converge.
    """
    scale = _scale(kinematics)
    poses = guess.copy()
    for _ in range(NEWTON_STEPS):
        matrix = kinematics.jacobian(poses) * scale
        matrix[:, -1] = along / scale
        right = kinematics.residual([poses], np.zeros(len(poses)))
        right[:, -1] = np.sum(along * (poses - guess) / scale**2, axis=1)
        try:
            step = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            break
        poses = poses - step * scale
        if np.abs(step).max() <= NEWTON_DONE:
            return poses
    raise InvalidInput(f"{kinematics.mechanism.name}: its poses cannot be followed")


SAMPLES = 720  # of a full turn


@dataclass(frozen=True)
class CrankRange:
    """What the crank can do.

    Attributes:
        start, stop: least and greatest crank angle [rad] that is reached from angle 0 without changing the assembly
            branch; 0 and 2 pi if the crank turns fully.
        start_end, stop_end: what ends it there: "limit", where the crank has to turn back; "change point", where two
            branches meet, and the motion may go on on either; "none" if the crank turns fully.
        change_points: crank angles [rad] that a crank which turns fully passes smoothly where two branches meet.
    """

    start: float
    stop: float
    start_end: End
    stop_end: End
    change_points: tuple[float, ...] = ()

    @property
    def full(self) -> bool:
        """Whether the crank turns fully."""
        return self.start_end == self.stop_end == "none"


@dataclass(frozen=True)
class Course:
    """Poses that a linkage passes.

    Attributes:
        kinematics: the mechanism's solver.
        periodic: whether they are those of a whole turn, and of every other one too.
        by_angle: whether the parameter is the crank angle [rad], as for a turn or a driver's span; else it is the arc
            length of the poses [1], 0 at crank angle 0.
        parameter: that the samples are taken at, (T,), growing; both ends of a turn are there.
        samples: stacked poses (T, 3 n) [m, m, rad].
        tangents: their derivative by the parameter (T, 3 n).
    """

    kinematics: Kinematics
    periodic: bool
    by_angle: bool
    parameter: Array
    samples: Array
    tangents: Array

    def poses(self, parameter: Array) -> Array:
        """Exact poses (T, 3 n) at parameters (T,) within those of the samples."""
        if self.by_angle:
            return self.kinematics.poses(parameter)
        near = np.abs(self.parameter[:, None] - parameter).argmin(axis=0)
        way = (parameter - self.parameter[near])[:, None]
        guess = self.samples[near] + way * self.tangents[near]
        return corrected(self.kinematics, guess, self.tangents[near])

    def rates(self, parameter: Array) -> Array:
        """Derivative (T, 3 n) of the poses by the parameter, up to a positive factor."""
        if self.by_angle:
            return self.kinematics.derivatives(parameter, 1)[1]
        near = np.abs(self.parameter[:, None] - parameter).argmin(axis=0)
        return tangents(self.kinematics, self.poses(parameter), self.tangents[near])

    def crank_angle(self, poses: Array) -> Array:
        """Crank angles (T,) [rad] of poses (T, 3 n)."""
        return crank_angle(self.kinematics, poses)


def course_of(kinematics: Kinematics) -> Course:
    """All poses that the machine passes on its assembly branch: a turn, its driver's span, or all that it reaches.

    Raises:
        InvalidInput: the mechanism cannot be assembled at crank angle 0, or does not reach its driver's span.
    """
    span = kinematics.mechanism.driver.span
    if span is not None or kinematics.turns_fully:
        angles = np.linspace(*(span or (0.0, TURN)), SAMPLES + 1)
        return Course(kinematics, kinematics.repeats, True, angles, *kinematics.derivatives(angles, 1))
    columns = (np.array(column) for column in zip(*whole_range(kinematics)[1], strict=True))
    return Course(kinematics, False, False, *columns)


def crank_range(kinematics: Kinematics) -> CrankRange:
    """What the crank can do on the assembly branch of the start poses, whatever span its driver is given.

    Raises:
        InvalidInput: the mechanism cannot be assembled at crank angle 0.
    """
    driver = kinematics.mechanism.driver
    free = kinematics
    if driver.span is not None:
        free = Kinematics(replace(kinematics.mechanism, driver=replace(driver, span=None)))
    elif kinematics.turns_fully:
        return CrankRange(0.0, TURN, "none", "none", tuple(float(angle) for angle in kinematics.change_angles))
    start_end, places, stop_end = whole_range(free)
    if "none" in {start_end, stop_end}:
        return CrankRange(0.0, TURN, "none", "none")
    start, stop = (float(a) for a in crank_angle(free, np.array([places[0][1], places[-1][1]])))
    return CrankRange(start, stop, start_end, stop_end)
