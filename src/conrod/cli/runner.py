"""The ledger and the executor that a command's options ask for."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Self, TypeVar

import click

from conrod.cli.options import RunOptions
from conrod.cli.progress import CostBar, ProgressBar, RoundsBar
from conrod.errors import InvalidInput
from conrod.mechanism.units import parse_quantity
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.frame.case import Case
from conrod.studies.frame.files import check_apart
from conrod.studies.frame.ledger import Ledger, default_path
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.study import Study, pursue

if TYPE_CHECKING:
    from conrod.studies.frame.timing import Timing


Found = TypeVar("Found")
CELL_TIMEOUT = 600.0  # [s]


@dataclass(frozen=True)
class Options(RunOptions):
    """Options on how runs are made, checked and converted."""

    retime: bool = False

    def __post_init__(self) -> None:
        """Refuse options that exclude each other.

        Raises:
            InvalidInput: says which.
        """
        if self.cluster is not None and self.jobs is not None:
            raise InvalidInput("--jobs does not go with --cluster: the cluster has as many as it has workers")

    @property
    def timeout(self) -> float:
        """Longest time of a cell [s]."""
        return CELL_TIMEOUT if self.cell_timeout is None else self.cell_timeout

    @property
    def memory(self) -> int | None:
        """Most memory of a cell [bytes]."""
        return None if self.cell_memory is None else round(parse_quantity("--cell-memory", self.cell_memory, "byte"))

    @property
    def ledger_file(self) -> Path:
        """The ledger that was named, or the user's own."""
        return default_path() if self.ledger is None else Path(self.ledger)

    def executor(self) -> Executor:
        """Executor of the runs: a cluster, or processes of this machine."""
        if self.cluster is not None:
            from conrod.studies.execution.cluster import DaskCluster

            return DaskCluster(self.cluster, cell_timeout=self.timeout, cell_memory=self.memory)
        return self.processes()

    def processes(self) -> LocalProcesses:
        """Processes of this machine."""
        jobs = available_cores() if self.jobs is None else self.jobs
        return LocalProcesses(jobs, cell_timeout=self.timeout, cell_memory=self.memory)


def available_cores() -> int:
    """Cores that this process may use, as far as the system says."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class Runner:
    """Runs cells and times them, with progress, each kept in the ledger as it finishes."""

    ledger: Ledger
    options: Options

    @classmethod
    @contextmanager
    def of(cls, options: RunOptions, document: Path | None = None) -> Iterator[Self]:
        """A runner on the ledger that the options name; an interrupt says how to go on.

        Args:
            document: file that is written when all is done, which the ledger must not be.
        """
        options = options if isinstance(options, Options) else Options(**vars(options))
        path = options.ledger_file
        check_apart({"the ledger": path, **({"--json": document} if document else {})})
        with Ledger.open(path) as ledger:
            try:
                yield cls(ledger, options)
            except KeyboardInterrupt:
                click.echo(f"conrod: finished runs are kept in {path}; the same command goes on from there", err=True)
                raise

    def run(self, cells: Sequence[Case], description: str = "runs") -> dict[str, Measurement]:
        """Measurements of all cells; those that the ledger lacks are run, each."""
        with self.options.executor() as executor, ProgressBar(description) as bar:
            return run_cases(cells, self.ledger, executor, fresh=self.options.fresh, watcher=bar)

    @contextmanager
    def answering(self, description: str = "runs") -> Iterator[Callable[[Sequence[Case]], dict[str, Measurement]]]:
        """A function that gives the measurements of cells, batch after batch: one set of processes, one bar."""
        answered: dict[str, Measurement] = {}
        with self.options.executor() as executor, RoundsBar(description) as bar:

            def answer(cells: Sequence[Case]) -> dict[str, Measurement]:
                # What is asked for twice runs once, with --fresh too.
                new = [cell for cell in cells if cell.key not in answered]
                fresh = self.options.fresh
                answered.update(run_cases(new, self.ledger, executor, fresh=fresh, watcher=bar))
                return {cell.key: answered[cell.key] for cell in cells}

            yield answer

    def pursue(self, study: Study[Found], description: str = "runs") -> Found:
        """The findings of a study."""
        with self.answering(description) as run:
            return pursue([study], run)[0]

    def run_alone(self, cells: Sequence[Case], description: str) -> dict[str, Measurement]:
        """As `run`, one cell at a time on this machine, for cases that measure how long something takes."""
        asked = self.options
        alone = LocalProcesses(1, cell_timeout=asked.timeout, cell_memory=asked.memory)
        with alone as executor, ProgressBar(description) as bar:
            return run_cases(cells, self.ledger, executor, fresh=asked.fresh or asked.retime, watcher=bar)

    def time(self, cells: list[RunCase], description: str = "costs") -> dict[str, Timing]:
        """Timings of all cells that can be timed, one at a time on this machine."""
        from conrod.studies.execution.costs import time_cases

        with CostBar(description) as bar:
            return time_cases(
                cells,
                self.ledger,
                cell_timeout=self.options.timeout,
                fresh=self.options.fresh or self.options.retime,
                watcher=bar,
            )
