"""Costs of cells, measured one at a time and beside nothing else, and kept as they come."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from conrod.engines import engine_named
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.execution.worker import on_known_scene
from conrod.studies.execution.worker_process import WorkerDied
from conrod.studies.frame.cell import Cell
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.timing import Timing, fingerprint, time_run


class CostWatcher(Protocol):
    """Told of the progress, in the thread that called."""

    def started(self, total: int, already_finished: int) -> None:
        """There are so many different cells, of which so many have been timed before."""
        ...

    def timed(self, cell: Cell, timing: Timing | None) -> None:
        """A cell has been timed, or could not be."""
        ...


def time_cells(
    cells: Sequence[Cell],
    ledger: Ledger,
    *,
    cell_timeout: float | None = None,
    fresh: bool = False,
    watcher: CostWatcher | None = None,
) -> dict[str, Timing]:
    """Time those cells that the ledger has no timing of on this machine, and give the timings of all.

    Each is timed in a process of this machine's own, whatever ran the cells: figures of different machines do not
    mix. A cell that cannot be timed within the limit, or whose process dies, has no timing.

    Args:
        cell_timeout: longest wall time of a timing [s].
        fresh: time them all.
    """
    by_key = {cell.key: cell for cell in cells}
    known = {} if fresh else ledger.timings(by_key, fingerprint())
    waiting = [cell for key, cell in by_key.items() if key not in known]
    if watcher is not None:
        watcher.started(len(by_key), len(known))
    with LocalProcesses(1, cell_timeout=cell_timeout) as worker:
        for cell in waiting:
            timing = _timing(worker, cell)
            if timing is not None:
                ledger.keep_timing(cell, timing)
            if watcher is not None:
                watcher.timed(cell, timing)
    return ledger.timings(by_key, fingerprint())


def time_cell(cell: Cell) -> Timing | None:
    """Time one cell, in the process that calls."""
    return time_run(engine_named(cell.settings.engine), cell.scene, cell.settings)


def _timing(worker: LocalProcesses, cell: Cell) -> Timing | None:
    try:
        return worker.submit(on_known_scene, time_cell, cell).result()
    except (WorkerDied, TimeoutError, MemoryError):
        return None  # a cost that cannot be measured is not a cost; the run's own outcome says what happened to it
