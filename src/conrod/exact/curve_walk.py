"""The curve of all configurations of a mechanism with one degree of freedom, by its arc length.

A crank angle is no coordinate of a free motion where the crank stops at a dead centre while the other links go on. The
arc length of the curve of configurations (lengths against the mechanism's size, so that it has no unit) always is one:
its tangent is the null vector of the joints' Jacobian.

Where the linkage gains a freedom (all links of a parallelogram in line), branches cross. The curve goes straight on:
the prediction from before is continued beyond, and Newton iteration finds the branch with the same tangent there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.joint_curve import JointCurve, turned_alike
from conrod.exact.motion import Array

FIRST_STEP, LEAST_STEP, LONGEST_STEP = 0.01, 1e-9, 0.05  # of arc length, in its unit
JOINT = 1e-14  # of arc length, in its unit: how well the place is known where a roller leaves an arc of its cam
BESIDE = 1e-9  # of arc length: how far ahead a place is asked for its arc
CLOSED = 1e-8  # without unit: how far a curve that has come back may pass its start
# A predictor of second order that misses by more than this is shortened; one whose tangent turns by more has strayed.
MISS, TURN = 1e-4, 0.1
# A place nearer to a crossing of branches than this has lost digits to it: it is stepped over at another distance.
CROSSING = 1e-4


@dataclass(frozen=True)
class CurvePoint:
    """A point of the curve, its unit tangent and its curvature, each (1, 3 n), and about how far along it lies."""

    along: float
    point: Array
    tangent: Array
    curvature: Array
    nearness: float  # to a crossing of branches, see `Frame`
    arcs: dict[str, int]  # those of cams that their rollers are on, from here on


class CurveWalk:
    """Places along the curve, one after the other."""

    def __init__(self, curve: JointCurve) -> None:
        self.curve = curve

    def first(self, direction: Array) -> CurvePoint:
        """The place of the start poses, with the tangent in the sense of a direction (1, 3 n).

        Raises:
            InvalidInput: branches cross there, so that the poses belong to none.
        """
        point = self.curve.start()
        place = self._place(0.0, point, direction, self.curve.arcs(point))
        if place is None:
            raise InvalidInput(
                f"{self.curve.mechanism.name}: at the start poses branches of its motion cross; start beside them"
            )
        return self.leaving(place)

    def _place(self, along: float, point: Array, direction: Array, arcs: dict[str, int]) -> CurvePoint | None:
        """The place of a point; None where branches cross, or so near to that that its tangent is unknown."""
        with np.errstate(all="ignore"):
            frame = self.curve.on(arcs).frame(point, direction)
        if not np.isfinite(frame.tangent).all() or not frame.nearness[0] >= CROSSING:
            return None
        return CurvePoint(along, point, frame.tangent, frame.curvature, float(frame.nearness[0]), arcs)

    def leaving(self, place: CurvePoint) -> CurvePoint:
        """The place on the arcs of cams that lie ahead of it."""
        arcs = self.curve.arcs(place.point + BESIDE * place.tangent)
        if arcs == place.arcs:
            return place
        left = self._place(place.along, place.point, place.tangent, arcs)
        return place if left is None else left

    def steps(self, here: CurvePoint, longest: float = LONGEST_STEP) -> Iterator[CurvePoint]:
        """Places after one, without end; where a roller comes upon another arc of its cam there is always one.

        Args:
            longest: the first step at most, in the curve's unit; later ones grow from it little by little.

        Raises:
            InvalidInput: the curve ends, or branches lie too close to each other.
        """
        step = min(FIRST_STEP, longest) * self.curve.unit
        while True:
            reached, miss = self._try(here, step)
            if reached is not None:
                yield reached
                here = self.leaving(reached)
                grown = 0.9 * (MISS / max(miss, 1e-300)) ** (1.0 / 3.0)
                longest = min(LONGEST_STEP, 1.5 * longest)
                step = min(longest * self.curve.unit, step * min(2.0, max(0.5, grown)))
            else:
                # Not a half: an even share could meet the same crossing again.
                step *= 0.37
                if step < LEAST_STEP:
                    raise InvalidInput(too_close(self.curve.mechanism.name))

    def _try(self, here: CurvePoint, step: float) -> tuple[CurvePoint | None, float]:
        reached, miss = self._at(here, step)
        if reached is None or self.curve.arcs(reached.point) == here.arcs:
            return reached, miss
        # The roller has left its arc: where, by halving, on the curve that the arc's circle would give.
        low, high = 0.0, step
        while high - low > JOINT * self.curve.unit:
            middle = 0.5 * (low + high)
            reached, miss = self._at(here, middle)
            if reached is None:
                return None, miss
            if self.curve.arcs(reached.point) == here.arcs:
                low = middle
            else:
                high = middle
        return self._at(here, high)

    def _at(self, here: CurvePoint, step: float) -> tuple[CurvePoint | None, float]:
        guess = here.point + step * here.tangent + 0.5 * step**2 * here.curvature
        point = self.curve.on(here.arcs).corrected(guess, here.tangent)
        if point is None:
            return None, np.inf
        miss = float(np.abs(point - guess).max())
        if miss > MISS:
            return None, miss
        reached = self._place(here.along + step, point, here.tangent, here.arcs)
        if reached is None or np.linalg.norm(reached.tangent - here.tangent) > TURN:
            return None, miss
        return reached, miss


def too_close(name: str) -> str:
    """Message of a walk that ends."""
    return (
        f"{name}: branches of its motion come too close to each other to be distinguished, or it ends: change a length "
        "by a millionth, or make it exact"
    )


def closes(curve: JointCurve, start: CurvePoint, before: CurvePoint, after: CurvePoint) -> bool:
    """True where the curve passes its start, whole turns aside, between two places."""
    near = [turned_alike(curve.mechanism, place.point - start.point) for place in (before, after)]
    ahead = [float(np.sum(n * start.tangent)) for n in near]
    width = after.along - before.along
    close = max(float(np.abs(n).max()) for n in near) <= 2.0 * width
    same_way = float(np.sum(after.tangent * start.tangent)) > 0.9
    if not (close and same_way and ahead[0] < 0.0 <= ahead[1]):
        return False
    # Close by is not there: wheels whose teeth do not come out even pass it by, turn after turn.
    share = -ahead[0] / (ahead[1] - ahead[0])
    guess = before.point + share * (after.point - before.point)
    passed = curve.on(before.arcs).corrected(guess, start.tangent)
    if passed is None:
        return False
    left = turned_alike(curve.mechanism, passed - start.point)
    left = left - np.sum(left * start.tangent) * start.tangent
    return float(np.abs(left).max()) <= CLOSED
