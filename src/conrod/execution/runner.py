"""How all studies make and keep runs: executor, limits of a run, ledger of finished runs."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Self, TypeAlias, TypeVar

from conrod.errors import InvalidInput
from conrod.execution.case import Case, Results, ResultsOfRounds, Study, pursue
from conrod.execution.dispatch import SILENT_WATCHER, Watcher, run_cases, time_cases
from conrod.execution.ledger import Ledger, default_ledger_path
from conrod.execution.local import LocalProcesses, RetryingExecutor
from conrod.execution.worker_process import allocate_blas_buffer
from conrod.system import can_limit_memory

if TYPE_CHECKING:
    from conrod.execution.releases import VersionCase
    from conrod.execution.run import RunCase
    from conrod.execution.timing import Timing

Found = TypeVar("Found")
RUN_TIMEOUT = 600.0  # [s]
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

    def time(self, cases: list[RunCase]) -> dict[str, Timing]:
        """Time cases one at a time on this machine; return the timings by key."""
        fresh = self.runs.fresh
        with self.runs.progress("costs", "timed") as watcher:
            return time_cases(cases, self.ledger, timeout=self.runs.timeout, fresh=fresh, watcher=watcher)
