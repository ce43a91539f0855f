"""All poses that a linkage passes, the crank's whole turn or what it reaches of one, and the limits of its input.

Where the crank cannot turn fully, its angle stops being a good parameter at its limits: the linkage moves there and the
crank does not. Poses are then followed by their own arc length (`conrod.exact.curve_walk`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.curve_walk import CurvePoint, CurveWalk
from conrod.exact.joint_curve import JointCurve, one_thread
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array

TURN = 2.0 * math.pi
DONE = 1e-8  # of Newton iteration: next to a change point rounding leaves more than the walk asks for
SHORT = 1e-7  # of arc length: how far before a change point the last pose lies
LONGEST = 200.0  # of arc length, in its unit
HALVINGS = 60
SAMPLES = 720  # of a full turn

End = Literal["limit", "change point", "none"]


def bisect(low: float, high: float, still: Callable[[float], bool]) -> float:
    """The place where a statement that holds at `low` stops holding on the way to `high`."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle in {low, high}:
            break
        low, high = (middle, high) if still(middle) else (low, middle)
    return 0.5 * (low + high)


@dataclass(frozen=True)
class CrankRange:
    """Crank angles that a linkage reaches.

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
        """True of a crank that turns fully."""
        return self.start_end == self.stop_end == "none"


@dataclass(frozen=True)
class Course:
    """Poses that a linkage passes.

    Attributes:
        curve: the curve of the poses where the parameter is its arc length [1], 0 at crank angle 0; None where the
            parameter is the crank angle [rad], as for a turn or a driver's span.
    """

    kinematics: Kinematics  # the mechanism's solver
    periodic: bool  # whether they are those of a whole turn, and of every other one too
    curve: JointCurve | None
    parameter: Array  # that the samples are taken at, (T,), growing; both ends of a turn are there
    samples: Array  # stacked poses (T, 3 n) [m, m, rad]
    tangents: Array  # their derivative by the parameter (T, 3 n)

    def poses(self, parameter: Array) -> Array:
        """Exact poses (T, 3 n) at parameters (T,) within those of the samples."""
        return self.kinematics.poses(parameter) if self.curve is None else self._near(self.curve, parameter)[0]

    def rates(self, parameter: Array) -> Array:
        """Derivative (T, 3 n) of the poses by the parameter, up to a positive factor."""
        if self.curve is None:
            return self.kinematics.derivatives(parameter, 1)[1]
        return self._near(self.curve, parameter)[1]

    def _near(self, curve: JointCurve, parameter: Array) -> tuple[Array, Array]:
        """Poses and their tangents (T, 3 n) at arc lengths (T,)."""
        nearest = np.abs(self.parameter[:, None] - parameter).argmin(axis=0)
        tangents = self.tangents[nearest] / curve.scale
        guess = self.samples[nearest] / curve.scale + (parameter - self.parameter[nearest])[:, None] * tangents
        with one_thread():
            points = curve.corrected(guess, tangents, DONE)
            if points is None:
                raise InvalidInput(f"{curve.mechanism.name}: its poses cannot be followed")
            return points * curve.scale, curve.frame(points, tangents).tangent * curve.scale

    def crank_angle(self, poses: Array) -> Array:
        """Crank angles (T,) [rad] of poses (T, 3 n)."""
        driver = self.kinematics.mechanism.driver
        return np.asarray(driver.sense * (poses[:, self.kinematics.crank_column] - driver.start))


def course_of(kinematics: Kinematics) -> Course:
    """All poses that the machine passes on its assembly branch: a turn, its driver's span, or all that it reaches."""
    span = kinematics.mechanism.driver.span
    if span is not None or kinematics.turns_fully:
        angles = np.linspace(*(span or (0.0, TURN)), SAMPLES + 1)
        return Course(kinematics, kinematics.repeats, None, angles, *kinematics.derivatives(angles, 1))
    return _whole_range(kinematics)[1]


