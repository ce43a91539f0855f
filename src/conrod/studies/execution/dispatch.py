"""Cases handed to an executor, and each result kept the moment it is there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import suppress
from itertools import islice
from typing import Protocol

from conrod.errors import InvalidInput
from conrod.runs.trajectory import Outcome
from conrod.studies.execution.worker import on_known_scene, perform
from conrod.studies.execution.worker_process import Limits, WorkerDied
from conrod.studies.frame.case import Case
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.measurement import Measurement

# Cases handed over at a time to an executor that does not say how many it wants.
IN_FLIGHT = 64


class Watcher(Protocol):
    """Receiver of the progress, in the thread that called."""

    def started(self, total: int, already_finished: int) -> None:
        """There are so many different cases, of which so many need not run."""
        ...

    def advanced(self, case: Case, measurement: Measurement) -> None:
        """A case has run and its result is kept."""
        ...


def run_cases(
    cases: Sequence[Case],
    ledger: Ledger,
    executor: Executor,
    *,
    fresh: bool = False,
    watcher: Watcher | None = None,
) -> dict[str, Measurement]:
    """Run those cases that the ledger does not have, and give the results of all.

    A case that kills its process, or ends at a limit of the executor, has that as its outcome. Those that ended at a
    limit run again where there is a wider one now. An error or Ctrl-C cancels what waits, keeps what is finished and
    goes on to the caller.

    Args:
        executor: any; one with `limits` and `in_flight`, as conrod's own have, is asked for them.
        fresh: run them all.

    Raises:
        InvalidInput: as `Case.perform`, `Ledger.keep` and the executor.

    Returns:
        Key -> what the ledger has of it, in the order of the cases; nothing in it depends on the order in which they
        finished, or on which call or process ran them.
    """
    by_key = {case.key: case for case in cases}
    limits: Limits = getattr(executor, "limits", Limits())
    waiting = by_key if fresh else _unfinished(by_key, ledger, limits)
    if watcher is not None:
        watcher.started(len(by_key), len(by_key) - len(waiting))

    def keep(case: Case, future: Future[Measurement]) -> None:
        measurement = _outcome(future)
        ledger.keep(case, measurement, limits.of(measurement.outcome), replace=fresh)
        if watcher is not None:
            watcher.advanced(case, measurement)

    # Long ones first; else in the order of the keys, which is as good as shuffled: the rate so far is the rate to come.
    _run(sorted(waiting.values(), key=lambda case: (-case.effort, case.key)), executor, keep)
    return ledger.measurements(by_key)


def _unfinished(by_key: Mapping[str, Case], ledger: Ledger, limits: Limits) -> dict[str, Case]:
    finished = ledger.finished(by_key)
    again = {key for key, stop in ledger.stopped(by_key).items() if limits.allow_more(*stop)}
    return {key: case for key, case in by_key.items() if key not in finished or key in again}


def _run(
    cases: Sequence[Case],
    executor: Executor,
    keep: Callable[[Case, Future[Measurement]], None],
) -> None:
    """Run all of them, a bounded number at a time, and keep each as it finishes."""
    remaining = iter(cases)
    flying: dict[Future[Measurement], Case] = {}
    try:
        while True:
            # Asked for every time: a cluster grows and shrinks.
            in_flight: int = getattr(executor, "in_flight", IN_FLIGHT)
            for case in islice(remaining, max(0, in_flight - len(flying))):
                flying[_submitted(executor, case)] = case
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


def _salvage(flying: Mapping[Future[Measurement], Case], keep: Callable[[Case, Future[Measurement]], None]) -> None:
    """Keep what finished beside the error, or the interrupt, that ended it all."""
    # The ledger itself may be what failed. Then it fails again, and the first error says why.
    with suppress(InvalidInput):
        for future, case in flying.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                keep(case, future)


def _submitted(executor: Executor, case: Case) -> Future[Measurement]:
    try:
        return executor.submit(on_known_scene, perform, case)
    except BrokenExecutor as error:
        raise _broken(error) from error


def _outcome(future: Future[Measurement]) -> Measurement:
    """Result of a case's future; errors that no case causes by what it is go on to the caller."""
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
    return InvalidInput(f"the executor broke, and does not say which case broke it ({error}); use LocalProcesses")
