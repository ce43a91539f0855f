"""`conrod audit`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from collections.abc import Sequence

    from conrod.audit import Audited
    from conrod.files import Batch


@click.command()
@click.argument("files", metavar="[FILE.csv]...", nargs=-1)
@click.option("--out", metavar="DIR", help="Write a page for each document, an index and results.json.")
def audit(files: tuple[str, ...], out: str | None) -> None:
    """Published figures against the exact motion: every printed value with a verdict.

    Without a file: the four documents that the machines come from. A file is a table of printed values, each tied to a
    machine by its name or its mechanism file; docs/audit.md says how it is written.

    Exit status 0: every item has a verdict, whatever it is; 2: bad usage.
    """
    from conrod.audit_console import print_counts, print_items
    from conrod.files import naming, write_together

    names = _page_names(files)
    folder = None if out is None else _checked_folder(out, files, names)
    audits = _user_audits(files, names) if files else _shipped_audits()
    with naming("standard output"):
        print_counts(audits)
        for audited in audits if files else ():
            print_items(audited)
    if folder is not None:
        write_together([_batch(audits, files, folder)])
        click.echo(f"report: {folder / 'README.md'}")


def _shipped_audits() -> list[Audited]:
    from conrod.audit import DOCUMENTS, audited

    return [audited(document) for document in DOCUMENTS]


def _user_audits(files: Sequence[str], names: Sequence[str]) -> list[Audited]:
    from conrod.audit.user_file import audit_file

    return [audit_file(Path(file), name) for file, name in zip(files, names, strict=True)]


def _page_names(files: Sequence[str]) -> list[str]:
    """Names of the pages; of a user's file the stem, in plain letters."""
    import re

    if not files:
        from conrod.audit import PAGES

        return list(PAGES.values())
    names: list[str] = []
    for file in files:
        name = re.sub("[^a-z0-9]+", "-", Path(file).stem.lower()).strip("-") or "table"
        if name in (*names, "readme"):
            raise InvalidInput(f"{file}: its page would be {name}.md, which is taken; give the file another name")
        names.append(name)
    return names


def _checked_folder(out: str, files: Sequence[str], names: Sequence[str]) -> Path:
    """The report's folder, refused before any work where something would be lost."""
    from conrod.files import folder_to_write
    from conrod.report.apart import check_beside
    from conrod.report.audit.folder import FIGURES, INDEX, RESULTS, check_audit_folder
    from conrod.report.audit.writer import FIGURE_FILES

    folder = folder_to_write(out, "--out")
    pages = [f"{name}.md" for name in names]
    for file in files:
        check_beside(Path(file), folder, (INDEX, RESULTS, FIGURES, *pages))
    check_audit_folder(folder, names, () if files else FIGURE_FILES)
    return folder


def _batch(audits: Sequence[Audited], files: Sequence[str], folder: Path) -> Batch:
    from conrod.report.audit.writer import audit_report_batch

    command = " ".join(map(shlex.quote, ["conrod", "audit", *files, "--out", str(folder)]))
    return audit_report_batch(audits, folder, command)
