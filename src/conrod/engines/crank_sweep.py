"""The way from one crank angle to another, in steps short enough for Newton's iteration to stay on its branch."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array

# A kinematic mode's own angles are a degree apart; an iteration begun farther off may find another assembly.
LONGEST_STEP = 0.05  # [rad]
# So near [rad] to a change point, where assemblies meet, joints hardly tell the pose. pymunk solves them one after the
# other, and takes rounds by the square of this; its 2000 leave 8e-9 of a parallelogram's travel at half a degree, 2e-12
# at three, and nothing but rounding here.
MEETING = 0.08


def approached(kinematics: Kinematics, angles: Array) -> Iterator[tuple[float, bool]]:
    """Crank angles (T,) [rad] with what lies between them, from angle 0 on; each with whether it is one of those.

    What lies next to a change point is stepped over.
    """
    before = 0.0
    for angle in angles:
        steps = max(1, math.ceil(abs(float(angle) - before) / LONGEST_STEP))
        way = np.linspace(before, float(angle), steps + 1)[1:]
        clear = way[:-1][~kinematics.near_change(way[:-1], MEETING)]
        yield from ((float(between), False) for between in clear)
        yield float(angle), True
        before = float(angle)


class StraightAhead:
    """States of an engine ahead of those that it found: an iteration begun there goes through a change point."""

    def __init__(self) -> None:
        self._found: list[tuple[float, Array]] = []

    def found(self, angle: float, state: Array) -> None:
        """Take in a state found at a crank angle [rad]."""
        self._found = [*self._found[-1:], (angle, state.copy())]

    def at(self, angle: float) -> Array | None:
        """The state on the line through the last two found; None before there are two."""
        if len(self._found) < 2:
            return None
        (first, start), (second, stop) = self._found
        return np.asarray(stop + (stop - start) * (angle - second) / (second - first))
