"""Progress of cases on standard error: a bar where that is a terminal, otherwise a line at either end."""

from __future__ import annotations

import time
from collections import Counter
from types import TracebackType
from typing import TYPE_CHECKING, Self

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

from conrod.runs.trajectory import Outcome
from conrod.studies.frame.case import Case
from conrod.studies.frame.measurement import Measurement

if TYPE_CHECKING:
    from conrod.studies.frame.timing import Timing


# Rates are taken over this many seconds: cases of one sweep differ a thousandfold.
SPEED_PERIOD = 120.0


class RateColumn(ProgressColumn):
    """Number finished per second."""

    def __init__(self, unit: str) -> None:
        super().__init__()
        self._unit = unit

    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        return Text("" if speed is None else f"{speed:.3g} {self._unit}")


class _Bar:
    """A bar that counts, by how each ended; a context manager, because it has to be taken down again."""

    def __init__(self, description: str, unit: str, usual: str, console: Console | None) -> None:
        self._description = description
        self._usual = usual  # not counted apart at the end
        self._console = Console(stderr=True, highlight=False) if console is None else console
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            RateColumn(unit),
            TimeRemainingColumn(),
            console=self._console,
            transient=True,
            speed_estimate_period=SPEED_PERIOD,
            disable=not self._console.is_terminal,
        )
        self._task = self._bar.add_task(description, total=None)
        self._ended: Counter[str] = Counter()
        self._begun: float | None = None

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._bar.stop()
        if self._begun is not None:
            self._say(self._summary(time.monotonic() - self._begun))

    def started(self, total: int, already_finished: int) -> None:
        """There are so many different cases, of which so many are in the ledger."""
        self._begun, self._ended = time.monotonic(), Counter()
        self._bar.reset(self._task, total=total - already_finished, description=self._description)
        if not self._console.is_terminal:
            self._say(f"{self._description}: {total - already_finished} to do, {already_finished} in the ledger")

    def _count(self, how: str) -> None:
        self._ended[how] += 1
        self._bar.advance(self._task)

    def _summary(self, seconds: float) -> str:
        text = f"{self._description}: {self._ended.total()} done in {seconds:.1f} s"
        others = [f"{n} {how}" for how, n in sorted(self._ended.items()) if how != self._usual]
        return f"{text}, of which {', '.join(others)}" if others else text

    def _say(self, text: str) -> None:
        self._console.print(text, markup=False, soft_wrap=True)


class ProgressBar(_Bar):
    """A watcher of `run_cases`."""

    def __init__(self, description: str = "runs", console: Console | None = None) -> None:
        super().__init__(description, "runs/s", Outcome.COMPLETED.slug, console)

    def advanced(self, case: Case, measurement: Measurement) -> None:
        """A case has run and its result is kept."""
        self._count(measurement.outcome)


class RoundsBar(ProgressBar):
    """A watcher of `run_cases` called again and again, each time with what the answers so far ask for."""

    def __init__(self, description: str = "runs", console: Console | None = None) -> None:
        super().__init__(description, console)
        self._asked = 0

    def started(self, total: int, already_finished: int) -> None:
        """A round of so many different cases begins; what comes after it is not known yet."""
        if self._begun is None:
            super().started(total, already_finished)
        elif not self._console.is_terminal:
            self._say(f"{self._description}: {total - already_finished} more to do, {already_finished} in the ledger")
        self._asked += total - already_finished
        self._bar.update(self._task, total=self._asked)


class CostBar(_Bar):
    """A watcher of `time_cases`."""

    def __init__(self, description: str = "costs", console: Console | None = None) -> None:
        super().__init__(description, "timings/s", "timed", console)

    def timed(self, case: Case, timing: Timing | None) -> None:
        """A case has been timed, or could not be."""
        self._count("timed" if timing is not None else "without a timing")
