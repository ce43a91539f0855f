"""Progress of work on a user's file, which has no steps that could be counted."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from conrod.studies.execution.isolation import FILE_TIMEOUT


@contextmanager
def waiting(path: Path) -> Iterator[None]:
    """Show at a terminal for how long the work on a file has taken, and when it is ended."""
    console = Console(stderr=True, highlight=False)
    words = f"{escape(str(path))}: ended after {FILE_TIMEOUT:g} s, by Ctrl-C at once"
    columns = SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        bar.add_task(words, total=None)
        yield
