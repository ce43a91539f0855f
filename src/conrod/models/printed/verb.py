"""`conrod audit`."""

from __future__ import annotations

from pathlib import Path

import click

from conrod.cli import completion, options


@options.verb(options.ReportOptions)
@click.argument(
    "files", metavar="FILE.csv...", nargs=-1, required=True, shell_complete=completion.files_with((".csv",))
)
def audit(files: tuple[str, ...], asked: options.ReportOptions) -> None:
    """Judge printed values of a textbook by the exact motion, each with a verdict.

    A file is a table of printed values, each tied to a machine by its name or its mechanism file; docs/audit.md
    describes the format.

    Exit status 0: every item has a verdict, whatever it is; 2: bad usage.
    """
    from conrod.cli.outputs import check_outputs
    from conrod.models.printed.api import audit, page_names
    from conrod.models.printed.report import PRINTED_VALUES_REPORT

    pages = page_names(files)
    target = check_outputs(PRINTED_VALUES_REPORT, pages, asked, {file: Path(file) for file in files})
    target.print_and_write(audit(files), "audit", pages)
