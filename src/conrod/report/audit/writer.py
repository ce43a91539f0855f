"""The folder of an audit's report: all its files, rendered before any is written."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from conrod.own.printed.audited import Audited
from conrod.report.audit.document import document, text
from conrod.report.audit.index import index
from conrod.report.audit.page import page
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.folder import check_own_folder, document_in, holds_document
from conrod.studies.frame.files import Batch

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INDEX, RESULTS, FIGURES = "README.md", "results.json", "figures"
# Of an audit's results, by which its report is known.
KEYS = {"schema", "command", "audit"}
PAGE = re.compile(r"[a-z0-9][a-z0-9-]*")


def check_audit_folder(directory: Path, names: Sequence[str], drawn: Sequence[str]) -> None:
    """Refuse a folder in which an audit's report would replace what is none.

    Args:
        names, drawn: of the pages, and of the figures in the folder.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    pages = (INDEX, RESULTS, *(f"{name}.md" for name in names))
    own = holds_document(directory / RESULTS, KEYS)
    check_own_folder(directory, pages, drawn, FIGURES, own, "the report of an audit")


def stale_pages(directory: Path, names: Sequence[str]) -> tuple[str, ...]:
    """Pages of the report that is there which the new one does not have."""
    if not holds_document(directory / RESULTS, KEYS):
        return ()
    before = document_in(directory / RESULTS)["audit"]
    gone = [name for name in before if isinstance(name, str) and PAGE.fullmatch(name) and name not in names]
    return tuple(f"{name}.md" for name in gone if (directory / f"{name}.md").is_file())


def audit_report_batch(
    audits: Sequence[Audited],
    folder: Path,
    command: str,
    sections: Mapping[str, str] | None = None,
    figures: Mapping[str, Callable[[], Figure]] | None = None,
) -> Batch:
    """Return all files of the report: figures, numbers, pages, and the index last.

    Args:
        command: what reproduces it.
        sections: more text of a page, by its name.
        figures: functions that draw, by the figure's name.
    """
    files: dict[str, str | bytes] = {}
    with drawing_style():
        for name, draw in (figures or {}).items():
            files[f"{FIGURES}/{name}.svg"] = svg_text(draw())
    files[RESULTS] = text(document(audits, command))
    for audited in audits:
        files[f"{audited.name}.md"] = page(audited, command, (sections or {}).get(audited.name, ""))
    files[INDEX] = index(audits, command)
    return Batch(folder, files, stale_pages(folder, [audited.name for audited in audits]))
