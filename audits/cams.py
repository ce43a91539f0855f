"""`python -m audits.cams [--out DIR]`: the 25 cams of document 004 in both engines, against the exact motion."""

from __future__ import annotations

import argparse
import sys

from audits.cam_runs import study_cams
from audits.report.cams import CAMS_REPORT
from conrod import Runs
from conrod.crash import run_guarded
from conrod.execution.files import folder_to_write
from conrod.execution.writing import write_together
from conrod.report.folder import ReportFolder
from conrod.report.kind import Reproduction
from conrod.report.terminal import print_parts
from conrod.report.writer import report_batch

PART = "cams"


def main() -> None:
    """Print the error of every cam in each engine, and write the report where it is asked for.

    Exit status 0: all cams are within tolerance; 1: one is not.
    """
    parser = argparse.ArgumentParser(prog="python -m audits.cams", description=main.__doc__)
    parser.add_argument("--out", metavar="DIR", help="write tables, figures and findings")
    out = parser.parse_args().out
    folder = None if out is None else folder_to_write(out, "--out")
    if folder:
        ReportFolder(folder, CAMS_REPORT).check([PART])
    found = study_cams(runs=Runs(fresh=True))
    print_parts(CAMS_REPORT.printed([found]))
    if folder:
        write_together([report_batch(CAMS_REPORT, {PART: found}, folder, Reproduction("make cams"))])
        print(f"report: {folder / 'README.md'}")
    if not found.passed:
        sys.exit(1)


if __name__ == "__main__":
    run_guarded(main)
