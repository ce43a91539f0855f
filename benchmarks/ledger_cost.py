"""The ledger: to keep a run, and to find that a hundred thousand are finished."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

from benchmarks.row import Row
from benchmarks.side_by_side import wall_seconds
from conrod import PymunkSettings, Saw
from conrod.execution.case import Case
from conrod.execution.dispatch import Watcher, run_cases
from conrod.execution.ledger import Ledger
from conrod.execution.local import LocalProcesses
from conrod.execution.run import RunCase, RunResult, measure

SAW = Saw(speed=52.36)
RUNS, BATCH = 100_000, 1000


def rows(repeats: int) -> list[Row]:
    """Time to keep a run, by batches, and to start again over all of them."""
    # Not in memory alone, where the system's folder for temporary files may be: a ledger outlives a loss of power.
    with tempfile.TemporaryDirectory(dir=Path(__file__).parent) as folder:
        path = Path(folder) / "ledger.sqlite"
        kept = times_to_keep(path)
        resumed = [time_to_resume(path, some_cells(RUNS)) for _ in range(repeats)]
    return [
        Row("ledger, a run kept", "ms", [1e3 * seconds / BATCH for seconds in kept], 0.5),
        Row("ledger, start of a resume over 100 000 finished runs", "s", [wall for wall, _ in resumed]),
        Row("ledger, CPU time of that", "s", [cpu for _, cpu in resumed], 1.0),
    ]


def times_to_keep(path: Path) -> list[float]:
    """Time [s] of each batch of runs, until all are kept."""
    cells, shown = some_cells(RUNS), measure(some_cells(20)[-1])
    with Ledger.open(path) as ledger:
        batches = [cells[first : first + BATCH] for first in range(0, RUNS, BATCH)]
        return [wall_seconds(partial(_keep, ledger, batch, shown)) for batch in batches]


def some_cells(count: int) -> list[RunCase]:
    """Different cells of one scene; new objects that remember nothing."""
    base = PymunkSettings.tuned(SAW, 20)
    return [RunCase("saw-500rpm", SAW, replace(base, iterations=k + 1), revolutions=1.0) for k in range(count)]


def _keep(ledger: Ledger, cells: Sequence[RunCase], shown: RunResult) -> None:
    for cell in cells:
        ledger.keep(cell, shown)


class Known(Exception):
    """It is known which runs are left: what follows is the runs, and what they showed."""


class _Stopwatch(Watcher):
    """A watcher that ends a resume when it has started."""

    def on_start(self, total: int, already_finished: int) -> None:
        raise Known if total == already_finished else AssertionError(f"{total - already_finished} runs were lost")

    def on_unreadable(self, count: int) -> None:
        raise AssertionError(f"{count} runs were damaged")

    def on_case_end(self, case: Case, how: str) -> None:
        raise AssertionError("a finished run was run again")


def time_to_resume(path: Path, cells: Sequence[RunCase]) -> tuple[float, float]:
    """Wall and CPU time [s] from the opening of a ledger to when it is known that all cells are finished."""
    before, cpu_before = time.perf_counter(), time.process_time()
    with Ledger.open(path) as ledger, LocalProcesses(1) as executor, suppress(Known):
        run_cases(cells, ledger, executor, watcher=_Stopwatch())
    return time.perf_counter() - before, time.process_time() - cpu_before
