"""Cost of some settings, or of one way of stepping, over others: both timed in turns in one process.

Two timings made one after the other differ by whatever else the machine did meanwhile. In turns, each of them first as
often as the other, what slows the machine for longer than a block slows both. Both advance through the same crank
angles, whatever their steps. An input that makes one pass begins it anew each time.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from conrod.engines import Engine
from conrod.engines.capabilities import Timed, required
from conrod.engines.engine import Machine, run_of
from conrod.runs.trajectory import Settings

# CPU time of the calling thread [ns].
Clock = Callable[[], int]
Stepper = Callable[[int], None]
# Runs a block; the CPU time [ns] that it took.
Block = Callable[[], int]
# Two blocks to be timed in turns, and the number of revolutions in a block of either.
Pair = tuple[tuple[Block, Block], tuple[float, float]]

STEPPER_ROUNDS = 24
# Of a block [s]: a thousand times what the clock and the calls cost.
STEPPER_BLOCK_TIME = 2e-3
# Pairs of steppers that are made anew: where in the memory a model lies makes it faster or slower by a few per cent,
# the same model too, and for as long as it lives.
PAIRS = 4
MOST_STEPS = 4096  # in a block


@dataclass(frozen=True)
class PairedCost:
    """CPU time of a step of one way over a step of the other.

    Attributes:
        ratio: median of the rounds' ratios.
        low, high: their quartiles; where 1 lies between them, no difference was seen.
        seconds: least CPU time of a step of the first [s].
        rounds: how many.
    """

    ratio: float
    low: float
    high: float
    seconds: float
    rounds: int


def paired_cost(
    make_one: Callable[[], Stepper],
    make_other: Callable[[], Stepper],
    *,
    rounds: int = STEPPER_ROUNDS,
    clock: Clock = time.thread_time_ns,
) -> PairedCost:
    """Time one way of stepping against another.

    Args:
        make_one, make_other: give a function that advances by a number of steps, from the start; what it then steps
            through should be the same in both.
        rounds: how often both are timed, at least once.
        clock: CPU time of the calling thread [ns].
    """
    spent: list[tuple[float, float]] = []  # [ns] a step
    pairs = min(PAIRS, rounds)
    for pair in range(pairs):
        steppers = (make_one(), make_other())
        steps = _block(steppers, clock)
        blocks = (partial(spent_by, steppers[0], steps, clock), partial(spent_by, steppers[1], steps, clock))
        turns = in_turns(blocks, len(range(pair, rounds, pairs)))
        spent += [(one / steps, other / steps) for one, other in turns]
    times = 1e-9 * np.array(spent)
    # A clock that has not moved must not divide by zero.
    ratios = (times[:, 0] + 1e-18) / (times[:, 1] + 1e-18)
    low, middle, high = np.quantile(ratios, (0.25, 0.5, 0.75))
    return PairedCost(float(middle), float(low), float(high), float(times[:, 0].min()), rounds)


def _block(steppers: tuple[Stepper, Stepper], clock: Clock) -> int:
    """Warm both up; how many steps take the time of a block."""
    steps = 16
    while True:
        slower = 1e-9 * max(spent_by(stepper, steps, clock) for stepper in steppers)
        if slower >= STEPPER_BLOCK_TIME or steps >= MOST_STEPS:
            return max(1, math.ceil(steps * min(1.0, STEPPER_BLOCK_TIME / max(slower, 1e-12))))
        steps *= 2


def in_turns(blocks: tuple[Block, Block], rounds: int) -> list[tuple[int, int]]:
    """CPU times [ns] of a block of each, round after round; the first of a round is the last of the next."""
    found = []
    for turn in range(rounds):
        times = [0, 0]
        for which in (1, 0) if turn % 2 else (0, 1):
            times[which] = blocks[which]()
        found.append((times[0], times[1]))
    return found


def spent_by(stepper: Stepper, steps: int, clock: Clock) -> int:
    """CPU time [ns] of so many steps."""
    begin = clock()
    stepper(steps)
    return clock() - begin


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
    blocks, revolutions = (_turns if turns else _passes)(engine, machine, (settings, other), clock)
    spent = np.array(in_turns(blocks, rounds), dtype=float) / np.array(revolutions)
    low, middle, high = _median(spent[:, 0] / spent[:, 1])
    least = 1e-9 * spent.min(axis=0)
    return PairedTiming(middle, low, high, float(least[0]), float(least[1]), rounds)


def _turns(engine: Engine[Any], machine: Machine, each: tuple[Settings, Settings], clock: Clock) -> Pair:
    """Two machines that go on and on."""
    turns = (each[0].steps_per_revolution, each[1].steps_per_revolution)
    # The shortest stretch of a turn that is whole steps of both.
    parts = math.gcd(*turns)
    unit = (turns[0] // parts, turns[1] // parts)
    one, other = (required(engine, Timed).stepper(machine, settings) for settings in each)
    units = _warmed_up((one, other), unit, clock)
    blocks = (partial(spent_by, one, units * unit[0], clock), partial(spent_by, other, units * unit[1], clock))
    return blocks, (units / parts, units / parts)


def _passes(engine: Engine[Any], machine: Machine, each: tuple[Settings, Settings], clock: Clock) -> Pair:
    """New machines in every block, each of which makes the one pass that the input can make.

    That passes in steps of different length end by up to a step apart is in the revolutions of each.
    """
    turns = [run_of(machine, settings.steps_per_revolution, 1.0)[1] for settings in each]

    def block(which: int, passes: int) -> int:
        settings = each[which]
        steps = max(1, round(turns[which] * settings.steps_per_revolution))
        # Made before the clock is looked at, and in one place of the memory or another: nothing favours either.
        made = [required(engine, Timed).stepper(machine, settings) for _ in range(passes)]
        return sum(spent_by(stepper, steps, clock) for stepper in made)

    # To make a machine takes longer than its pass: the processor is awake after one.
    times = [1e-9 * max(1, min(block(which, 1) for _ in range(TRIED))) for which in (0, 1)]
    passes = math.ceil(min(SHORT_BLOCK / min(times), max(1.0, LONG_BLOCK / max(times))))
    return (partial(block, 0, passes), partial(block, 1, passes)), (passes * turns[0], passes * turns[1])


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
