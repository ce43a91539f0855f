"""All poses that a linkage passes in a turn or a span, and the limits of its input.

At its limits the crank's angle stops being a good parameter: the linkage moves there and the crank does not. They are
found by the poses' own arc length (`conrod.exact.curve_walk`).
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
    """Poses that a machine passes in its turn, or its driver's span."""

    kinematics: Kinematics  # the mechanism's solver
    angles: Array  # crank angles (T,) [rad] of the samples, growing; both ends of a turn are there
    samples: Array  # stacked poses (T, 3 n) [m, m, rad]
    slopes: Array  # their derivative by the crank angle (T, 3 n)


def course_of(kinematics: Kinematics) -> Course:
    """All poses that the machine passes; raises InvalidInput where its crank neither turns fully nor has a span."""
    angles = np.linspace(*kinematics.span, SAMPLES + 1)
    return Course(kinematics, angles, *kinematics.derivatives(angles, 1))


def crank_range(kinematics: Kinematics) -> CrankRange:
    """Crank angles that are reached on the assembly branch of the start poses, whatever span the driver is given."""
    driver = kinematics.mechanism.driver
    free = kinematics
    if driver.span is not None:
        free = Kinematics(replace(kinematics.mechanism, driver=replace(driver, span=None)))
    elif kinematics.turns_fully:
        return CrankRange(0.0, TURN, "none", "none", tuple(float(angle) for angle in kinematics.change_angles))
    trace = _Trace(free)
    with one_thread():
        stop, stop_end = trace.from_start(+1.0)
        start, start_end = (stop, stop_end) if stop_end == "none" else trace.from_start(-1.0)
    return (
        CrankRange(0.0, TURN, "none", "none") if start_end == "none" else CrankRange(start, stop, start_end, stop_end)
    )


class _Trace:
    """The way from the start to the end of the crank's range."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._kinematics, self._curve = kinematics, JointCurve(kinematics.mechanism)
        self._branch = float(kinematics.branch(kinematics.start)[0])

    def from_start(self, sense: float) -> tuple[float, End]:
        """The crank angle [rad] that is reached in a sense, and what ends it; after a whole turn nothing does.

        Raises:
            InvalidInput: branches of the motion cross at the start, or nothing ends it.
        """
        turn, driver, walk = self._kinematics.crank_column, self._kinematics.mechanism.driver, CurveWalk(self._curve)
        direction = np.zeros((1, len(self._curve.scale)))
        direction[0, turn] = sense * driver.sense
        here = first = walk.first(direction)

        def angle(point: Array) -> float:
            return float(driver.sense * (point[0, turn] - driver.start))

        try:
            for place in walk.steps(first):
                end = self._end_at(place.point, place.tangent, direction)
                if end != "none":
                    return angle(self._end(here, place.along - here.along, end, direction)), end
                here = place
                if abs(here.point[0, turn] - first.point[0, turn]) >= TURN:
                    return angle(here.point), "none"
                if here.along > LONGEST * self._curve.unit:
                    break
        except InvalidInput:
            return angle(here.point), "change point"
        raise InvalidInput(f"{self._kinematics.mechanism.name}: the limits of its crank angle were not found")

    def _end_at(self, point: Array, tangent: Array, direction: Array) -> End:
        """The end of the crank's range, if it lies before a point: there it turns back, or is on another branch."""
        if not float(np.sum(tangent * direction)) > 0.0:
            return "limit"
        same = float(self._kinematics.branch(point * self._curve.scale)[0]) == self._branch
        return "none" if same else "change point"

    def _end(self, here: CurvePoint, step: float, end: End, direction: Array) -> Array:
        """The last point (1, 3 n) before the end of the range, which is no further than a step."""
        curve = self._curve.on(here.arcs)

        def reached(step: float) -> Array | None:
            guess = here.point + step * here.tangent + 0.5 * step**2 * here.curvature
            return curve.corrected(guess, here.tangent, DONE)

        def still(step: float) -> bool:
            if (point := reached(step)) is None:
                return False
            return self._end_at(point, curve.frame(point, here.tangent).tangent, direction) == "none"

        step = bisect(0.0, step, still)
        # Where two curves of poses cross, Newton's iteration has no one way to go: stop short of it.
        point = reached(max(0.0, step - SHORT) if end == "change point" else step)
        return here.point if point is None else point
