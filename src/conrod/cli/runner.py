"""Studies pursued on the ledger and the executor that options ask for, and the progress of their runs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self, TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from conrod.cli import say
from conrod.cli.options import RunOptions
from conrod.report.terminal import console as standard_console
from conrod.runs.trajectory import Outcome
from conrod.studies.execution.dispatch import Watcher, run_cases, time_cases
from conrod.studies.execution.local import RepeatingExecutor
from conrod.studies.execution.worker_process import take_blas_buffer
from conrod.studies.frame.case import Case, Measurement, Study, pursue
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.run import RunCase

if TYPE_CHECKING:
    from conrod.studies.frame.timing import Timing
    from conrod.studies.releases import VersionCase

Found = TypeVar("Found")
# Rates are taken over this many seconds: cases of one sweep differ a thousandfold.
SPEED_PERIOD = 120.0


@dataclass(frozen=True)
class Runner:
    """Runs cells and times them, with progress, each kept in the ledger as it finishes."""

    ledger: Ledger
    options: RunOptions
    executor: RepeatingExecutor

    @classmethod
    @contextmanager
    def of(cls, options: RunOptions) -> Iterator[Self]:
        """A runner on the ledger that the options name; an interrupt says how to go on.

        Raises:
            InvalidInput: options that exclude each other, or too little memory to work out anything.
        """
        take_blas_buffer()
        path = options.ledger_file
        # What the executor refuses is refused before there is a ledger.
        with options.executor() as executor, Ledger.open(path) as ledger:
            try:
                yield cls(ledger, options, executor)
            except KeyboardInterrupt:
                say(f"conrod: finished runs are kept in {path}; the same command goes on from there", err=True)
                raise

    @contextmanager
    def answering(self) -> Iterator[Callable[[Sequence[Case]], dict[str, Measurement]]]:
        """A function that gives the measurements of cells, batch after batch: one bar."""
        answered: dict[str, Measurement] = {}
        with ProgressBar("runs") as bar:

            def answer(cells: Sequence[Case]) -> dict[str, Measurement]:
                # What is asked for twice runs once, with --fresh too.
                new = [cell for cell in cells if cell.key not in answered]
                fresh = self.options.fresh
                answered.update(run_cases(new, self.ledger, self.executor, fresh=fresh, watcher=bar))
                return {cell.key: answered[cell.key] for cell in cells}

            yield answer

    def pursue(self, studies: Sequence[Study[Found]]) -> list[Found]:
        """The findings of studies, whose runs go side by side."""
        with self.answering() as run:
            return pursue(studies, run)

    def run_alone(self, cells: Sequence[Case], description: str) -> dict[str, Measurement]:
        """Measurements of cells, one at a time on this machine, for cases that measure how long something takes."""
        fresh = self.options.fresh
        with self.options.processes(1) as executor, ProgressBar(description) as bar:
            return run_cases(cells, self.ledger, executor, fresh=fresh, watcher=bar)

    def run_in_release(self, requirement: str, cells: Sequence[VersionCase]) -> dict[str, Measurement]:
        """Measurements of cells of a release, in processes that have it, which is installed where it has to be.

        Raises:
            InvalidInput: it cannot be had.
        """
        from conrod.studies.releases import interpreter

        keys = {cell.key for cell in cells}
        kept = {} if self.options.fresh else self.ledger.measurements(keys)
        if kept.keys() >= keys:
            return kept
        with ProgressBar(f"runs of {requirement}") as bar:
            python = interpreter(cells[0].settings.engine, requirement, cells[0].version)
            with self.options.processes(interpreter=python) as executor:
                return run_cases(cells, self.ledger, executor, fresh=self.options.fresh, watcher=bar)

    def time(self, cells: list[RunCase]) -> dict[str, Timing]:
        """Timings of all cells that can be timed, one at a time on this machine."""
        fresh = self.options.fresh
        with ProgressBar("costs", "timed") as bar:
            return time_cases(cells, self.ledger, cell_timeout=self.options.timeout, fresh=fresh, watcher=bar)


class ProgressBar(Progress, Watcher):
    """Progress of cases on standard error: a bar where that is a terminal, otherwise a line at either end.

    A watcher of `run_cases`, also called again and again, each time with what the answers so far ask for, and of
    `time_cases`; a context manager, because it has to be taken down again.
    """

    def __init__(self, description: str, usual: str = Outcome.COMPLETED.slug, console: Console | None = None) -> None:
        """Show nothing yet; cases that end as is `usual` are not counted apart."""
        console = standard_console(stderr=True) if console is None else console
        columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
        hidden, period = not console.is_terminal, SPEED_PERIOD
        super().__init__(*columns, console=console, transient=True, speed_estimate_period=period, disable=hidden)
        self.add_task(description, start=False, total=None)
        self._usual, self._ended = usual, Counter[str]()

    def stop(self) -> None:
        if not self.disable:  # before rich 15 one that shows nothing ends with an empty line
            super().stop()
        (task,) = self.tasks
        if task.started:
            text = f"{task.description}: {self._ended.total()} done in {task.elapsed:.1f} s"
            others = [f"{n} {how}" for how, n in sorted(self._ended.items()) if how != self._usual]
            self._say(f"{text}, of which {', '.join(others)}" if others else text)

    def started(self, total: int, already_finished: int) -> None:
        (task,), new = self.tasks, total - already_finished
        if self.disable:
            more = "more " if task.started else ""
            self._say(f"{task.description}: {new} {more}to do, {already_finished} in the ledger")
        self.start_task(task.id)
        self.update(task.id, total=(task.total or 0) + new)

    def unreadable(self, count: int) -> None:
        self._say(f"{self.tasks[0].description}: {count} in the ledger cannot be read and count as not run; made again")

    def advanced(self, case: Case, how: str) -> None:
        self._ended[how] += 1
        self.advance(self.tasks[0].id)

    def _say(self, text: str) -> None:
        self.console.print(text, markup=False, soft_wrap=True)
