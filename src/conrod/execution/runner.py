"""How all studies make and keep runs: executor, limits of a run, ledger of finished runs, and which are left to run."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Self, TypeAlias, TypeVar

from conrod.errors import InvalidInput
from conrod.execution.case import (
    RESULTS_AT_ONCE,
    Case,
    CaseResult,
    KeptResults,
    Results,
    ResultsOfRounds,
    Study,
    pursue,
)
from conrod.execution.ledger import Ledger, default_ledger_path
from conrod.execution.local import FailedCall, LocalProcesses, RetryingExecutor
from conrod.execution.worker import call_with_cached_scene, perform
from conrod.execution.worker_process import CallLimits, WorkerDied, allocate_blas_buffer
from conrod.system import can_limit_memory

if TYPE_CHECKING:
    from conrod.execution.releases import VersionCase

AnyCase = TypeVar("AnyCase", bound=Case)
Found = TypeVar("Found")
Result = TypeVar("Result")
RUN_TIMEOUT = 600.0  # [s]
POLL_INTERVAL = 0.1  # [s], between two looks at the claims of other processes


class Watcher:
    """Callbacks on the progress of cases, in the calling thread; this base class ignores them."""

    def on_start(self, total: int, already_finished: int) -> None:
        """Called when cases begin to run: their number, and how many have a result already."""

    def on_note(self, text: str) -> None:
        """Called with a line on what is to be expected, before the cases begin."""

    def on_emptied(self, count: int) -> None:
        """Called with the number of runs of an older conrod that were removed from the ledger."""

    def on_unreadable(self, count: int) -> None:
        """Called with the number of cases that run again, because their ledger rows are unreadable."""

    def on_case_end(self, case: Case | None, how: str) -> None:
        """Called when the result of a case has been kept, with the word for how it ended."""


SILENT_WATCHER = Watcher()
# Makes a watcher of progress from a description of the runs, and the outcome that most of them have.
Progress: TypeAlias = Callable[[str, str], AbstractContextManager[Watcher]]


def no_progress(description: str, usual: str = "completed") -> AbstractContextManager[Watcher]:
    """Return a watcher of runs that shows nothing."""
    return nullcontext(SILENT_WATCHER)


@dataclass(frozen=True)
class Runs:
    """Options on how the runs of a study are made, and where finished runs are kept.

    Attributes:
        ledger: file of finished runs, which are never run again; None for the user's ledger.
        fresh: whether runs that the ledger has are made again.
        jobs: processes on this machine at a time; None for one per core.
        cluster: address of a Dask scheduler, such as "tcp://host:8786"; None for processes of this machine.
        timeout: longest wall time of a run [s].
        memory: largest memory of a run [bytes]; None without limit.
        progress: makes the watcher that shows progress.
    """

    ledger: str | Path | None = None
    fresh: bool = False
    jobs: int | None = None
    cluster: str | None = None
    timeout: float = RUN_TIMEOUT
    memory: int | None = None
    progress: Progress = no_progress

    @property
    def ledger_file(self) -> Path:
        """File of the ledger: `ledger`, or the user's ledger if that is None."""
        return default_ledger_path() if self.ledger is None else Path(self.ledger)

    def processes(self, jobs: int | None = None, interpreter: str | None = None) -> LocalProcesses:
        """Return an executor in processes of this machine, by default with `self.jobs` of them.

        Raises:
            InvalidInput: runs are to be limited in memory, which this system cannot do.
        """
        if self.memory is not None and not can_limit_memory():
            raise InvalidInput("--cell-memory: this system cannot limit the memory of a run; leave it out")
        jobs = jobs or (available_cores() if self.jobs is None else self.jobs)
        return LocalProcesses(jobs, timeout=self.timeout, memory=self.memory, interpreter=interpreter)

    def executor(self) -> RetryingExecutor:
        """Return the executor of the runs: on a cluster, or in processes of this machine.

        Raises:
            InvalidInput: options that exclude each other.
        """
        if self.cluster is None:
            return self.processes()
        if self.jobs is not None:
            raise InvalidInput("--jobs does not go with --cluster: the cluster has as many as it has workers")
        from conrod.execution.cluster import DaskCluster

        return DaskCluster(self.cluster, timeout=self.timeout, memory=self.memory)


