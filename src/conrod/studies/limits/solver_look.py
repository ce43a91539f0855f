"""How an engine's solver ended, over the steps of a run that were looked at."""

from __future__ import annotations

import math

from conrod.studies.limits.extremes import SolverWatch
from conrod.trajectory import SolverState


class SolverLook:
    """Takes in one step after the other.

    Args:
        allowed: iterations that the solver may take.
        speed: of the crank [rad/s].
        length: that errors of the machine are normalised by [m].
    """

    def __init__(self, allowed: int, speed: float, length: float) -> None:
        self._allowed, self._speed, self._length = allowed, abs(speed), length
        self._least: int | None = None
        self._most: int | None = None
        self._residual: float | None = None
        self._looked = 0

    def add(self, state: SolverState | None) -> None:
        """Take in a step; None where there was nothing to look at."""
        if state is None:
            return
        self._looked += 1
        residual = state.residual / (self._length * self._speed ** (1 if state.of_rates else 2))
        # What is not a number any more is told as such elsewhere.
        if math.isfinite(residual):
            self._residual = max(residual, self._residual or 0.0)
        if state.iterations is not None:
            self._least = min(state.iterations, state.iterations if self._least is None else self._least)
            self._most = max(state.iterations, state.iterations if self._most is None else self._most)

    def found(self) -> SolverWatch | None:
        """None where no step was looked at."""
        if not self._looked:
            return None
        return SolverWatch(self._looked, self._allowed, self._least, self._most, self._residual)
