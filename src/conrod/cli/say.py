"""Messages that commands print in passing: names of files, data on standard output, and that work goes on."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import click

from conrod.report.table import one_line, visible

SAID_AFTER = 5.0  # [s]


def say(text: str, *, err: bool = False, nl: bool = True) -> None:
    """Print text that commands no terminal. Without a line end it is data, and to a file or pipe stays as it is."""
    stream = sys.stderr if err else sys.stdout
    click.echo(visible(text) if nl or stream.isatty() else text, err=err, nl=nl)


@contextmanager
def waiting(subject: object, timeout: float | None) -> Iterator[None]:
    """Say after a while that the work on a file or a scene goes on.

    Args:
        timeout: after which it is ended [s]; None of work in this process.
    """
    after = "" if timeout is None else f" after {timeout:g} s,"
    words = one_line(f"{subject}: under way, ended{after} by Ctrl-C at once")
    said = threading.Timer(SAID_AFTER, say, (words,), {"err": True})
    said.daemon = True
    said.start()
    try:
        yield
    finally:
        said.cancel()
