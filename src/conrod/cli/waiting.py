"""Progress of work that has no steps that could be counted, as on a user's file."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from conrod.cli.say import say
from conrod.report.escaping import one_line
from conrod.studies.execution.isolation import FILE_TIMEOUT

SAID_AFTER = 5.0  # [s], where there is no terminal for a clock


@contextmanager
def waiting(subject: object, timeout: float | None = FILE_TIMEOUT) -> Iterator[None]:
    """Show at a terminal for how long the work on a file or a scene has taken; elsewhere say once that it goes on.

    Args:
        timeout: after which it is ended [s]; None of work in this process.
    """
    console = Console(stderr=True, highlight=False)
    after = "" if timeout is None else f" after {timeout:g} s,"
    words = one_line(f"{subject}: under way, ended{after} by Ctrl-C at once")
    if console.is_terminal:
        columns = SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn()
        with Progress(*columns, console=console, transient=True) as bar:
            bar.add_task(escape(words), total=None)
            yield
        return
    said = threading.Timer(SAID_AFTER, say, (words,), {"err": True})
    said.daemon = True
    said.start()
    try:
        yield
    finally:
        said.cancel()
