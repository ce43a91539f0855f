"""Run cases in an executor, or time them one by one, and keep each result immediately."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

from conrod.engines import engine_named
from conrod.engines.plugin_values import EngineFault
from conrod.errors import InvalidInput
from conrod.execution.case import Case, CaseResult, Results
from conrod.execution.kept_results import RESULTS_AT_ONCE, KeptResults
from conrod.execution.ledger import Ledger
from conrod.execution.local import FailedCall, LocalProcesses, RetryingExecutor
from conrod.execution.worker import call_with_cached_scene, perform
from conrod.execution.worker_process import CallLimits, WorkerDied

if TYPE_CHECKING:
    from conrod.execution.run import RunCase
    from conrod.execution.timing import Timing

AnyCase = TypeVar("AnyCase", bound=Case)
Result = TypeVar("Result")


class Watcher:
    """Callbacks on the progress of cases, in the calling thread; this base class ignores them."""

    def on_start(self, total: int, already_finished: int) -> None:
        """Called when cases begin to run: their number, and how many have a result already."""

    def on_emptied(self, count: int) -> None:
        """Called with the number of runs of an older conrod that were removed from the ledger."""

    def on_unreadable(self, count: int) -> None:
        """Called with the number of cases that run again, because their ledger rows are unreadable."""

    def on_case_end(self, case: Case, how: str) -> None:
        """Called when the result of a case has been kept, with the word for how it ended."""


SILENT_WATCHER = Watcher()


def run_cases(
    cases: Sequence[Case],
    ledger: Ledger,
    executor: RetryingExecutor,
    *,
    fresh: bool = False,
    watcher: Watcher = SILENT_WATCHER,
) -> Results:
    """Run the cases that have no result in the ledger, and return the results of all.

    A case that kills its process, or ends at a limit of the executor, has that as its outcome. A case that ended at a
    limit runs again if the limit is wider now, and a case whose row cannot be read runs again. An error or Ctrl-C
    cancels waiting cases, keeps finished ones and is raised. A case that another process on the ledger runs is left
    to that process, and run here only if it gives no result.

    Args:
        fresh: run all cases.

    Raises:
        InvalidInput: as `Case.perform`, `Ledger.keep` and the executor.

    Returns:
        Results by key, each of its case's own class, in the order of the cases; they do not depend on the order in
        which cases finished, or on the process that ran them. Of very many cases they are read when they are asked for,
        while ledger and executor are open; so is what of them cannot be read found, and made again, only then.
    """
    if ledger.emptied:
        watcher.on_emptied(ledger.emptied)
        ledger.emptied = 0
    by_key = {case.key: case for case in cases}
    waiting = by_key if fresh else _unfinished_cases(by_key, ledger, executor.limits)
    watcher.on_start(len(by_key), len(by_key) - len(waiting))
    _run_and_keep(waiting, ledger, executor, fresh, watcher)

    def read_block(block: Mapping[str, Case]) -> dict[str, Any]:
        return _read_or_run_again(block, ledger, executor, watcher)

    return KeptResults(by_key, read_block) if len(by_key) > RESULTS_AT_ONCE else read_block(by_key)


def _read_or_run_again(
    by_key: Mapping[str, Case], ledger: Ledger, executor: RetryingExecutor, watcher: Watcher
) -> dict[str, Any]:
    """Return results of finished cases by key; run the cases whose rows cannot be read once more."""
    found = ledger.results(by_key)
    lost = {key: case for key, case in by_key.items() if key not in found}
    if lost:
        watcher.on_unreadable(len(lost))
        watcher.on_start(len(lost), 0)
        ledger.forget(list(lost))
        _run_and_keep(lost, ledger, executor, False, watcher)
        found |= ledger.results(lost)
    if by_key.keys() - found:
        raise InvalidInput(f"the ledger {ledger.path} is damaged: what it keeps cannot be read; name another")
    return {key: found[key] for key in by_key}


def _unfinished_cases(by_key: Mapping[str, Case], ledger: Ledger, limits: CallLimits) -> dict[str, Case]:
    """Return the cases, by key, that have no result, or ended at a limit that is wider now."""
    finished = ledger.finished_keys(by_key)
    again = {key for key, stop in ledger.stops_at_limits(by_key).items() if limits.allow_more(*stop)}
    return {key: by_key[key] for key in by_key.keys() - finished | again}


def _run_and_keep(
    waiting: Mapping[str, Case], ledger: Ledger, executor: RetryingExecutor, fresh: bool, watcher: Watcher
) -> None:
    """Run the cases that no other process runs meanwhile, longest first, and keep each result."""
    shared = dict[tuple[Any, ...], Any]()

    def share(case: Case) -> Case:
        if (call := case.shared_call) is None:
            return case
        asked = call, *case.shared_arguments
        if asked not in shared:
            # Where it fails each case makes the call itself, and fails as any other.
            with suppress(WorkerDied, TimeoutError, MemoryError):
                shared[asked] = executor.submit(*asked).result()
        return case.with_shared(shared[asked]) if asked in shared else case

    def keep_result(case: Case, future: Future[CaseResult | FailedCall]) -> str:
        try:
            ended = future.result()
        except (WorkerDied, TimeoutError, MemoryError) as error:  # a case cannot cause other errors
            ended = FailedCall.from_error(error)
        # Of a failed call these two alone are kept: to make the whole result may take long, as a free motion's.
        result = CaseResult(ended.outcome.slug, ended.reason) if isinstance(ended, FailedCall) else ended
        ledger.keep(case, result, executor.limits.limit_for(result.outcome), replace=fresh)
        return result.outcome

    _process_unclaimed(
        # Equal efforts in the order of the keys, which is as good as random: so the rate predicts the end.
        sorted(waiting.values(), key=lambda case: (-case.effort, case.key)),
        ledger,
        watcher,
        claim_name=lambda case: case.key,
        is_unfinished=lambda case: fresh or bool(_unfinished_cases({case.key: case}, ledger, executor.limits)),
        submit=lambda case: executor.submit(call_with_cached_scene, perform, share(case)),
        keep_result=keep_result,
        # Read before every submission: a cluster grows and shrinks.
        max_in_flight=lambda: executor.in_flight,
    )


POLL_INTERVAL = 0.1  # [s], between two looks at the claims of other processes


def _process_unclaimed(
    cases: Iterable[AnyCase],
    ledger: Ledger,
    watcher: Watcher,
    claim_name: Callable[[AnyCase], str],
    is_unfinished: Callable[[AnyCase], bool],
    submit: Callable[[AnyCase], Future[Result]],
    keep_result: Callable[[AnyCase, Future[Result]], str],
    max_in_flight: Callable[[], int],
) -> None:
    """Submit all cases that no other process has claimed on the ledger, and keep the results.

    Args:
        claim_name: name by which a case is claimed.
        is_unfinished: whether a case, once it is claimed, still has no result.
        submit: submits a case to an executor.
        keep_result: keeps the result of a case, and returns how the case ended.
        max_in_flight: number of cases to be submitted at a time.
    """
    waiting, flying = deque(cases), dict[Future[Result], AnyCase]()

    def end_case(case: AnyCase, how: str) -> None:
        ledger.claims.give_back(claim_name(case))
        watcher.on_case_end(case, how)

    try:
        while waiting or flying:
            for _ in range(len(waiting)):
                if len(flying) >= max_in_flight():
                    break
                case = waiting.popleft()
                if not ledger.claims.take(claim_name(case)):
                    waiting.append(case)
                elif is_unfinished(case):
                    flying[submit(case)] = case
                else:
                    end_case(case, "by another process")
            if not flying and waiting:
                time.sleep(POLL_INTERVAL)
            for future in wait(flying, POLL_INTERVAL if waiting else None, FIRST_COMPLETED).done:
                end_case(flying[future], keep_result(flying[future], future))
                del flying[future]
    except BaseException:  # Ctrl-C, too
        # If the ledger itself failed, the first error says why.
        with suppress(InvalidInput):
            for future in _cancel_waiting(flying):
                end_case(flying[future], keep_result(flying[future], future))
        ledger.claims.close()  # or other processes would wait for the cases claimed here
        raise


def _cancel_waiting(flying: Iterable[Future[Result]]) -> list[Future[Result]]:
    """Cancel the futures that have not begun, and return the futures with a result."""
    for future in flying:
        future.cancel()
    return [one for one in flying if one.done() and not one.cancelled() and one.exception() is None]


# -- timings ----------------------------------------------------------------------------------------------------------


def time_cases(
    cases: Sequence[RunCase],
    ledger: Ledger,
    *,
    timeout: float | None = None,
    fresh: bool = False,
    watcher: Watcher = SILENT_WATCHER,
) -> dict[str, Timing]:
    """Time the cases that the ledger has no timing of; return the timings of all by key.

    Each is timed in a process of this machine, even if its run was made on a cluster: timings of different machines
    cannot be compared. A case that cannot be timed within the limit, or whose process dies, has no timing.

    Args:
        timeout: longest wall time of a timing [s].
        fresh: time all cases.
    """
    from conrod.execution.timing import machine_fingerprint

    by_key = {case.key: case for case in cases}
    known = {} if fresh else ledger.timings(by_key, machine_fingerprint())
    watcher.on_start(len(by_key), len(known))

    def keep_timing(case: RunCase, future: Future[Timing | None]) -> str:
        timing = None
        # The outcome of the run says what went wrong; a failed timing adds nothing to it.
        with suppress(WorkerDied, TimeoutError, MemoryError, EngineFault):
            timing = future.result()
        if timing is None:
            return "without a timing"
        ledger.keep_timing(case, timing)
        return "timed"

    with LocalProcesses(1, timeout=timeout) as worker:
        _process_unclaimed(
            [case for key, case in by_key.items() if key not in known],
            ledger,
            watcher,
            # One timing at a time, by all processes of this machine on this ledger.
            claim_name=lambda _: f"timing on {machine_fingerprint()}",
            is_unfinished=lambda case: fresh or case.key not in ledger.timings([case.key], machine_fingerprint()),
            submit=lambda case: worker.submit(call_with_cached_scene, _time_case, case),
            keep_result=keep_timing,
            max_in_flight=lambda: 1,
        )
    return ledger.timings(by_key, machine_fingerprint())


def _time_case(case: RunCase) -> Timing | None:
    """Time the run of a case in this process; None if its engine cannot be timed."""
    from conrod.execution.timing import time_run

    return time_run(engine_named(case.settings.engine), case.scene, case.settings)
