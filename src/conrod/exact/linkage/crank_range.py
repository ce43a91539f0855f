"""Sampled motion of a linkage over its input's range, and the limits of that range.

At a limit the crank angle is no regular parameter: the linkage moves and the crank does not. Limits are found by the
arc length of the configuration curve (`conrod.exact.arc_length_continuation`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.arc_length_continuation import ArcLengthContinuation, CurvePoint
from conrod.exact.configuration_curve import ConfigurationCurve, single_blas_thread
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.units import REVOLUTION

CORRECTION_TOLERANCE = 1e-8  # last Newton step; next to a change point rounding exceeds the tracking's tolerance
CHANGE_POINT_MARGIN = 1e-7  # arc length between the last pose and a change point
MAX_ARC_LENGTH = 200.0  # arc length searched for a limit, in the curve's unit
MAX_HALVINGS = 60
SAMPLES_PER_REVOLUTION = 720

RangeEnd = Literal["limit", "change point", "none"]


def bisect(low: float, high: float, holds: Callable[[float], bool]) -> float:
    """Bisect for the place between `low`, where a condition holds, and `high` at which it stops holding."""
    for _ in range(MAX_HALVINGS):
        middle = 0.5 * (low + high)
        if middle in {low, high}:
            break
        low, high = (middle, high) if holds(middle) else (low, middle)
    return 0.5 * (low + high)


@dataclass(frozen=True)
class CrankRange:
    """Range of crank angles that a linkage reaches.

    Attributes:
        start, stop: least and greatest crank angle [rad] reached from angle 0 without changing the assembly branch; 0
            and 2 pi if the crank turns fully.
        start_end, stop_end: reason for the limit: "limit", where the crank has to turn back; "change point", where two
            branches meet, so that the motion may continue on either; "none" if the crank turns fully.
        change_points: crank angles [rad] where a crank that turns fully passes smoothly through a meeting of branches.
    """

    start: float
    stop: float
    start_end: RangeEnd
    stop_end: RangeEnd
    change_points: tuple[float, ...] = ()

    @property
    def full(self) -> bool:
        """True if the crank turns fully."""
        return self.start_end == self.stop_end == "none"


@dataclass(frozen=True)
class SampledMotion:
    """Poses of a machine at evenly spaced crank angles over one revolution or its driver's span."""

    kinematics: Kinematics  # the mechanism's solver
    angles: Array  # crank angles (T,) [rad] of the samples, growing; both ends of a turn are there
    samples: Array  # stacked poses (T, 3 n) [m, m, rad]
    derivatives: Array  # their derivative by the crank angle (T, 3 n)


def sample_motion(kinematics: Kinematics) -> SampledMotion:
    """Sample a machine's motion; raises InvalidInput if its crank neither turns fully nor has a span."""
    angles = np.linspace(*kinematics.span, SAMPLES_PER_REVOLUTION + 1)
    return SampledMotion(kinematics, angles, *kinematics.derivatives(angles, 1))


def crank_range(kinematics: Kinematics) -> CrankRange:
    """Range of crank angles on the assembly branch of the start poses, regardless of the driver's span."""
    driver = kinematics.mechanism.driver
    free = kinematics
    if driver.span is not None:
        free = Kinematics(replace(kinematics.mechanism, driver=replace(driver, span=None)))
    elif kinematics.turns_fully:
        return CrankRange(0.0, REVOLUTION, "none", "none", tuple(float(angle) for angle in kinematics.change_angles))
    trace = _CrankRangeSearch(free)
    with single_blas_thread():
        stop, stop_end = trace.limit_in_sense(+1.0)
        start, start_end = (stop, stop_end) if stop_end == "none" else trace.limit_in_sense(-1.0)
    return (
        CrankRange(0.0, REVOLUTION, "none", "none")
        if start_end == "none"
        else CrankRange(start, stop, start_end, stop_end)
    )


class _CrankRangeSearch:
    """Search for the limits of the crank's range along the configuration curve."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._kinematics, self._curve = kinematics, ConfigurationCurve(kinematics.mechanism)
        self._branch = float(kinematics.branch(kinematics.start)[0])

    def limit_in_sense(self, sense: float) -> tuple[float, RangeEnd]:
        """Return the crank angle [rad] reached in a sense, +1 or -1, and the reason for the limit; "none" after a turn.

        Raises:
            InvalidInput: branches of the motion cross at the start, or no limit is found.
        """
        turn, driver, continuation = (
            self._kinematics.crank_column,
            self._kinematics.mechanism.driver,
            ArcLengthContinuation(self._curve),
        )
        direction = np.zeros((1, len(self._curve.scale)))
        direction[0, turn] = sense * driver.sense
        here = first = continuation.start_point(direction)

        def angle(point: Array) -> float:
            return float(driver.sense * (point[0, turn] - driver.start))

        try:
            for place in continuation.points_after(first):
                end = self._end_before(place.point, place.tangent, direction)
                if end != "none":
                    return angle(self._last_point(here, place.arc_length - here.arc_length, end, direction)), end
                here = place
                if abs(here.point[0, turn] - first.point[0, turn]) >= REVOLUTION:
                    return angle(here.point), "none"
                if here.arc_length > MAX_ARC_LENGTH * self._curve.unit:
                    break
        except InvalidInput:
            return angle(here.point), "change point"
        raise InvalidInput(f"{self._kinematics.mechanism.name}: the limits of its crank angle were not found")

    def _end_before(self, point: Array, tangent: Array, direction: Array) -> RangeEnd:
        """Return the limit between the start and a point at which the crank has reversed or the branch has changed."""
        if not float(np.sum(tangent * direction)) > 0.0:
            return "limit"
        same = float(self._kinematics.branch(point * self._curve.scale)[0]) == self._branch
        return "none" if same else "change point"

    def _last_point(self, here: CurvePoint, step: float, end: RangeEnd, direction: Array) -> Array:
        """Last curve point (1, 3 n) before a limit of the crank, at most one step from a given point."""
        curve = self._curve.with_arcs(here.arcs)

        def point_at(step: float) -> Array | None:
            guess = here.point + step * here.tangent + 0.5 * step**2 * here.curvature
            return curve.correct_points(guess, here.tangent, CORRECTION_TOLERANCE)

        def within_range(step: float) -> bool:
            if (point := point_at(step)) is None:
                return False
            return self._end_before(point, curve.frame(point, here.tangent).tangent, direction) == "none"

        step = bisect(0.0, step, within_range)
        # Where two branches cross, Newton iteration has no unique solution: stop short of it.
        point = point_at(max(0.0, step - CHANGE_POINT_MARGIN) if end == "change point" else step)
        return here.point if point is None else point
