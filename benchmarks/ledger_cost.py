"""The ledger: to keep a run, and to find that a hundred thousand are finished."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from benchmarks.process_cost import Cost, cost_of_process
from benchmarks.row import Row
from benchmarks.side_by_side import wall_seconds
from conrod import PymunkSettings, Saw
from conrod.execution.case import Case
from conrod.execution.ledger import Ledger
from conrod.execution.local import LocalProcesses
from conrod.execution.run import RunCase, RunResult, measure
from conrod.execution.runner import Watcher, run_cases

SAW = Saw(speed=52.36)
RUNS, BATCH = 100_000, 1000


def rows(repeats: int) -> list[Row]:
    """Time to keep a run, by batches, and to start again over all of them."""
    # Not in memory alone, where the system's folder for temporary files may be: a ledger outlives a loss of power.
    with tempfile.TemporaryDirectory(dir=Path(__file__).parent) as folder:
        path = Path(folder) / "ledger.sqlite"
        kept = times_to_keep(path)
        resumed = [cost_of_resume(path, RUNS) for _ in range(repeats)]
        reading = cost_of_resume(path, RUNS, read=True)
    return [
        Row("ledger, a run kept", "ms", [1e3 * seconds / BATCH for seconds in kept], 0.5),
        Row("ledger, a resume over 100 000 finished runs, CPU time of its process", "s", [r.cpu for r in resumed], 2.0),
        Row("ledger, memory of that", "MB", [r.megabytes for r in resumed], 300.0),
        Row("ledger, the same with each result read once, CPU time", "s", [reading.cpu]),
        Row("ledger, memory of that reading", "MB", [reading.megabytes]),
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


class _Strict(Watcher):
    """A watcher that ends a resume in which anything is left to run."""

    def on_start(self, total: int, already_finished: int) -> None:
        if total > already_finished:
            raise AssertionError(f"{total - already_finished} runs were lost")

    def on_unreadable(self, count: int) -> None:
        raise AssertionError(f"{count} runs were damaged")

    def on_case_end(self, case: Case | None, how: str) -> None:
        raise AssertionError("a finished run was run again")


def resume(path: Path, cells: Sequence[RunCase], *, read: bool = False) -> int:
    """Resume a finished study to its end; return the number of its results.

    Args:
        read: whether each result is read once, as a study of all of them does.
    """
    with Ledger.open(path) as ledger, LocalProcesses(1) as executor:
        results = run_cases(cells, ledger, executor, watcher=_Strict())
        return sum(1 for key in results if not read or results[key].completed)


def cost_of_resume(path: Path, count: int, *, read: bool = False) -> Cost:
    """CPU time and memory of a process that resumes a study of some cells, from its start to its end."""
    code = (
        "from pathlib import Path; from benchmarks.ledger_cost import resume, some_cells; "
        f"assert resume(Path({str(path)!r}), some_cells({count}), read={read}) == {count}"
    )
    return cost_of_process([sys.executable, "-c", code])
