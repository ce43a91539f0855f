"""Cells handed to an executor, and each result kept the moment it is there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import suppress
from itertools import islice
from typing import Protocol

from conrod.errors import InvalidInput
from conrod.runs.trajectory import Outcome
from conrod.studies.execution.limits import Limits
from conrod.studies.execution.worker import on_known_scene
from conrod.studies.execution.worker_process import WorkerDied
from conrod.studies.frame.cell import Cell
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.measurement import Measurement, measure

# Cells handed over at a time to an executor that does not say how many it wants.
IN_FLIGHT = 64


class Watcher(Protocol):
    """Told of the progress, in the thread that called."""

    def started(self, total: int, already_finished: int) -> None:
        """There are so many different cells, of which so many need not run."""
        ...

    def advanced(self, cell: Cell, measurement: Measurement) -> None:
        """A cell has run and its result is kept."""
        ...


def run_cells(
    cells: Sequence[Cell],
    ledger: Ledger,
    executor: Executor,
    *,
    fresh: bool = False,
    watcher: Watcher | None = None,
    task: Callable[[Cell], Measurement] = measure,
) -> dict[str, Measurement]:
    """Run those cells that the ledger does not have, and give the results of all.

    A cell that kills its process, or ends at a limit of the executor, has that as its outcome. Those that ended at a
    limit run again where there is a wider one now. An error or Ctrl-C cancels what waits, keeps what is finished and
    goes on to the caller.

    Args:
        executor: any; one with `limits` and `in_flight`, as conrod's own have, is asked for them.
        fresh: run them all.
        task: what to do with a cell; importable by its module's name unless the executor shares this process.

    Raises:
        InvalidInput: as `measure`, `Ledger.keep` and the executor.

    Returns:
        Key -> what the ledger has of it, in the order of the cells; nothing in it depends on the order in which they
        finished, or on which call or process ran them.
    """
    by_key = {cell.key: cell for cell in cells}
    limits: Limits = getattr(executor, "limits", Limits())
    waiting = by_key if fresh else _unfinished(by_key, ledger, limits)
    if watcher is not None:
        watcher.started(len(by_key), len(by_key) - len(waiting))

    def keep(cell: Cell, future: Future[Measurement]) -> None:
        measurement = _outcome(future)
        ledger.keep(cell, measurement, limits.of(measurement.outcome), replace=fresh)
        if watcher is not None:
            watcher.advanced(cell, measurement)

    # In the order of the keys, which is as good as shuffled: the rate so far is then the rate to come.
    _run([waiting[key] for key in sorted(waiting)], executor, task, keep)
    return ledger.measurements(by_key)


def _unfinished(by_key: Mapping[str, Cell], ledger: Ledger, limits: Limits) -> dict[str, Cell]:
    finished = ledger.finished(by_key)
    again = {key for key, stop in ledger.stopped(by_key).items() if limits.allow_more(*stop)}
    return {key: cell for key, cell in by_key.items() if key not in finished or key in again}


def _run(
    cells: Sequence[Cell],
    executor: Executor,
    task: Callable[[Cell], Measurement],
    keep: Callable[[Cell, Future[Measurement]], None],
) -> None:
    """Run all of them, a bounded number at a time, and keep each as it finishes."""
    remaining = iter(cells)
    flying: dict[Future[Measurement], Cell] = {}
    try:
        while True:
            # Asked for every time: a cluster grows and shrinks.
            in_flight: int = getattr(executor, "in_flight", IN_FLIGHT)
            for cell in islice(remaining, max(0, in_flight - len(flying))):
                flying[_submitted(executor, task, cell)] = cell
            if not flying:
                return
            for future in wait(flying, return_when=FIRST_COMPLETED).done:
                keep(flying[future], future)
                del flying[future]
    except BaseException:
        for future in flying:
            future.cancel()
        _salvage(flying, keep)
        raise


def _salvage(flying: Mapping[Future[Measurement], Cell], keep: Callable[[Cell, Future[Measurement]], None]) -> None:
    """Keep what finished beside the error, or the interrupt, that ended it all."""
    # The ledger itself may be what failed. Then it fails again, and the first error says why.
    with suppress(InvalidInput):
        for future, cell in flying.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                keep(cell, future)


def _submitted(executor: Executor, task: Callable[[Cell], Measurement], cell: Cell) -> Future[Measurement]:
    try:
        return executor.submit(on_known_scene, task, cell)
    except BrokenExecutor as error:
        raise _broken(error) from error


def _outcome(future: Future[Measurement]) -> Measurement:
    """What a cell's future came to; errors that no cell causes by what it is go on to the caller."""
    try:
        return future.result()
    except BrokenExecutor as error:
        raise _broken(error) from error
    except WorkerDied as error:
        return Measurement(Outcome.CRASHED.slug, str(error))
    except TimeoutError as error:
        return Measurement(Outcome.TIMED_OUT.slug, str(error))
    except MemoryError as error:
        return Measurement(Outcome.OUT_OF_MEMORY.slug, str(error) or "there was no more")


def _broken(error: BrokenExecutor) -> InvalidInput:
    """The standard library's pool loses all its calls with one process: none can be blamed, none is kept."""
    return InvalidInput(f"the executor broke, and does not tell which cell broke it ({error}); use LocalProcesses")
