"""Cases handed to an executor, or timed one by one, and each result kept the moment it is there."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import suppress
from functools import partial
from typing import Protocol, TypeVar

from conrod.engines import engine_named
from conrod.errors import InvalidInput
from conrod.studies.execution.local import Ended, LocalProcesses, RepeatingExecutor
from conrod.studies.execution.worker import on_known_scene, perform
from conrod.studies.execution.worker_process import Limits, WorkerDied
from conrod.studies.frame.case import Case, Measurement
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing, fingerprint, time_run

AnyCase = TypeVar("AnyCase", bound=Case)
END = object()


class Watcher(Protocol):
    """Receiver of the progress, in the thread that called."""

    def started(self, total: int, already_finished: int) -> None:
        """There are so many different cases, of which so many need not run."""
        ...

    def unreadable(self, count: int) -> None:
        """So many runs are damaged in the ledger, or in the form of another conrod; they are made again."""
        ...

    def advanced(self, case: Case, how: str) -> None:
        """A case has ended so, and what came of it is kept."""
        ...


def run_cases(
    cases: Sequence[Case],
    ledger: Ledger,
    executor: RepeatingExecutor,
    *,
    fresh: bool = False,
    watcher: Watcher | None = None,
) -> dict[str, Measurement]:
    """Run those cases that the ledger does not have, and give the results of all.

    A case that kills its process, or ends at a limit of the executor, has that as its outcome. Those that ended at a
    limit run again where there is a wider one now, and so do those whose row cannot be read. An error or Ctrl-C
    cancels what waits, keeps what is finished and goes on to the caller. What another process on the ledger runs is
    left to it, and run only where that ends without a result.

    Args:
        fresh: run them all.

    Raises:
        InvalidInput: as `Case.perform`, `Ledger.keep` and the executor.

    Returns:
        Key -> what the ledger has of it, in the order of the cases; nothing in it depends on the order in which they
        finished, or on which call or process ran them.
    """
    by_key = {case.key: case for case in cases}
    waiting = by_key if fresh else _unfinished(by_key, ledger, executor.limits)
    if watcher is not None:
        watcher.started(len(by_key), len(by_key) - len(waiting))
    _run(waiting, ledger, executor, fresh, watcher)
    found = ledger.measurements(by_key)
    lost = {k: c for k, c in by_key.items() if k not in found or (k not in waiting and not c.understands(found[k]))}
    if lost:
        if watcher is not None:
            watcher.unreadable(len(lost))
            watcher.started(len(lost), 0)
        ledger.forget(list(lost))
        _run(lost, ledger, executor, False, watcher)
        found |= ledger.measurements(lost)
    if by_key.keys() - found:
        raise InvalidInput(f"the ledger {ledger.path} is damaged: what it keeps cannot be read; name another")
    return {key: found[key] for key in by_key}


def _run(
    waiting: Mapping[str, Case], ledger: Ledger, executor: RepeatingExecutor, fresh: bool, watcher: Watcher | None
) -> None:
    """Run cases, those that take long first, and keep what comes of each; all but those that others run meanwhile."""

    def left(case: Case) -> bool:
        return fresh or bool(_unfinished({case.key: case}, ledger, executor.limits))

    # Else in the order of the keys, which is as good as shuffled: the rate so far is the rate to come.
    ordered = sorted(waiting.values(), key=lambda case: (-case.effort, case.key))
    claimed = _claimed(ordered, ledger, lambda case: case.key, left, watcher)
    try:
        _fly(claimed, executor, partial(_keep, ledger, executor.limits, fresh, watcher))
    except BaseException:  # Ctrl-C, too: nobody is to wait for what is claimed here
        ledger.claims.close()
        raise


def _keep(
    ledger: Ledger, limits: Limits, fresh: bool, watcher: Watcher | None, case: Case, future: Future[Measurement]
) -> None:
    """Keep what came of a case, and let others have its claim."""
    try:
        measurement = future.result()
    except (WorkerDied, TimeoutError, MemoryError) as error:  # others no case causes by what it is
        ended = Ended.of(error)
        measurement = Measurement(ended.outcome.slug, ended.reason)
    ledger.keep(case, measurement, limits.of(measurement.outcome), replace=fresh)
    ledger.claims.give_back(case.key)
    if watcher is not None:
        watcher.advanced(case, measurement.outcome)


def _unfinished(by_key: Mapping[str, Case], ledger: Ledger, limits: Limits) -> dict[str, Case]:
    finished = ledger.finished(by_key)
    again = {key for key, stop in ledger.stopped(by_key).items() if limits.allow_more(*stop)}
    return {key: by_key[key] for key in by_key.keys() - finished | again}


POLL = 0.1  # [s] between two looks at what other processes have claimed


def _claimed(
    cases: Iterable[AnyCase],
    ledger: Ledger,
    name: Callable[[AnyCase], str],
    left: Callable[[AnyCase], bool],
    watcher: Watcher | None,
) -> Iterator[AnyCase | None]:
    """Yield those that this process has claimed and that are left to do, and None where others have all the rest.

    Args:
        name: by which a case is claimed.
    """
    held = list(cases)
    while held:
        waiting, held = held, []
        for case in waiting:
            if not ledger.claims.take(name(case)):
                held.append(case)
            elif left(case):
                yield case
            else:
                ledger.claims.give_back(name(case))
                if watcher is not None:
                    watcher.advanced(case, "by another process")
        if held:
            yield None


def _fly(
    cases: Iterator[Case | None], executor: RepeatingExecutor, keep: Callable[[Case, Future[Measurement]], None]
) -> None:
    """Run all of them, a bounded number at a time, and keep each as it finishes."""
    flying: dict[Future[Measurement], Case] = {}
    try:
        while True:
            over, others = False, False
            # Asked for every time: a cluster grows and shrinks.
            while len(flying) < executor.in_flight and not (over or others):
                case = next(cases, END)
                over, others = case is END, case is None
                if isinstance(case, Case):
                    flying[executor.submit(on_known_scene, perform, case)] = case
            if over and not flying:
                return
            if not flying:
                time.sleep(POLL)
                continue
            for future in wait(flying, POLL if others else None, FIRST_COMPLETED).done:
                keep(flying[future], future)
                del flying[future]
    except BaseException:  # Ctrl-C, too
        for future in flying:
            future.cancel()
        # What finished beside the error or the interrupt. The ledger may be what failed: then the first error says why.
        with suppress(InvalidInput):
            for future, case in flying.items():
                if future.done() and not future.cancelled() and future.exception() is None:
                    keep(case, future)
        raise


# -- costs ------------------------------------------------------------------------------------------------------------


def time_cases(
    cases: Sequence[RunCase],
    ledger: Ledger,
    *,
    cell_timeout: float | None = None,
    fresh: bool = False,
    watcher: Watcher | None = None,
) -> dict[str, Timing]:
    """Time those cases that the ledger has no timing of on this machine, and give the timings of all.

    Each is timed in a process of this machine's own, whatever ran the cases: figures of different machines do not
    mix. A case that cannot be timed within the limit, or whose process dies, has no timing.

    Args:
        cell_timeout: longest wall time of a timing [s].
        fresh: time them all.
    """
    by_key = {case.key: case for case in cases}
    known = {} if fresh else ledger.timings(by_key, fingerprint())
    if watcher is not None:
        watcher.started(len(by_key), len(known))
    unknown, alone = [case for key, case in by_key.items() if key not in known], f"timing on {fingerprint()}"

    def left(case: RunCase) -> bool:
        return fresh or case.key not in ledger.timings([case.key], fingerprint())

    with LocalProcesses(1, cell_timeout=cell_timeout) as worker:
        # One at a time, of all processes here on this ledger.
        for case in _claimed(unknown, ledger, lambda _: alone, left, watcher):
            if case is None:
                time.sleep(POLL)
                continue
            timing = None
            # A cost that cannot be measured is not a cost; the run's own outcome says what happened to it.
            with suppress(WorkerDied, TimeoutError, MemoryError):
                timing = worker.submit(on_known_scene, _timed, case).result()
            if timing is not None:
                ledger.keep_timing(case, timing)
            ledger.claims.give_back(alone)
            if watcher is not None:
                watcher.advanced(case, "timed" if timing is not None else "without a timing")
    return ledger.timings(by_key, fingerprint())


def _timed(case: RunCase) -> Timing | None:
    return time_run(engine_named(case.settings.engine), case.scene, case.settings)