def available_cores() -> int:
    """Number of cores that this process may use; 1 if the system does not say."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class Runner:
    """The ledger and the executor of a command, which makes and times the runs of its studies."""

    ledger: Ledger
    runs: Runs
    executor: RetryingExecutor

    @classmethod
    @contextmanager
    def open(cls, runs: Runs) -> Iterator[Self]:
        """Open the ledger and start the executor.

        Raises:
            InvalidInput: options that exclude each other, or too little memory for linear algebra.
        """
        allocate_blas_buffer()
        # The executor first: if it refuses, no ledger file is made.
        with runs.executor() as executor, Ledger.open(runs.ledger_file) as ledger:
            yield cls(ledger, runs, executor)

    @contextmanager
    def case_runner(self) -> Iterator[Callable[[Sequence[Case]], Results]]:
        """Yield a function that runs cases, with one progress bar, and returns results by key."""
        rounds: dict[str, Results] = {}  # by the key of each case, all results of the round that ran it
        with self.runs.progress("runs", "completed") as watcher:

            def run(cases: Sequence[Case]) -> Results:
                # A case that two batches ask for runs once, with --fresh too.
                new = [case for case in cases if case.key not in rounds]
                fresh = self.runs.fresh
                rounds.update(
                    dict.fromkeys(
                        (case.key for case in new),
                        run_cases(new, self.ledger, self.executor, fresh=fresh, watcher=watcher),
                    )
                )
                return ResultsOfRounds({case.key: rounds[case.key] for case in cases})

            yield run

    def pursue(self, studies: Sequence[Study[Found]]) -> list[Found]:
        """Run studies together, batch by batch, and return their findings in the same order."""
        with self.case_runner() as run:
            return pursue(studies, run)

    def run_alone(self, cases: Sequence[Case], description: str) -> Results:
        """Run cases one at a time on this machine, for cases that measure wall time."""
        fresh = self.runs.fresh
        with self.runs.processes(1) as executor, self.runs.progress(description, "completed") as watcher:
            return run_cases(cases, self.ledger, executor, fresh=fresh, watcher=watcher)

    def run_in_release(self, requirement: str, cases: Sequence[VersionCase]) -> Results:
        """Run cases with another release of an engine, installed for them in a separate environment.

        Args:
            requirement: name and version of the release, such as "mujoco==3.2.0".

        Raises:
            InvalidInput: the release cannot be installed.
        """
        from conrod.execution.releases import release_interpreter

        by_key = {case.key: case for case in cases}
        kept = {} if self.runs.fresh else self.ledger.results(by_key)
        if kept.keys() >= by_key.keys():
            return kept
        with self.runs.progress(f"runs of {requirement}", "completed") as watcher:
            python = release_interpreter(cases[0].settings.engine, requirement, cases[0].version)
            with self.runs.processes(interpreter=python) as executor:
                return run_cases(cases, self.ledger, executor, fresh=self.runs.fresh, watcher=watcher)


# -- the runs of some cases --------------------------------------------------------------------------------------------


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

    process_unclaimed(
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


def process_unclaimed(
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
    # Not `concurrent.futures.wait`: Ctrl-C amid it leaves futures locked, and cancelling them would wait for ever.
    ended = SimpleQueue[Future[Result]]()

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
                    future = submit(case)
                    flying[future] = case
                    future.add_done_callback(ended.put)
                else:
                    end_case(case, "by another process")
            if not waiting and not flying:
                break
            try:
                future = ended.get(timeout=POLL_INTERVAL if waiting else None)
            except Empty:
                continue
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
