"""The way from one crank angle to another, in steps short enough for Newton's iteration to stay on its branch."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from conrod.motion import Array

# A kinematic mode's own angles are a degree apart; an iteration begun farther off may find another assembly.
LONGEST_STEP = 0.05  # [rad]


def approached(angles: Array) -> Iterator[tuple[float, bool]]:
    """Crank angles (T,) [rad] with what lies between them, from angle 0 on; each with whether it is one of those."""
    before = 0.0
    for angle in angles:
        steps = max(1, math.ceil(abs(float(angle) - before) / LONGEST_STEP))
        way = np.linspace(before, float(angle), steps + 1)[1:]
        yield from ((float(between), False) for between in way[:-1])
        yield float(angle), True
        before = float(angle)
