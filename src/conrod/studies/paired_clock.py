"""What one set of settings costs over another, on the same machine: timed in turns, see `conrod.paired_timing`.

Both advance through the same crank angles, whatever their steps. An input that makes one pass begins it anew each time.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from conrod.engines import Engine
from conrod.engines.engine import Machine, run_of
from conrod.paired_timing import Block, Clock, Stepper, in_turns, spent_by
from conrod.trajectory import Settings

ROUNDS = 200
# Of a block [s]: a thousand times what the clock and the calls cost, and less than most disturbances last.
BLOCK_TIME = 2e-3
# Where one is many times faster, its block must not be lost in what the call costs, nor the other's last for ever.
SHORT_BLOCK, LONG_BLOCK = 5e-4, 5e-2
WARM_UP = 5e-2  # [s], of the slower one: caches are filled, and a processor that slept is awake
TRIED = 3  # passes of each, to know how many a block is to have
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
    turns = machine.kinematics.mechanism.driver.span is None
    pair = (_turns if turns else _passes)(engine, machine, (settings, other), clock)
    spent = np.array(in_turns(pair.blocks, rounds), dtype=float) / np.array(pair.revolutions)
    low, middle, high = _median(spent[:, 0] / spent[:, 1])
    least = 1e-9 * spent.min(axis=0)
    return PairedTiming(middle, low, high, float(least[0]), float(least[1]), rounds)


@dataclass(frozen=True)
class _Pair:
    """What is timed in turns, and how many revolutions a block of either has."""

    blocks: tuple[Block, Block]
    revolutions: tuple[float, float]


def _turns(engine: Engine[Any], machine: Machine, each: tuple[Settings, Settings], clock: Clock) -> _Pair:
    """Two machines that go on and on."""
    turns = (each[0].steps_per_revolution, each[1].steps_per_revolution)
    # The shortest stretch of a turn that is whole steps of both.
    parts = math.gcd(*turns)
    unit = (turns[0] // parts, turns[1] // parts)
    one, other = (engine.stepper(machine, settings) for settings in each)
    units = _warmed_up((one, other), unit, clock)
    blocks = (partial(spent_by, one, units * unit[0], clock), partial(spent_by, other, units * unit[1], clock))
    return _Pair(blocks, (units / parts, units / parts))


def _passes(engine: Engine[Any], machine: Machine, each: tuple[Settings, Settings], clock: Clock) -> _Pair:
    """New machines in every block, each of which makes the one pass that the input can make.

    That passes in steps of different length end by up to a step apart is in the revolutions of each.
    """
    turns = [run_of(machine, settings.steps_per_revolution, 1.0)[1] for settings in each]

    def block(which: int, passes: int) -> int:
        settings = each[which]
        steps = max(1, round(turns[which] * settings.steps_per_revolution))
        # Made before the clock is looked at, and in one place of the memory or another: nothing favours either.
        made = [engine.stepper(machine, settings) for _ in range(passes)]
        return sum(spent_by(stepper, steps, clock) for stepper in made)

    # To make a machine takes longer than its pass: the processor is awake after one.
    times = [1e-9 * max(1, min(block(which, 1) for _ in range(TRIED))) for which in (0, 1)]
    passes = math.ceil(min(SHORT_BLOCK / min(times), max(1.0, LONG_BLOCK / max(times))))
    return _Pair((partial(block, 0, passes), partial(block, 1, passes)), (passes * turns[0], passes * turns[1]))


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
