"""Cases handed to an executor, or timed one by one, and each result kept the moment it is there."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import suppress
from typing import TypeVar

from conrod.engines import engine_named
from conrod.engines.plugin_values import EngineFault
from conrod.errors import InvalidInput
from conrod.studies.execution.local import Ended, LocalProcesses, RepeatingExecutor
from conrod.studies.execution.worker import on_known_scene, perform
from conrod.studies.execution.worker_process import Limits, WorkerDied
from conrod.studies.frame.case import Case, Measurement
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing, machine_fingerprint, time_run

AnyCase = TypeVar("AnyCase", bound=Case)
Result = TypeVar("Result")


class Watcher:
    """Receiver of the progress, in the thread that called; one that says nothing."""

    def started(self, total: int, already_finished: int) -> None:
        """There are so many different cases, of which so many need not run."""

    def unreadable(self, count: int) -> None:
        """So many runs are damaged in the ledger, or in the form of another conrod; they are made again."""

    def advanced(self, case: Case, how: str) -> None:
        """A case has ended so, and what came of it is kept."""


SILENT = Watcher()


def run_cases(
    cases: Sequence[Case],
    ledger: Ledger,
    executor: RepeatingExecutor,
    *,
    fresh: bool = False,
    watcher: Watcher = SILENT,
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
    watcher.started(len(by_key), len(by_key) - len(waiting))
    _run(waiting, ledger, executor, fresh, watcher)
    found = ledger.measurements(by_key)
    lost = {k: c for k, c in by_key.items() if k not in found or (k not in waiting and not c.can_read(found[k]))}
    if lost:
        watcher.unreadable(len(lost))
        watcher.started(len(lost), 0)
        ledger.forget(list(lost))
        _run(lost, ledger, executor, False, watcher)
        found |= ledger.measurements(lost)
    if by_key.keys() - found:
        raise InvalidInput(f"the ledger {ledger.path} is damaged: what it keeps cannot be read; name another")
    return {key: found[key] for key in by_key}


def _unfinished(by_key: Mapping[str, Case], ledger: Ledger, limits: Limits) -> dict[str, Case]:
    finished = ledger.finished_keys(by_key)
    again = {key for key, stop in ledger.stops_at_limits(by_key).items() if limits.allow_more(*stop)}
    return {key: by_key[key] for key in by_key.keys() - finished | again}


def _run(
    waiting: Mapping[str, Case], ledger: Ledger, executor: RepeatingExecutor, fresh: bool, watcher: Watcher
) -> None:
    """Run cases, those that take long first, and keep what comes of each; all but those that others run meanwhile."""

    def keep(case: Case, future: Future[Measurement]) -> str:
        try:
            measurement = future.result()
        except (WorkerDied, TimeoutError, MemoryError) as error:  # others no case causes by what it is
            ended = Ended.of(error)
            measurement = Measurement(ended.outcome.slug, ended.reason)
        ledger.keep(case, measurement, executor.limits.of(measurement.outcome), replace=fresh)
        return measurement.outcome

    _share(
        # Else in the order of the keys, which is as good as shuffled: the rate so far is the rate to come.
        sorted(waiting.values(), key=lambda case: (-case.effort, case.key)),
        ledger,
        watcher,
        claim=lambda case: case.key,
        left=lambda case: fresh or bool(_unfinished({case.key: case}, ledger, executor.limits)),
        begin=lambda case: executor.submit(on_known_scene, perform, case),
        keep=keep,
        # Asked for every time: a cluster grows and shrinks.
        most=lambda: executor.in_flight,
    )


POLL = 0.1  # [s] between two looks at what other processes have claimed


def _share(
    cases: Iterable[AnyCase],
    ledger: Ledger,
    watcher: Watcher,
    claim: Callable[[AnyCase], str],
    left: Callable[[AnyCase], bool],
    begin: Callable[[AnyCase], Future[Result]],
    keep: Callable[[AnyCase, Future[Result]], str],
    most: Callable[[], int],
) -> None:
    """Do all cases that no other process on the ledger does; an error or Ctrl-C cancels what waits.

    Args:
        claim: name by which a case is claimed.
        left: whether a case is to be done still, once it is claimed.
        begin: hands it over.
        keep: keeps what came of it, and says how it ended.
        most: that are to be handed over at a time.
    """
    waiting, flying = deque(cases), dict[Future[Result], AnyCase]()

    def end(case: AnyCase, how: str) -> None:
        ledger.claims.give_back(claim(case))
        watcher.advanced(case, how)

    try:
        while waiting or flying:
            for _ in range(len(waiting)):
                if len(flying) >= most():
                    break
                case = waiting.popleft()
                if not ledger.claims.take(claim(case)):
                    waiting.append(case)
                elif left(case):
                    flying[begin(case)] = case
                else:
                    end(case, "by another process")
            if not flying and waiting:
                time.sleep(POLL)
            for future in wait(flying, POLL if waiting else None, FIRST_COMPLETED).done:
                end(flying[future], keep(flying[future], future))
                del flying[future]
    except BaseException:  # Ctrl-C, too
        # The ledger may be what failed: then the first error says why.
        with suppress(InvalidInput):
            for future in _completed(flying):
                end(flying[future], keep(flying[future], future))
        ledger.claims.close()  # nobody is to wait for what is claimed here
        raise


def _completed(flying: Iterable[Future[Result]]) -> list[Future[Result]]:
    """Those that have a result; the others are cancelled."""
    for future in flying:
        future.cancel()
    return [one for one in flying if one.done() and not one.cancelled() and one.exception() is None]


# -- costs ------------------------------------------------------------------------------------------------------------


def time_cases(
    cases: Sequence[RunCase],
    ledger: Ledger,
    *,
    cell_timeout: float | None = None,
    fresh: bool = False,
    watcher: Watcher = SILENT,
) -> dict[str, Timing]:
    """Time those cases that the ledger has no timing of on this machine, and give the timings of all.

    Each is timed in a process of this machine's own, whatever ran the cases: figures of different machines do not
    mix. A case that cannot be timed within the limit, or whose process dies, has no timing.

    Args:
        cell_timeout: longest wall time of a timing [s].
        fresh: time them all.
    """
    by_key = {case.key: case for case in cases}
    known = {} if fresh else ledger.timings(by_key, machine_fingerprint())
    watcher.started(len(by_key), len(known))

    def keep(case: RunCase, future: Future[Timing | None]) -> str:
        timing = None
        # A cost that cannot be measured is not a cost; the run's own outcome says what happened to it.
        with suppress(WorkerDied, TimeoutError, MemoryError, EngineFault):
            timing = future.result()
        if timing is None:
            return "without a timing"
        ledger.keep_timing(case, timing)
        return "timed"

    with LocalProcesses(1, cell_timeout=cell_timeout) as worker:
        _share(
            [case for key, case in by_key.items() if key not in known],
            ledger,
            watcher,
            # One at a time, of all processes here on this ledger.
            claim=lambda _: f"timing on {machine_fingerprint()}",
            left=lambda case: fresh or case.key not in ledger.timings([case.key], machine_fingerprint()),
            begin=lambda case: worker.submit(on_known_scene, _timed, case),
            keep=keep,
            most=lambda: 1,
        )
    return ledger.timings(by_key, machine_fingerprint())


def _timed(case: RunCase) -> Timing | None:
    return time_run(engine_named(case.settings.engine), case.scene, case.settings)
