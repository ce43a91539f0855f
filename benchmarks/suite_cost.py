"""The fast tests, on two cores."""

from __future__ import annotations

import sys

from benchmarks.process_cost import cost_of_process
from benchmarks.row import Row

COMMAND = [sys.executable, "-m", "pytest", "-q", "-n", "2", "-p", "no:cacheprovider"]
BAR = 180.0  # [s] by the clock on the wall, of two idle cores


def rows(repeats: int) -> list[Row]:
    """Time of all fast tests by the clock on the wall, and CPU time of their processes."""
    runs = [cost_of_process(COMMAND) for _ in range(repeats)]
    return [
        Row("fast tests, two workers, on the wall", "s", [run.wall for run in runs], BAR),
        Row("fast tests, CPU time", "s", [run.cpu for run in runs]),
    ]
