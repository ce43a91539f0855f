"""What commands print in passing: names of files, and data on standard output."""

from __future__ import annotations

import sys

import click

from conrod.report.escaping import visible


def say(text: str, *, err: bool = False, nl: bool = True) -> None:
    """Print text that commands no terminal. Without a line end it is data, and to a file or pipe stays as it is."""
    stream = sys.stderr if err else sys.stdout
    click.echo(visible(text) if nl or stream.isatty() else text, err=err, nl=nl)
