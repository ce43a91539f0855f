"""Interleaved repeats: what slows the machine down for a while slows all sides of a comparison down alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TypeVar

from benchmarks.row import Row

Made = TypeVar("Made")
# A side gives the CPU time [s] of the part of it that counts.
Side = Callable[[], float]


def cpu_seconds(work: Callable[[], object]) -> float:
    """CPU time [s] of a call; unlike the clock on the wall it does not run while others have the core."""
    before = time.process_time()
    work()
    return time.process_time() - before


def wall_seconds(work: Callable[[], object]) -> float:
    """Time [s] by the clock on the wall."""
    before = time.perf_counter()
    work()
    return time.perf_counter() - before


def interleaved(sides: Mapping[str, Side], repeats: int) -> dict[str, list[float]]:
    """Time [s] of every side in every repeat, after one that does not count."""
    seconds: dict[str, list[float]] = {name: [] for name in sides}
    for repeat in range(repeats + 1):
        for name, side in sides.items():
            taken = side()
            if repeat:
                seconds[name].append(taken)
    return seconds


def against(seconds: Mapping[str, list[float]], base: str, bars: Mapping[str, float], title: str) -> list[Row]:
    """The ratio of each side to the base within a repeat, with its bar if it has one."""
    return [
        Row(
            f"{title}: {name}, against {base}",
            "x",
            [taken / bare for taken, bare in zip(times, seconds[base], strict=True)],
            bars.get(name),
        )
        for name, times in seconds.items()
        if name != base
    ]
