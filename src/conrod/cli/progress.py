"""Progress of runs on standard error."""

from __future__ import annotations

from collections import Counter

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from conrod.comparison.trajectory import Outcome
from conrod.execution.case import Case
from conrod.execution.dispatch import Watcher
from conrod.report.terminal import console as standard_console

# Rates are taken over this many seconds: cases of one sweep differ a thousandfold.
SPEED_PERIOD = 120.0


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

    def on_start(self, total: int, already_finished: int) -> None:
        (task,), new = self.tasks, total - already_finished
        if self.disable:
            more = "more " if task.started else ""
            self._say(f"{task.description}: {new} {more}to do, {already_finished} in the ledger")
        self.start_task(task.id)
        self.update(task.id, total=(task.total or 0) + new)

    def on_emptied(self, count: int) -> None:
        self._say(f"{self.tasks[0].description}: the ledger's {count} runs are of an older conrod and are made again")

    def on_unreadable(self, count: int) -> None:
        self._say(f"{self.tasks[0].description}: {count} in the ledger cannot be read and count as not run; made again")

    def on_case_end(self, case: Case, how: str) -> None:
        self._ended[how] += 1
        self.advance(self.tasks[0].id)

    def _say(self, text: str) -> None:
        self.console.print(text, markup=False, soft_wrap=True)
