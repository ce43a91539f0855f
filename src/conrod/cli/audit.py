"""`conrod audit`."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.markup import escape
from rich.table import Table

from conrod.cli.console import console
from conrod.errors import InvalidInput
from conrod.own.printed.audited import Audited
from conrod.own.printed.judging import Kind, Verdict

if TYPE_CHECKING:
    from conrod.studies.frame.files import Batch

# Items of a user's file that are told one by one.
MOST = 20
GOOD = (Kind.AGREES, Kind.AFTER_ROUNDING)
ORDER = (Kind.MISPRINT, Kind.WRONG_STEP, Kind.NOT_REPRODUCIBLE, Kind.EXPLAINED)


def print_counts(audits: Sequence[Audited]) -> None:
    """A line a document: how many items have which verdict."""
    out = console()
    shown = Table(box=None, pad_edge=False)
    shown.add_column("document")
    for kind in Kind:
        shown.add_column(kind.value.removesuffix(" as printed"), justify="right")
    shown.add_column("items", justify="right")
    for audited in audits:
        shown.add_row(escape(audited.document), *(str(n) for n in audited.counts.values()), str(len(audited.verdicts)))
    out.print(shown)


def print_items(audited: Audited) -> None:
    """The items that do not agree, each with what it should be."""
    out = console()
    # What is to be corrected first, in the order of the file; what one cause explains comes last.
    told = sorted((v for v in audited.verdicts if v.kind not in GOOD), key=lambda verdict: ORDER.index(verdict.kind))
    for verdict in told[:MOST]:
        out.print(_told(verdict), markup=False, highlight=False, soft_wrap=True)
    if len(told) > MOST:
        out.print(f"... and {len(told) - MOST} more; --out DIR writes all", markup=False, soft_wrap=True)


def _told(verdict: Verdict) -> str:
    right = "" if verdict.should_be is None else f", should be {verdict.should_be}"
    place = f"{verdict.place}: " if verdict.place else ""
    what = f"{verdict.quantity} at {verdict.condition}: {verdict.printed} {verdict.unit}"
    return f"{place}{what}{right}: {verdict.kind.value} ({verdict.reason})"


@click.command()
@click.argument("files", metavar="FILE.csv...", nargs=-1, required=True)
@click.option("--out", metavar="DIR", help="Write a page for each file, an index and results.json.")
def audit(files: tuple[str, ...], out: str | None) -> None:
    """Judge printed values of a textbook by the exact motion, each with a verdict.

    A file is a table of printed values, each tied to a machine by its name or its mechanism file; docs/audit.md
    describes the format.

    Exit status 0: every item has a verdict, whatever it is; 2: bad usage.
    """
    from conrod.own.printed.user_file import audit_file
    from conrod.studies.frame.files import naming, write_together

    names = _page_names(files)
    folder = None if out is None else _checked_folder(out, files, names)
    audits = [audit_file(Path(file), name) for file, name in zip(files, names, strict=True)]
    with naming("standard output"):
        print_counts(audits)
        for audited in audits:
            print_items(audited)
    if folder is not None:
        write_together([_batch(audits, files, folder)])
        click.echo(f"report: {folder / 'README.md'}")


def _page_names(files: Sequence[str]) -> list[str]:
    """Names of the pages: the stems of the files, in plain letters."""
    names: list[str] = []
    for file in files:
        name = re.sub("[^a-z0-9]+", "-", Path(file).stem.lower()).strip("-") or "table"
        if name in (*names, "readme"):
            raise InvalidInput(f"{file}: its page would be {name}.md, which is taken; give the file another name")
        names.append(name)
    return names


def _checked_folder(out: str, files: Sequence[str], names: Sequence[str]) -> Path:
    """The report's folder, refused before any work where something would be lost."""
    from conrod.report.audit.writer import FIGURES, INDEX, RESULTS, check_audit_folder
    from conrod.report.folder import check_beside
    from conrod.studies.frame.files import folder_to_write

    folder = folder_to_write(out, "--out")
    pages = [f"{name}.md" for name in names]
    for file in files:
        check_beside(Path(file), folder, (INDEX, RESULTS, FIGURES, *pages))
    check_audit_folder(folder, names, ())
    return folder


def _batch(audits: Sequence[Audited], files: Sequence[str], folder: Path) -> Batch:
    from conrod.report.audit.writer import audit_report_batch

    command = " ".join(map(shlex.quote, ["conrod", "audit", *files, "--out", str(folder)]))
    return audit_report_batch(audits, folder, command)
