"""`conrod results`."""

from __future__ import annotations

from pathlib import Path

import click

from conrod.cli import options
from conrod.cli.say import say
from conrod.errors import InvalidInput


@options.verb()
@options.ledger
@click.option("--csv", "csv_file", metavar="FILE", help="Write comma-separated values.")
@options.document
def results(ledger: str | None, csv_file: str | None, document: str | None) -> None:
    """The ledger as a tidy table: a row for each run and machine that timed it; for pandas, polars or DuckDB.

    Without a file the table goes to standard output as comma-separated values.
    """
    from conrod.studies.frame.files import files_to_write
    from conrod.studies.frame.ledger import Ledger, default_path
    from conrod.studies.frame.results_table import table_text
    from conrod.studies.frame.writing import naming, single, write_together

    path = default_path() if ledger is None else Path(ledger)
    files = files_to_write({"--csv": csv_file, "--json": document}, {"the ledger": path})
    if not path.exists() or (path.is_file() and path.stat().st_size == 0):
        raise InvalidInput(
            f"there is no ledger {path}: `conrod validate` and the studies make one; --ledger names another"
        )
    with Ledger.open(path) as opened:
        rows = list(opened.rows())
    if opened.damaged:
        words = f"{opened.damaged} runs in {path} cannot be read and are left out; the next study makes them again"
        say(f"conrod: {words}", err=True)
    write_together([single(file, table_text(rows, option.lstrip("-"))) for option, file in files.items()])
    if files:
        say(f"{len(rows)} rows: {', '.join(str(file) for file in files.values())}")
    else:
        with naming("standard output"):
            say(table_text(rows, "csv"), nl=False)
