"""`python -m audits [--out DIR]`: the four documents against the exact motion."""

from __future__ import annotations

import argparse
from pathlib import Path

from audits.judged import DOCUMENTS, PAGES, audited
from audits.report.cam_figures import CAM_FIGURES
from audits.report.sections import cam_section, module_section, saw_section
from conrod.report.audit.writer import FIGURES, audit_report_batch, check_audit_folder
from conrod.studies.frame.files import Batch, folder_to_write, write_together

COMMAND = "make audit"


def report(folder: Path) -> Batch:
    """Return all files of the report on the four documents."""
    sections = {"course-module": module_section(), "power-hacksaw": saw_section(), "arc-cam": cam_section()}
    return audit_report_batch([audited(number) for number in DOCUMENTS], folder, COMMAND, sections, CAM_FIGURES)


def main() -> None:
    """Print how many items have which verdict, and write the report where it is asked for."""
    parser = argparse.ArgumentParser(prog="python -m audits", description=main.__doc__)
    parser.add_argument("--out", metavar="DIR", help="write a page for each document, an index and results.json")
    out = parser.parse_args().out
    for number in DOCUMENTS:
        found = audited(number)
        counts = ", ".join(f"{count} {kind}" for kind, count in found.counts.items() if count)
        print(f"{found.document}: {len(found.verdicts)} items, {counts}")
    if out is not None:
        folder = folder_to_write(out, "--out")
        check_audit_folder(folder, list(PAGES.values()), [f"{FIGURES}/{name}.svg" for name in CAM_FIGURES])
        write_together([report(folder)])
        print(f"report: {folder / 'README.md'}")


if __name__ == "__main__":
    main()
