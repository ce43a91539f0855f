"""The change points that a walk has come through, and what is known near them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conrod.change_points import ChangePoint
from conrod.motion import Array

SAME = 1e-6  # [rad], between two findings of one change point


class KnownChanges:
    """Change points by their angle, those that a walk passes on its way to and fro found once."""

    def __init__(self) -> None:
        self._changes: list[ChangePoint] = []

    def add(self, change: ChangePoint) -> None:
        """Take in a change point."""
        if not any(abs(change.angle - known.angle) < SAME for known in self._changes):
            self._changes.append(change)
            self._changes.sort(key=lambda known: known.angle)

    def repeat(self, turn: float, gain: Array) -> None:
        """Take in those of the turns before and after one that repeats, with what it adds to the poses (3 n,)."""
        for change in list(self._changes):
            for turns in (-1.0, 1.0):
                shifted = change.coefficients.copy()
                shifted[0] += turns * gain
                self.add(replace(change, angle=change.angle + turns * turn, coefficients=shifted))

    @property
    def angles(self) -> Array:
        """Their crank angles [rad], growing."""
        return np.array([change.angle for change in self._changes])

    def near(self, angle: Array, distance: float | None = None) -> NDArray[np.bool_]:
        """Which angles (T,) [rad] are less than a distance from one, or so near that its series is to be used."""
        result = np.zeros(len(angle), dtype=bool)
        for change in self._changes:
            result |= change.near(angle) if distance is None else np.abs(angle - change.angle) < distance
        return result

    def fill(self, angle: Array, coefficients: list[Array]) -> None:
        """Put Taylor coefficients of the poses, as many orders of (T, 3 n) as are given, where angles are near."""
        for change in self._changes:
            near = change.near(angle)
            if near.any():
                for filled, values in zip(coefficients, change.series(angle[near], len(coefficients) - 1), strict=True):
                    filled[near] = values

    def sign(self, angle: Array) -> Array:
        """Sign of the determinant (T,) on the smooth course at angles (T,) [rad], against that at crank angle 0."""
        result = np.ones(len(angle))
        for change in self._changes:
            if change.freedoms % 2:
                result[(angle > change.angle) != (change.angle < 0.0)] *= -1.0
        return result
