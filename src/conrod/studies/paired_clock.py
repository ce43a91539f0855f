"""What one set of settings costs over another, on the same machine: timed in turns, see `conrod.paired_timing`.

Both advance through the same crank angles, whatever their steps.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from conrod.engines import Engine
from conrod.engines.engine import Machine
from conrod.paired_timing import Clock, Stepper, in_turns, spent_by
from conrod.trajectory import Settings

ROUNDS = 200
# Of a block [s]: a thousand times what the clock and the calls cost, and less than most disturbances last.
BLOCK_TIME = 2e-3
# Where one is many times faster, its block must not be lost in what the call costs, nor the other's last for ever.
SHORT_BLOCK, LONG_BLOCK = 5e-4, 5e-2
WARM_UP = 5e-2  # [s], of the slower one: caches are filled, and a processor that slept is awake
# Standard normal deviate of an interval that holds the median with 95 %.
CONFIDENCE = 1.96


@dataclass(frozen=True)
class PairedTiming:
    """CPU time of a revolution with some settings over that with others.

    Attributes:
        ratio: median of the rounds' ratios.
        low, high: interval that holds the median with 95 %, whatever the ratios' distribution, if the rounds are
            independent of each other.
        seconds, other_seconds: least CPU time of a revolution [s], of the settings and of those they are compared with.
        rounds: how many.
    """

    ratio: float
    low: float
    high: float
    seconds: float
    other_seconds: float
    rounds: int

    @property
    def inverse(self) -> PairedTiming:
        """The same seen from the other settings."""
        return PairedTiming(
            1.0 / self.ratio, 1.0 / self.high, 1.0 / self.low, self.other_seconds, self.seconds, self.rounds
        )

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)

    @classmethod
    def of(cls, values: Mapping[str, Any] | None) -> PairedTiming | None:
        """The inverse of `as_dict`; None of None."""
        return None if values is None else cls(**values)


def time_pair(
    engine: Engine[Any],
    machine: Machine,
    settings: Settings,
    other: Settings,
    *,
    rounds: int = ROUNDS,
    clock: Clock = time.thread_time_ns,
) -> PairedTiming:
    """Time settings against others, nothing recorded.

    Args:
        settings, other: of this engine, such that runs with them complete; see `clock.time_run`.
        rounds: how often both are timed.
        clock: CPU time of the calling thread [ns].
    """
    turns = (settings.steps_per_revolution, other.steps_per_revolution)
    # The shortest stretch of a turn that is whole steps of both.
    parts = math.gcd(*turns)
    unit = (turns[0] // parts, turns[1] // parts)
    steppers = (engine.stepper(machine, settings), engine.stepper(machine, other))
    units = _warmed_up(steppers, unit, clock)
    steps = (units * unit[0], units * unit[1])
    spent = np.array(in_turns(steppers, steps, rounds, clock), dtype=float)
    low, middle, high = _median(spent[:, 0] / spent[:, 1])
    least = 1e-9 * spent.min(axis=0) * parts / units
    return PairedTiming(middle, low, high, float(least[0]), float(least[1]), rounds)


def _warmed_up(steppers: tuple[Stepper, Stepper], unit: tuple[int, int], clock: Clock) -> int:
    """Advance both for a while, through the same angles; how many units a block is to have."""
    units, total = 1, 0.0
    while True:
        times = [1e-9 * spent_by(stepper, units * n, clock) for stepper, n in zip(steppers, unit, strict=True)]
        slower, faster = max(times), max(min(times), 1e-9)
        total += slower
        if total >= WARM_UP:
            share = min(max(BLOCK_TIME / slower, SHORT_BLOCK / faster), LONG_BLOCK / slower)
            return max(1, round(units * share))
        if slower < BLOCK_TIME:
            units *= 2


def _median(ratios: np.ndarray[Any, np.dtype[np.float64]]) -> tuple[float, float, float]:
    """Median with its interval, by order statistics: how many of n ratios lie below the median is binomial."""
    ordered, n = np.sort(ratios), len(ratios)
    first = max(0, math.floor(0.5 * (n - CONFIDENCE * math.sqrt(n))))
    return float(ordered[first]), float(np.median(ordered)), float(ordered[n - 1 - first])