def crank_range(kinematics: Kinematics) -> CrankRange:
    """Crank angles that are reached on the assembly branch of the start poses, whatever span the driver is given."""
    driver = kinematics.mechanism.driver
    free = kinematics
    if driver.span is not None:
        free = Kinematics(replace(kinematics.mechanism, driver=replace(driver, span=None)))
    elif kinematics.turns_fully:
        return CrankRange(0.0, TURN, "none", "none", tuple(float(angle) for angle in kinematics.change_angles))
    start_end, course, stop_end = _whole_range(free)
    if "none" in {start_end, stop_end}:
        return CrankRange(0.0, TURN, "none", "none")
    start, stop = (float(angle) for angle in course.crank_angle(course.samples[[0, -1]]))
    return CrankRange(start, stop, start_end, stop_end)


def _whole_range(kinematics: Kinematics) -> tuple[End, Course, End]:
    """Poses from the least to the greatest crank angle, no more than a turn either way, and what ends them."""
    curve = JointCurve(kinematics.mechanism)
    trace = _Trace(kinematics, curve)
    with one_thread():
        ahead, stop_end = trace.from_start(+1.0)
        behind, start_end = ([], stop_end) if stop_end == "none" else trace.from_start(-1.0)
    parameter = np.array([*(-place.along for place in behind[:0:-1]), *(place.along for place in ahead)])
    points = np.concatenate([place.point for place in (*behind[:0:-1], *ahead)])
    tangents = np.concatenate([*(-place.tangent for place in behind[:0:-1]), *(place.tangent for place in ahead)])
    course = Course(kinematics, False, curve, parameter, points * curve.scale, tangents * curve.scale)
    return start_end, course, stop_end


class _Trace:
    """Poses from the start to the end of the crank's range."""

    def __init__(self, kinematics: Kinematics, curve: JointCurve) -> None:
        self._kinematics, self._curve, self._walk = kinematics, curve, CurveWalk(curve)
        self._branch = float(kinematics.branch(kinematics.start)[0])

    def from_start(self, sense: float) -> tuple[list[CurvePoint], End]:
        """Places from the start on in a sense of the crank angle, and what ends them; after a whole turn nothing does.

        Raises:
            InvalidInput: branches of the motion cross at the start, or nothing ends it.
        """
        turn, driver = self._kinematics.crank_column, self._kinematics.mechanism.driver
        direction = np.zeros((1, len(self._curve.scale)))
        direction[0, turn] = sense * driver.sense
        places = [self._walk.first(direction)]
        try:
            for place in self._walk.steps(places[0]):
                here, end = places[-1], self._end_at(place.point, place.tangent, direction)
                if end != "none":
                    last = self._end(here, place.along - here.along, end, direction)
                    return [*places, *last], end
                places.append(place)
                if abs(place.point[0, turn] - places[0].point[0, turn]) >= TURN:
                    return places, "none"
                if place.along > LONGEST * self._curve.unit:
                    break
        except InvalidInput:
            return places, "change point"
        raise InvalidInput(f"{self._kinematics.mechanism.name}: the limits of its crank angle were not found")

    def _end_at(self, point: Array, tangent: Array, direction: Array) -> End:
        """The end of the crank's range, if it lies before a point: there it turns back, or is on another branch."""
        if not float(np.sum(tangent * direction)) > 0.0:
            return "limit"
        same = float(self._kinematics.branch(point * self._curve.scale)[0]) == self._branch
        return "none" if same else "change point"

    def _end(self, here: CurvePoint, step: float, end: End, direction: Array) -> list[CurvePoint]:
        """The last place before the end of the range, which is no further than a step."""
        curve = self._curve.on(here.arcs)

        def reached(step: float) -> tuple[Array, Array] | None:
            guess = here.point + step * here.tangent + 0.5 * step**2 * here.curvature
            point = curve.corrected(guess, here.tangent, DONE)
            return None if point is None else (point, curve.frame(point, here.tangent).tangent)

        def still(step: float) -> bool:
            there = reached(step)
            return there is not None and self._end_at(*there, direction) == "none"

        step = bisect(0.0, step, still)
        # Where two curves of poses cross, Newton's iteration has no one way to go: stop short of it.
        step = max(0.0, step - SHORT) if end == "change point" else step
        there = reached(step)
        if there is None or step == 0.0:
            return []
        return [replace(here, along=here.along + step, point=there[0], tangent=there[1])]
