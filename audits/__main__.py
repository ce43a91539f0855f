"""`python -m audits [--out DIR]`: the four documents against the exact motion."""

from __future__ import annotations

import argparse
from pathlib import Path

from audits.judged import DOCUMENTS, PAGES, audited
from audits.report.pages import DOCUMENTS_REPORT
from conrod.crash import run_guarded
from conrod.execution.files import folder_to_write
from conrod.execution.writing import Batch, write_together
from conrod.models.printed.report import counts_table
from conrod.report.folder import ReportFolder
from conrod.report.kind import Reproduction
from conrod.report.terminal import console, print_table
from conrod.report.writer import report_batch


def report(folder: Path) -> Batch:
    """All files of the report on the four documents."""
    return report_batch(DOCUMENTS_REPORT, {PAGES[n]: audited(n) for n in DOCUMENTS}, folder, Reproduction("make audit"))


def main() -> None:
    """Print how many items have which verdict, and write the report where it is asked for."""
    parser = argparse.ArgumentParser(prog="python -m audits", description=main.__doc__)
    parser.add_argument("--out", metavar="DIR", help="write a page for each document, an index and the findings")
    out = parser.parse_args().out
    print_table(console(), counts_table({f"{n} {PAGES[n]}": audited(n) for n in DOCUMENTS}))
    if out is not None:
        folder = folder_to_write(out, "--out")
        ReportFolder(folder, DOCUMENTS_REPORT).check(PAGES.values())
        write_together([report(folder)])
        print(f"report: {folder / 'README.md'}")


if __name__ == "__main__":
    run_guarded(main)
