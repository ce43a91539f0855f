"""`conrod audit`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import click

from conrod.cli import options
from conrod.errors import InvalidInput

MOST_ITEMS = 20  # of a file that are printed one by one


@options.verb(options.ReportOptions)
@click.argument("files", metavar="FILE.csv...", nargs=-1, required=True)
def audit(files: tuple[str, ...], asked: options.ReportOptions) -> None:
    """Judge printed values of a textbook by the exact motion, each with a verdict.

    A file is a table of printed values, each tied to a machine by its name or its mechanism file; docs/audit.md
    describes the format.

    Exit status 0: every item has a verdict, whatever it is; 2: bad usage.
    """
    from conrod.cli.outputs import outputs
    from conrod.own.printed.table import audit_file
    from conrod.report.printed_values import KIND, console_lines, counts_table

    pages = _pages(files)
    target = outputs(KIND, pages, asked, {file: Path(file) for file in files})
    audits = {page: audit_file(Path(file)) for page, file in pages.items()}
    lines = [line for audited in audits.values() for line in console_lines(audited, MOST_ITEMS)]
    target.answer(audits, [counts_table({one.document: one for one in audits.values()}), *lines], "audit", pages)


def _pages(files: Sequence[str]) -> dict[str, str]:
    """The files by the names of their pages: their stems in plain letters."""
    pages: dict[str, str] = {}
    for file in files:
        name = re.sub("[^a-z0-9]+", "-", Path(file).stem.lower()).strip("-") or "table"
        if name in (*pages, "readme"):
            raise InvalidInput(f"{file}: its page would be {name}.md, which is taken; give the file another name")
        pages[name] = file
    return pages
