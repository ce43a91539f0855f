"""Costs of cases, measured one at a time and beside nothing else, and kept as they come."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from conrod.engines import engine_named
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.execution.worker import on_known_scene
from conrod.studies.execution.worker_process import WorkerDied
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing, fingerprint, time_run


class CostWatcher(Protocol):
    """Receiver of the progress, in the thread that called."""

    def started(self, total: int, already_finished: int) -> None:
        """There are so many different cases, of which so many have been timed before."""
        ...

    def timed(self, case: RunCase, timing: Timing | None) -> None:
        """A case has been timed, or could not be."""
        ...


def time_cases(
    cases: Sequence[RunCase],
    ledger: Ledger,
    *,
    cell_timeout: float | None = None,
    fresh: bool = False,
    watcher: CostWatcher | None = None,
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
    waiting = [case for key, case in by_key.items() if key not in known]
    if watcher is not None:
        watcher.started(len(by_key), len(known))
    with LocalProcesses(1, cell_timeout=cell_timeout) as worker:
        for case in waiting:
            timing = _timing(worker, case)
            if timing is not None:
                ledger.keep_timing(case, timing)
            if watcher is not None:
                watcher.timed(case, timing)
    return ledger.timings(by_key, fingerprint())


def time_case(case: RunCase) -> Timing | None:
    """Time one case, in the process that calls."""
    return time_run(engine_named(case.settings.engine), case.scene, case.settings)


def _timing(worker: LocalProcesses, case: RunCase) -> Timing | None:
    try:
        return worker.submit(on_known_scene, time_case, case).result()
    except (WorkerDied, TimeoutError, MemoryError):
        return None  # a cost that cannot be measured is not a cost; the run's own outcome says what happened to it
