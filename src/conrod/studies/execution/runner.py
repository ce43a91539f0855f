"""How runs are made and kept, for every study: processes or a cluster, limits of a run, the ledger of finished runs."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Self, TypeAlias, TypeVar

from conrod.errors import InvalidInput
from conrod.studies.execution.dispatch import SILENT, Watcher, run_cases, time_cases
from conrod.studies.execution.local import LocalProcesses, RepeatingExecutor
from conrod.studies.execution.worker_process import take_blas_buffer
from conrod.studies.frame.case import Case, Measurement, Study, pursue
from conrod.studies.frame.ledger import Ledger, default_ledger_path
from conrod.studies.frame.run import RunCase

if TYPE_CHECKING:
    from conrod.studies.frame.timing import Timing
    from conrod.studies.releases import VersionCase

Found = TypeVar("Found")
RUN_TIMEOUT = 600.0  # [s]
# Given a description of runs, and how they usually end, a watcher of their progress.
Progress: TypeAlias = Callable[[str, str], AbstractContextManager[Watcher]]


def no_progress(description: str, usual: str = "completed") -> AbstractContextManager[Watcher]:
    """A watcher of runs that shows nothing."""
    return nullcontext(SILENT)


@dataclass(frozen=True)
class Runs:
    """How the runs of a study are made, and where finished ones are kept.

    Attributes:
        ledger: file of finished runs, which are never run again; None for the user's own.
        fresh: whether runs that the ledger has are made again.
        jobs: processes on this machine at a time; None for one a core.
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
        """The ledger that was named, or the user's own."""
        return default_ledger_path() if self.ledger is None else Path(self.ledger)

    def processes(self, jobs: int | None = None, interpreter: str | None = None) -> LocalProcesses:
        """Processes of this machine, as many as were asked for unless a number is given."""
        jobs = jobs or (available_cores() if self.jobs is None else self.jobs)
        return LocalProcesses(jobs, cell_timeout=self.timeout, cell_memory=self.memory, interpreter=interpreter)

    def executor(self) -> RepeatingExecutor:
        """Executor of the runs: a cluster, or processes of this machine.

        Raises:
            InvalidInput: options that exclude each other.
        """
        if self.cluster is None:
            return self.processes()
        if self.jobs is not None:
            raise InvalidInput("--jobs does not go with --cluster: the cluster has as many as it has workers")
        from conrod.studies.execution.cluster import DaskCluster

        return DaskCluster(self.cluster, cell_timeout=self.timeout, cell_memory=self.memory)


def available_cores() -> int:
    """Number of cores that this process may use, as far as the system says."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class Runner:
    """Makes and times the runs of studies, and keeps each in the ledger as it finishes."""

    ledger: Ledger
    runs: Runs
    executor: RepeatingExecutor

    @classmethod
    @contextmanager
    def of(cls, runs: Runs) -> Iterator[Self]:
        """Open the ledger and start the executor.

        Raises:
            InvalidInput: options that exclude each other, or too little memory to work out anything.
        """
        take_blas_buffer()
        # What the executor refuses is refused before there is a ledger.
        with runs.executor() as executor, Ledger.open(runs.ledger_file) as ledger:
            yield cls(ledger, runs, executor)

    @contextmanager
    def answering(self) -> Iterator[Callable[[Sequence[Case]], dict[str, Measurement]]]:
        """Give a function that returns the measurements of cases, batch after batch under one progress bar."""
        answered: dict[str, Measurement] = {}
        with self.runs.progress("runs", "completed") as watcher:

            def answer(cases: Sequence[Case]) -> dict[str, Measurement]:
                # What is asked for twice runs once, with --fresh too.
                new = [case for case in cases if case.key not in answered]
                fresh = self.runs.fresh
                answered.update(run_cases(new, self.ledger, self.executor, fresh=fresh, watcher=watcher))
                return {case.key: answered[case.key] for case in cases}

            yield answer

    def pursue(self, studies: Sequence[Study[Found]]) -> list[Found]:
        """Return the findings of studies, whose runs go side by side."""
        with self.answering() as run:
            return pursue(studies, run)

    def run_alone(self, cases: Sequence[Case], description: str) -> dict[str, Measurement]:
        """Run cases one at a time on this machine, for cases that measure how long something takes."""
        fresh = self.runs.fresh
        with self.runs.processes(1) as executor, self.runs.progress(description, "completed") as watcher:
            return run_cases(cases, self.ledger, executor, fresh=fresh, watcher=watcher)

    def run_in_release(self, requirement: str, cases: Sequence[VersionCase]) -> dict[str, Measurement]:
        """Run cases in processes that have a release of an engine, which is installed where it has to be.

        Raises:
            InvalidInput: it cannot be had.
        """
        from conrod.studies.releases import interpreter

        keys = {case.key for case in cases}
        kept = {} if self.runs.fresh else self.ledger.measurements(keys)
        if kept.keys() >= keys:
            return kept
        with self.runs.progress(f"runs of {requirement}", "completed") as watcher:
            python = interpreter(cases[0].settings.engine, requirement, cases[0].version)
            with self.runs.processes(interpreter=python) as executor:
                return run_cases(cases, self.ledger, executor, fresh=self.runs.fresh, watcher=watcher)

    def time(self, cases: list[RunCase]) -> dict[str, Timing]:
        """Time all cases that can be timed, one at a time on this machine."""
        fresh = self.runs.fresh
        with self.runs.progress("costs", "timed") as watcher:
            return time_cases(cases, self.ledger, cell_timeout=self.runs.timeout, fresh=fresh, watcher=watcher)
