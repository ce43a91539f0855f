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

from conrod.dynamics.constraint import JointCurve, turned_alike
from conrod.errors import InvalidInput
from conrod.motion import Array

FIRST_STEP, LEAST_STEP, LONGEST_STEP = 0.01, 1e-9, 0.05  # of arc length, in its unit
# A predictor of second order that misses by more than this is shortened; one whose tangent turns by more has strayed.
MISS, TURN = 1e-4, 0.1
# A place nearer to a crossing of branches than this has lost digits to it: it is stepped over at another distance.
CROSSING = 1e-4


@dataclass(frozen=True)
class Place:
    """A point of the curve, its unit tangent and its curvature, each (1, 3 n), and about how far along it lies."""

    along: float
    point: Array
    tangent: Array
    curvature: Array


class CurveWalk:
    """Places along the curve, one after the other."""

    def __init__(self, curve: JointCurve) -> None:
        self.curve = curve

    def first(self, direction: Array) -> Place:
        """The place of the start poses, with the tangent in the sense of a direction (1, 3 n).

        Raises:
            InvalidInput: branches cross there, so that the poses do not tell one.
        """
        point = self.curve.start()
        tangent = self.curve.tangent(point, direction)
        if not np.isfinite(tangent).all() or self.curve.nearness(point, tangent)[0] < CROSSING:
            raise InvalidInput(
                f"{self.curve.mechanism.name}: at the start poses branches of its motion cross; start beside them"
            )
        return self._place(0.0, point, tangent)

    def _place(self, along: float, point: Array, tangent: Array) -> Place:
        return Place(along, point, tangent, self.curve.curvature(point, tangent))

    def steps(self, here: Place) -> Iterator[Place]:
        """Places after one, without end.

        Raises:
            InvalidInput: the curve ends.
        """
        step = FIRST_STEP * self.curve.unit
        while True:
            reached, miss = self._try(here, step)
            if reached is not None:
                yield reached
                here = reached
                step = min(
                    LONGEST_STEP * self.curve.unit,
                    step * min(2.0, max(0.5, 0.9 * (MISS / max(miss, 1e-300)) ** (1.0 / 3.0))),
                )
            else:
                # Not a half: an even share could meet the same crossing again.
                step *= 0.37 if step > LEAST_STEP else 0.0
                if step == 0.0:
                    raise InvalidInput(f"{self.curve.mechanism.name}: its motion cannot be followed any further")

    def _try(self, here: Place, step: float) -> tuple[Place | None, float]:
        guess = here.point + step * here.tangent + 0.5 * step**2 * here.curvature
        point = self.curve.corrected(guess, here.tangent)
        if point is None:
            return None, np.inf
        miss = float(np.abs(point - guess).max())
        tangent = self.curve.tangent(point, here.tangent)
        turned = np.linalg.norm(tangent - here.tangent)
        if not np.isfinite(tangent).all() or miss > MISS or turned > TURN:
            return None, miss
        if self.curve.nearness(point, tangent)[0] < CROSSING:
            return None, miss
        return self._place(here.along + step, point, tangent), miss


def closes(curve: JointCurve, start: Place, before: Place, after: Place) -> bool:
    """Whether the curve passes its start, whole turns aside, between two places."""
    near = [turned_alike(curve.mechanism, place.point - start.point) for place in (before, after)]
    ahead = [float(np.sum(n * start.tangent)) for n in near]
    width = after.along - before.along
    close = max(float(np.abs(n).max()) for n in near) <= 2.0 * width
    same_way = float(np.sum(after.tangent * start.tangent)) > 0.9
    return close and same_way and ahead[0] < 0.0 <= ahead[1]
