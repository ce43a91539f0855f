"""`conrod report DIR`: pages and figures from what a report saved; `conrod results`: the ledger as a table."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from conrod.cli import FAILED, options, say
from conrod.cli.options import names_in
from conrod.cli.outputs import say_unfinished
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
    from conrod.execution.files import files_to_write, folder_to_write
    from conrod.execution.writing import single_file, write_together
    from conrod.report.folder import check_other_file
    from conrod.report.html.page import html_report
    from conrod.report.writer import explain_unfit_findings, render_again, reports_in

    folder = Path(directory)
    if not folder.is_dir():
        words = " it is a file; give the folder of a report, or --verify for a verification report"
        raise InvalidInput(f"{directory}:{words if folder.exists() else ' no such folder'}")
    page = files_to_write({"--html": html}).get("--html")
    target = None
    if out is not None or page is None:
        target = folder_to_write(directory if out is None else out, "DIRECTORY" if out is None else "--out")
    for one in reports_in(folder):
        say_unfinished(one)
    with explain_unfit_findings(folder):
        batches = render_again(folder, target)
        text = html_report(batches) if page else ""
    written = {target / name: batch for batch in batches for name in batch.files} if target else {}
    if page:
        for batch in batches:
            for place in {folder, batch.folder}:
                check_other_file(page, place, batch.files)
        written[page] = single_file(page, text)
    write_together(list({id(batch): batch for batch in written.values()}.values()))
    for file in written:
        say(f"wrote {file}")


def _verify(file: Path) -> None:
    """Say whether a verification report is as it was written; exit status 1 if it is not."""
    from conrod.user_files.files import check_readable
    from conrod.verification.page import valid_seal

    check_readable(file)
    try:
        seal = valid_seal(file.read_bytes())
    except InvalidInput as error:
        raise InvalidInput(f"{file}: {error}") from None
    say(f"{file}: unchanged, SHA-256 {seal}" if seal else f"{file}: CHANGED since it was written")
    if not seal:
        sys.exit(FAILED)


@options.verb()
@options.ledger
@click.option("--csv", "csv_file", metavar="FILE", help="Write comma-separated values.")
@options.document
@click.option("--columns", metavar="NAME,...", help="These columns alone [on a terminal ten, otherwise all].")
def results(ledger: str | None, csv_file: str | None, document: str | None, columns: str | None) -> None:
    """The ledger as a tidy table: a row for each run and machine that timed it; for pandas, polars or DuckDB.

    Without a file it is printed: as a table to read on a terminal, as comma-separated values in a pipe.
    """
    from conrod.errors import name_file_in_os_errors
    from conrod.execution.files import files_to_write
    from conrod.execution.ledger import Ledger, default_ledger_path
    from conrod.execution.results_table import columns_of, table_text
    from conrod.execution.writing import single_file, write_together

    path = default_ledger_path() if ledger is None else Path(ledger)
    files = files_to_write({"--csv": csv_file, "--json": document}, {"the ledger": path})
    if not path.exists() or (path.is_file() and path.stat().st_size == 0):
        raise InvalidInput(
            f"there is no ledger {path}: `conrod validate` and the studies make one; --ledger names another"
        )
    with Ledger.open_for_reading(path) as opened:
        rows = list(opened.rows())
    if opened.damaged:
        words = f"{opened.damaged} runs in {path} cannot be read and are left out; the next study makes them again"
        say(f"conrod: {words}", err=True)
    wanted = names_in(columns) or ()
    columns_of(rows, wanted)
    write_together([single_file(file, table_text(rows, option.lstrip("-"), wanted)) for option, file in files.items()])
    if files:
        say(f"{len(rows)} rows: {', '.join(str(file) for file in files.values())}")
    elif sys.stdout.isatty():
        from conrod.cli.console import ledger_table
        from conrod.report.terminal import print_parts

        print_parts([ledger_table(rows, wanted), "" if wanted else f"{len(rows)} rows; all columns: --csv FILE"])
    else:
        with name_file_in_os_errors("standard output"):
            say(table_text(rows, "csv", wanted), nl=False)
