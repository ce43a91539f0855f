"""Cost of some settings, or of one way of stepping, relative to another: both timed alternately in one process.

Two timings made one after the other differ by whatever else the machine did meanwhile. In turns, each of them first as
often as the other, what slows the machine for longer than a block slows both. Both advance through the same crank
angles, whatever their steps. An input that makes one pass begins it anew each time.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from conrod.comparison.trajectory import Settings
from conrod.engines import Engine
from conrod.engines.capabilities import TimedStepping, require_capability
from conrod.engines.engine import Machine, run_extent
from conrod.exact.motion import Array

# CPU time of the calling thread [ns].
Clock = Callable[[], int]
Stepper = Callable[[int], None]
# Runs some units of a block, such as a step or a pass; the CPU time [ns] that they took.
Block = Callable[[int], int]

ROUNDS, STEPPER_ROUNDS = 200, 24
# Of a block [s]: a thousand times what the clock and the calls cost, and less than most disturbances last.
BLOCK_TIME = 2e-3
# Where one is many times faster, its block must not be lost in what the call costs, nor the other's last for ever.
MIN_BLOCK_TIME, MAX_BLOCK_TIME = 5e-4, 5e-2
WARM_UP_TIME = 5e-2  # [s], of the slower one: caches are filled, and a processor that slept is awake
TRIAL_PASSES = 3  # passes of each, to find how many make a block
# Pairs of steppers that are made anew: where in the memory a model lies makes it faster or slower by a few per cent,
# the same model too, and for as long as it lives.
STEPPER_PAIRS = 4
MAX_BLOCK_STEPS, MAX_BLOCK_UNITS = 4096, 1 << 30  # in a block
# Standard normal deviate of an interval that holds the median with 95 %.
CONFIDENCE_DEVIATE = 1.96


@dataclass(frozen=True)
class PairedTiming:
    """Ratio of the CPU times of two settings per revolution, or of two steppers per step.

    Attributes:
        ratio: median of the rounds' ratios.
        low, high: interval that holds the median with 95 %, whatever the ratios' distribution, if the rounds are
            independent of each other.
        seconds, other_seconds: least CPU time [s], of the settings and of those they are compared with.
        rounds: number of rounds.
    """

    ratio: float
    low: float
    high: float
    seconds: float
    other_seconds: float
    rounds: int

    def against_noise(self, noise: PairedTiming) -> str:
        """Return `slower` or `faster` if the interval is beyond 1 and beyond that of two equal steppers."""
        if self.low > max(1.0, noise.high):
            return "slower"
        return "faster" if self.high < min(1.0, noise.low) else "within the spread"

    @property
    def inverse(self) -> PairedTiming:
        """Timing with the two settings exchanged: ratio and interval are inverted."""
        return PairedTiming(
            1.0 / self.ratio, 1.0 / self.high, 1.0 / self.low, self.other_seconds, self.seconds, self.rounds
        )

    @classmethod
    def from_rounds(cls, spent: Array) -> PairedTiming:
        """Make the timing of rounds (n, 2) [ns].

        The number of the n ratios below their median is binomial, so with 95 % the median lies between the ordered
        ratios at (n - 1.96 sqrt n) / 2 from either end.
        """
        # A clock that has not moved must not divide by zero.
        ordered, n = np.sort((spent[:, 0] + 1e-9) / (spent[:, 1] + 1e-9)), len(spent)
        first = max(0, math.floor(0.5 * (n - CONFIDENCE_DEVIATE * math.sqrt(n))))
        least = 1e-9 * spent.min(axis=0)
        low, high = float(ordered[first]), float(ordered[n - 1 - first])
        return cls(float(np.median(ordered)), low, high, float(least[0]), float(least[1]), n)


def time_stepper_pair(
    make_one: Callable[[], Stepper],
    make_other: Callable[[], Stepper],
    *,
    rounds: int = STEPPER_ROUNDS,
    clock: Clock = time.thread_time_ns,
    longest: float = math.inf,
) -> PairedTiming:
    """Time a step of one stepper against a step of another.

    Args:
        make_one, make_other: give a function that advances by a number of steps, from the start; what it then steps
            through should be the same in both.
        rounds: number of times that both are timed, at least 1.
        clock: CPU time of the calling thread [ns].
        longest: CPU time [s] after which no further pair is made: what steps slowly is timed fewer times.
    """
    each = make_one, make_other
    spent = _time_new_pairs(lambda: [partial(cpu_time, make(), 1, clock) for make in each], rounds, longest)
    return PairedTiming.from_rounds(np.concatenate(spent))


def time_block_pair(make: Callable[[], Sequence[Block]], *, rounds: int = STEPPER_ROUNDS) -> PairedTiming:
    """Time a unit of one block against a unit of another, in several pairs that are made anew.

    The interval covers the medians of the pairs too: what differs from pair to pair, such as the place in the memory,
    is no difference of the two.

    Args:
        make: makes the two functions that advance by a number of units and return the CPU time [ns].
        rounds: number of times that both are timed, at least 1.
    """
    spent = _time_new_pairs(make, rounds)
    whole, each = (
        PairedTiming.from_rounds(np.concatenate(spent)),
        [PairedTiming.from_rounds(one).ratio for one in spent],
    )
    return replace(whole, low=min(whole.low, *each), high=max(whole.high, *each))


def _time_new_pairs(make: Callable[[], Sequence[Block]], rounds: int, longest: float = math.inf) -> list[Array]:
    """CPU times of a unit, (n, 2) [ns] of the n rounds that each new pair of blocks has."""
    spent, pairs, begun = list[Array](), min(STEPPER_PAIRS, rounds), time.process_time()
    for pair in range(pairs):
        if spent and time.process_time() - begun > longest:
            break
        blocks = make()
        steps = _warm_up(blocks, BLOCK_TIME, most=MAX_BLOCK_STEPS)
        spent.append(_time_alternately(blocks, steps, len(range(pair, rounds, pairs))) / steps)
    return spent


def time_settings_pair(
    engine: Engine[Any],
    machine: Machine,
    settings: Settings,
    other: Settings,
    *,
    rounds: int = ROUNDS,
    clock: Clock = time.thread_time_ns,
) -> PairedTiming:
    """Time a revolution with some settings against a revolution with others, nothing recorded.

    Args:
        settings, other: of this engine, such that runs with them complete; see `timing.time_run`.
        rounds: number of times that both are timed.
        clock: CPU time of the calling thread [ns].
    """
    each, make = (settings, other), require_capability(engine, TimedStepping).stepper
    if machine.kinematics.mechanism.driver.span is None:
        # The shortest stretch of a turn that is whole steps of both.
        parts = math.gcd(*(one.steps_per_revolution for one in each))
        blocks = [partial(cpu_time, make(machine, one), one.steps_per_revolution // parts, clock) for one in each]
        units, lengths = _warm_up(blocks, WARM_UP_TIME, MIN_BLOCK_TIME), [1.0 / parts] * 2
    else:
        # Passes in steps of different length end by up to a step apart: that is in the length of each.
        lengths = [run_extent(machine, one.steps_per_revolution, 1.0)[1] for one in each]
        blocks = [partial(time_passes, make, machine, one, clock) for one in each]
        # To make a machine takes longer than its pass: the processor is awake after one.
        times = [1e-9 * max(1, min(block(1) for _ in range(TRIAL_PASSES))) for block in blocks]
        units = math.ceil(min(MIN_BLOCK_TIME / min(times), max(1.0, MAX_BLOCK_TIME / max(times))))
    return PairedTiming.from_rounds(_time_alternately(blocks, units, rounds) / (units * np.array(lengths)))


def time_passes(
    make: Callable[[Machine, Settings], Stepper], machine: Machine, settings: Settings, clock: Clock, count: int
) -> int:
    """CPU time [ns] of `count` passes, each with a new stepper."""
    steps = round(settings.steps_per_revolution * run_extent(machine, settings.steps_per_revolution, 1.0)[1])
    # Made before the clock is looked at, and in one place of the memory or another: nothing favours either.
    made = [make(machine, settings) for _ in range(count)]
    return sum(cpu_time(stepper, steps, clock, 1) for stepper in made)


def cpu_time(stepper: Stepper, unit: int, clock: Clock, count: int) -> int:
    """CPU time [ns] of `count` units of `unit` steps each."""
    begin = clock()
    stepper(count * unit)
    return clock() - begin


def _time_alternately(blocks: Sequence[Block], units: int, rounds: int) -> Array:
    """CPU times (rounds, 2) [ns] of a block of each; the order of the two alternates."""
    found = np.empty((rounds, 2))
    for turn in range(rounds):
        for which in (1, 0) if turn % 2 else (0, 1):
            found[turn, which] = blocks[which](units)
    return found


def _warm_up(blocks: Sequence[Block], warm_up: float, short: float = 0.0, most: int = MAX_BLOCK_UNITS) -> int:
    """Advance both for a time [s] through the same angles; return the number of units of a block.

    Args:
        short: duration [s] that the faster one's block must reach, as far as the other limits allow.
        most: units of a block.
    """
    units, total = 1, 0.0
    while True:
        times = [1e-9 * block(units) for block in blocks]
        slower, faster = max(*times, 1e-9), max(min(times), 1e-9)
        total += slower
        if total >= warm_up or units >= most:
            share = min(max(BLOCK_TIME / slower, short / faster), MAX_BLOCK_TIME / slower)
            return max(1, min(most, round(units * share)))
        if slower < BLOCK_TIME:
            units *= 2
