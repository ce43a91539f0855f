"""Progress of runs on standard error."""

from __future__ import annotations

import time
from collections import Counter
from types import TracebackType
from typing import TYPE_CHECKING, Self

from rich.console import Console

from conrod.comparison.trajectory import Outcome
from conrod.execution.case import Case
from conrod.execution.dispatch import Watcher
from conrod.report.terminal import console as standard_console

if TYPE_CHECKING:
    from rich.progress import Progress

# Rates are taken over this many seconds: cases of one sweep differ a thousandfold.
SPEED_PERIOD = 120.0


class ProgressBar(Watcher):
    """Progress of cases on standard error: a bar where that is a terminal, otherwise a line at either end.

    A watcher of `run_cases`, also called again and again, each time with what the answers so far ask for, and of
    `time_cases`; a context manager, because it has to be taken down again.
    """

    def __init__(self, description: str, usual: str = Outcome.COMPLETED.slug, console: Console | None = None) -> None:
        """Show nothing yet; cases that end as is `usual` are not counted apart."""
        self.console = standard_console(stderr=True) if console is None else console
        self._description, self._usual, self._ended = description, usual, Counter[str]()
        self._begun: float | None = None  # [s], when the first cases began
        self._bar: Progress | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._bar:
            self._bar.stop()
        if self._begun is not None:
            text = f"{self._description}: {self._ended.total()} done in {time.monotonic() - self._begun:.1f} s"
            others = [f"{n} {how}" for how, n in sorted(self._ended.items()) if how != self._usual]
            self._say(f"{text}, of which {', '.join(others)}" if others else text)

    def on_start(self, total: int, already_finished: int) -> None:
        new = total - already_finished
        if not self.console.is_terminal:
            more = "" if self._begun is None else "more "
            self._say(f"{self._description}: {new} {more}to do, {already_finished} in the ledger")
        elif self._bar or new:
            self._bar = self._bar or _new_bar(self._description, self.console)
            (task,) = self._bar.tasks
            self._bar.update(task.id, total=(task.total or 0) + new)
        self._begun = time.monotonic() if self._begun is None else self._begun

    def on_emptied(self, count: int) -> None:
        self._say(f"{self._description}: the ledger's {count} runs are of an older conrod and are made again")

    def on_unreadable(self, count: int) -> None:
        self._say(f"{self._description}: {count} in the ledger cannot be read and count as not run; made again")

    def on_case_end(self, case: Case, how: str) -> None:
        self._ended[how] += 1
        if self._bar:
            self._bar.advance(self._bar.task_ids[0])

    def _say(self, text: str) -> None:
        self.console.print(text, markup=False, soft_wrap=True)


def _new_bar(description: str, console: Console) -> Progress:
    """Show a new bar in a terminal."""
    # Imported where there is something to wait for: it takes as long as all that the ledger answers.
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    bar = Progress(*columns, console=console, transient=True, speed_estimate_period=SPEED_PERIOD)
    bar.add_task(description, total=0)
    bar.start()
    return bar
