"""Progress of a run of cells on standard error: a bar where that is a terminal, otherwise a line at either end."""

from __future__ import annotations

import time
from collections import Counter
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from conrod.studies.cell import Cell
from conrod.studies.measurement import Measurement
from conrod.trajectory import Outcome

# Rates are taken over this many seconds: cells of one sweep differ a thousandfold.
SPEED_PERIOD = 120.0


class RateColumn(ProgressColumn):
    """Runs finished in a second."""

    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        return Text("" if speed is None else f"{speed:.3g} runs/s")


class ProgressBar:
    """A watcher of `run_cells`; a context manager, because a bar has to be taken down again."""

    def __init__(self, description: str = "runs", console: Console | None = None) -> None:
        self._description = description
        self._console = Console(stderr=True, highlight=False) if console is None else console
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            RateColumn(),
            TimeRemainingColumn(),
            console=self._console,
            transient=True,
            speed_estimate_period=SPEED_PERIOD,
            disable=not self._console.is_terminal,
        )
        self._task = self._bar.add_task(description, total=None)
        self._ended: Counter[str] = Counter()
        self._begun = 0.0

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._bar.stop()
        if self._begun:
            self._console.print(self._summary(), markup=False, soft_wrap=True)

    def started(self, total: int, already_finished: int) -> None:
        """There are so many different cells, of which so many need not run."""
        self._begun, self._ended = time.monotonic(), Counter()
        to_do = total - already_finished
        if self._console.is_terminal:
            self._bar.reset(self._task, total=to_do, description=self._description)
        else:
            text = f"{self._description}: {to_do} to do, {already_finished} of {total} in the ledger"
            self._console.print(text, markup=False, soft_wrap=True)

    def advanced(self, cell: Cell, measurement: Measurement) -> None:
        """A cell has run and its result is kept."""
        self._ended[measurement.outcome] += 1
        self._bar.advance(self._task)

    def _summary(self) -> str:
        seconds = time.monotonic() - self._begun
        text = f"{self._description}: {self._ended.total()} done in {seconds:.1f} s"
        others = [f"{n} {slug}" for slug, n in sorted(self._ended.items()) if slug != Outcome.COMPLETED.slug]
        return f"{text}, of which {', '.join(others)}" if others else text
