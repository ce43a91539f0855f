"""`conrod report DIR`: pages and figures made anew from what a report saved."""

from __future__ import annotations

from pathlib import Path

import click

from conrod.cli import options
from conrod.cli.say import say
from conrod.errors import InvalidInput


@options.verb()
@click.argument("directory")
@options.out
def report(directory: str, out: str | None) -> None:
    """Render the reports in DIRECTORY again, from their own JSON: no engine runs, none need be installed.

    With --out they are written there, and DIRECTORY is left as it is. Reports in folders below it are rendered one by
    one, e.g. reports/sweep.
    """
    from conrod.report.writer import rendered_again
    from conrod.studies.frame.files import folder_to_write
    from conrod.studies.frame.writing import write_together

    folder = Path(directory)
    if not folder.is_dir():
        raise InvalidInput(f"{directory}: no such folder")
    target = folder_to_write(directory if out is None else out, "DIRECTORY" if out is None else "--out")
    batches = rendered_again(folder, target)
    write_together(batches)
    for batch in batches:
        for name in batch.files:
            say(f"wrote {target / name}")
