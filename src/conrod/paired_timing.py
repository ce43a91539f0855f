"""Cost of one way of stepping over another: both timed in turns in one process.

Two timings made one after the other differ by whatever else the machine did meanwhile. In turns, each of them first as
often as the other, what slows the machine for longer than a block slows both.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

# CPU time of the calling thread [ns].
Clock = Callable[[], int]
Stepper = Callable[[int], None]
# Runs a block; the CPU time [ns] that it took.
Block = Callable[[], int]

ROUNDS = 24
# Of a block [s]: a thousand times what the clock and the calls cost.
BLOCK_TIME = 2e-3
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
    rounds: int = ROUNDS,
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
        if slower >= BLOCK_TIME or steps >= MOST_STEPS:
            return max(1, math.ceil(steps * min(1.0, BLOCK_TIME / max(slower, 1e-12))))
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
