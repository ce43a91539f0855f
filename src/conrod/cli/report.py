"""`conrod report DIR`: pages and figures made anew from what a report saved."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from conrod.cli import FAILED, options
from conrod.cli.say import say
from conrod.errors import InvalidInput


@options.verb()
@click.argument("directory")
@options.out
@options.html
@click.option("--verify", is_flag=True, help="DIRECTORY is a verification report: was it changed?")
def report(directory: str, out: str | None, html: str | None, verify: bool) -> None:
    """Render the reports in DIRECTORY again, from their own JSON: no engine runs, none need be installed.

    With --out they are written there, with --html as one page that needs no network, and DIRECTORY is left as it is.
    Reports in folders below it are rendered one by one, e.g. reports/sweep.
    """
    if verify:
        if out or html:
            raise InvalidInput("--verify: nothing is written: give neither --out nor --html")
        _verify(Path(directory))
        return
    from conrod.report.folder import check_beside
    from conrod.report.html.page import html_report
    from conrod.report.writer import rendered_again
    from conrod.studies.frame.files import files_to_write, folder_to_write
    from conrod.studies.frame.writing import single, write_together

    folder = Path(directory)
    if not folder.is_dir():
        raise InvalidInput(f"{directory}: no such folder")
    page = files_to_write({"--html": html}).get("--html")
    target = None
    if out is not None or page is None:
        target = folder_to_write(directory if out is None else out, "DIRECTORY" if out is None else "--out")
    batches = rendered_again(folder, target)
    written = {target / name: batch for batch in batches for name in batch.files} if target else {}
    if page:
        for batch in batches:
            for place in {folder, batch.folder}:
                check_beside(page, place, batch.files)
        written[page] = single(page, html_report(batches))
    write_together(list({id(batch): batch for batch in written.values()}.values()))
    for file in written:
        say(f"wrote {file}")


def _verify(file: Path) -> None:
    """Say whether a verification report is as it was written; exit status 1 if it is not."""
    from conrod.own.files import check_readable
    from conrod.report.verification.page import seal_of

    check_readable(file)
    try:
        seal = seal_of(file.read_bytes())
    except InvalidInput as error:
        raise InvalidInput(f"{file}: {error}") from None
    say(f"{file}: unchanged, SHA-256 {seal}" if seal else f"{file}: CHANGED since it was written")
    if not seal:
        sys.exit(FAILED)
