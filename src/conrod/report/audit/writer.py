"""All files of an audit's report, rendered before any is written."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from conrod.audit import Audited
from conrod.files import Batch
from conrod.report.audit.cam_figures import CAM_FIGURES
from conrod.report.audit.cam_section import cam_section
from conrod.report.audit.document import document, text
from conrod.report.audit.folder import FIGURES, INDEX, RESULTS, stale_pages
from conrod.report.audit.index import index
from conrod.report.audit.module_section import module_section
from conrod.report.audit.page import page
from conrod.report.audit.saw_section import saw_section
from conrod.report.canvas import drawing_style, svg_text

# What is said of a document that ships beyond its items.
SECTIONS: dict[str, Callable[[], str]] = {"001": module_section, "002": saw_section, "004": cam_section}
CAM = "004"
FIGURE_FILES = tuple(f"{FIGURES}/{name}.svg" for name in CAM_FIGURES)


def audit_report_batch(audits: Sequence[Audited], folder: Path, command: str) -> Batch:
    """The report: figures, numbers, pages, and the index last."""
    files: dict[str, str | bytes] = {}
    if _has_cam(audits):
        with drawing_style():
            for name, draw in CAM_FIGURES.items():
                files[f"{FIGURES}/{name}.svg"] = svg_text(draw())
    files[RESULTS] = text(document(audits, command))
    for audited in audits:
        more = [SECTIONS[audited.document]()] if audited.shipped and audited.document in SECTIONS else []
        files[f"{audited.name}.md"] = page(audited, command, more)
    files[INDEX] = index(audits, command)
    return Batch(folder, files, stale_pages(folder, [audited.name for audited in audits]))


def _has_cam(audits: Sequence[Audited]) -> bool:
    return any(audited.shipped and audited.document == CAM for audited in audits)
