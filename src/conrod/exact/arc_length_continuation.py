"""Pseudo-arc-length continuation of the curve of all configurations of a mechanism with one degree of freedom.

The crank angle is no coordinate of a free motion, because the crank stops at a dead centre while other links move. The
arc length s of the configuration curve, with lengths divided by the mechanism's size, is one everywhere: the tangent
dq/ds is the null vector of the joints' Jacobian (Keller's continuation; Allgower and Georg, Numerical Continuation
Methods).

Branches cross where the linkage gains a freedom, as a parallelogram with all links in line. The curve continues
straight: the prediction from before is extended beyond, where Newton iteration finds the branch with the same tangent.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.configuration_curve import ConfigurationCurve, without_whole_turns
from conrod.exact.motion import Array

FIRST_STEP, MIN_STEP, MAX_STEP = 0.01, 1e-9, 0.05  # arc length, in the curve's unit
ARC_END_TOLERANCE = (
    1e-14  # of arc length, in its unit: how well the place is known where a roller leaves an arc of its cam
)
ARC_LOOK_AHEAD = 1e-9  # arc length ahead of a point at which the next arcs are determined
LOOP_TOLERANCE = 1e-8  # distance, without unit, at which a curve that has returned passes its start
# A step is shortened if the second-order prediction is off by more, or the unit tangent changes by more.
PREDICTION_TOLERANCE, MAX_TANGENT_CHANGE = 1e-4, 0.1
# Nearer to a crossing of branches a point loses digits: it is stepped over at another distance.
MIN_SINGULAR_VALUE = 1e-4


@dataclass(frozen=True)
class CurvePoint:
    """A point of the configuration curve with its unit tangent and its curvature, each (1, 3 n)."""

    arc_length: float
    point: Array
    tangent: Array
    curvature: Array
    singular_value: float  # to a crossing of branches, see `CurveFrame`
    arcs: dict[str, int]  # those of cams that their rollers are on, from here on


class ArcLengthContinuation:
    """Predictor-corrector steps along a configuration curve."""

    def __init__(self, curve: ConfigurationCurve) -> None:
        self.curve = curve

    def start_point(self, direction: Array) -> CurvePoint:
        """Return the curve point of the start poses, with the tangent in the sense of a direction (1, 3 n).

        Raises:
            InvalidInput: branches cross there, so that the poses belong to no single one.
        """
        point = self.curve.start_point()
        place = self._curve_point(0.0, point, direction, self.curve.arcs(point))
        if place is None:
            raise InvalidInput(
                f"{self.curve.mechanism.name}: at the start poses branches of its motion cross; start beside them"
            )
        return self.onto_next_arcs(place)

    def _curve_point(
        self, arc_length: float, point: Array, direction: Array, arcs: dict[str, int]
    ) -> CurvePoint | None:
        """Return a point with its tangent; None so near to a crossing that the tangent is unknown."""
        with np.errstate(all="ignore"):
            frame = self.curve.with_arcs(arcs).frame(point, direction)
        if not np.isfinite(frame.tangent).all() or not frame.singular_value[0] >= MIN_SINGULAR_VALUE:
            return None
        return CurvePoint(arc_length, point, frame.tangent, frame.curvature, float(frame.singular_value[0]), arcs)

    def onto_next_arcs(self, place: CurvePoint) -> CurvePoint:
        """Return the point on the cam arcs that its rollers touch next."""
        arcs = self.curve.arcs(place.point + ARC_LOOK_AHEAD * place.tangent)
        if arcs == place.arcs:
            return place
        left = self._curve_point(place.arc_length, place.point, place.tangent, arcs)
        return place if left is None else left

    def points_after(self, point: CurvePoint, longest: float = MAX_STEP) -> Iterator[CurvePoint]:
        """Yield the points after a point, without end; a point lies wherever a roller reaches another arc of its cam.

        Args:
            longest: limit of the first step, in the curve's unit; later steps grow from it gradually.

        Raises:
            InvalidInput: the curve ends, or branches lie too close to each other.
        """
        step = min(FIRST_STEP, longest) * self.curve.unit
        while True:
            reached, miss = self._step(point, step)
            if reached is not None:
                yield reached
                point = self.onto_next_arcs(reached)
                grown = 0.9 * (PREDICTION_TOLERANCE / max(miss, 1e-300)) ** (1.0 / 3.0)
                longest = min(MAX_STEP, 1.5 * longest)
                step = min(longest * self.curve.unit, step * min(2.0, max(0.5, grown)))
            else:
                # Not a half: an even share could meet the same crossing again.
                step *= 0.37
                if step < MIN_STEP:
                    raise InvalidInput(too_close_message(self.curve.mechanism.name))

    def _step(self, point: CurvePoint, step: float) -> tuple[CurvePoint | None, float]:
        """Take a step of arc length, shortened to where a roller leaves its arc; with the prediction's error."""
        reached, miss = self._corrected_point(point, step)
        if reached is None or self.curve.arcs(reached.point) == point.arcs:
            return reached, miss
        # The roller has left its arc: bisect for the place, on the curve that the arc's full circle would give.
        low, high = 0.0, step
        while high - low > ARC_END_TOLERANCE * self.curve.unit:
            middle = 0.5 * (low + high)
            reached, miss = self._corrected_point(point, middle)
            if reached is None:
                return None, miss
            if self.curve.arcs(reached.point) == point.arcs:
                low = middle
            else:
                high = middle
        return self._corrected_point(point, high)

    def _corrected_point(self, here: CurvePoint, step: float) -> tuple[CurvePoint | None, float]:
        """Predict a point at a step and correct it; None if it fails, with the prediction's error."""
        guess = here.point + step * here.tangent + 0.5 * step**2 * here.curvature
        point = self.curve.with_arcs(here.arcs).correct_points(guess, here.tangent)
        if point is None:
            return None, np.inf
        miss = float(np.abs(point - guess).max())
        if miss > PREDICTION_TOLERANCE:
            return None, miss
        reached = self._curve_point(here.arc_length + step, point, here.tangent, here.arcs)
        if reached is None or np.linalg.norm(reached.tangent - here.tangent) > MAX_TANGENT_CHANGE:
            return None, miss
        return reached, miss


def too_close_message(name: str) -> str:
    """Error message for branches that come too close to each other to be distinguished."""
    return (
        f"{name}: branches of its motion come too close to each other to be distinguished, or it ends: change a length "
        "by a millionth, or make it exact"
    )


def passes_start(curve: ConfigurationCurve, start: CurvePoint, before: CurvePoint, after: CurvePoint) -> bool:
    """True if the curve passes its start, up to whole turns of bodies, between two neighbouring points."""
    near = [without_whole_turns(curve.mechanism, place.point - start.point) for place in (before, after)]
    ahead = [float(np.sum(n * start.tangent)) for n in near]
    width = after.arc_length - before.arc_length
    close = max(float(np.abs(n).max()) for n in near) <= 2.0 * width
    same_way = float(np.sum(after.tangent * start.tangent)) > 0.9
    if not (close and same_way and ahead[0] < 0.0 <= ahead[1]):
        return False
    # A near miss does not close the curve: gears without a common period pass the start closely, turn after turn.
    share = -ahead[0] / (ahead[1] - ahead[0])
    guess = before.point + share * (after.point - before.point)
    passed = curve.with_arcs(before.arcs).correct_points(guess, start.tangent)
    if passed is None:
        return False
    left = without_whole_turns(curve.mechanism, passed - start.point)
    left = left - np.sum(left * start.tangent) * start.tangent
    return float(np.abs(left).max()) <= LOOP_TOLERANCE
