"""All files of a table's report, rendered before any is written."""

from __future__ import annotations

from pathlib import Path

from conrod.files import Batch
from conrod.report.canvas import drawing_style, svg_text
from conrod.report.trajectory.figure import error_figure
from conrod.report.trajectory.folder import ERROR_FIGURE, PAGE, RESULTS
from conrod.report.trajectory.page import table_page
from conrod.tables.document import table_document, table_text
from conrod.tables.study import TableStudy


def table_report_batch(study: TableStudy, folder: Path, command: str) -> Batch:
    """The report: a figure where there are errors to draw, the numbers, and the page last."""
    files: dict[str, str | bytes] = {}
    if study.errors:
        with drawing_style():
            files[ERROR_FIGURE] = svg_text(error_figure(study))
    files[RESULTS] = table_text(table_document(study))
    files[PAGE] = table_page(study, command, with_figure=bool(study.errors))
    stale = ERROR_FIGURE not in files and (folder / ERROR_FIGURE).is_file()
    return Batch(folder, files, (ERROR_FIGURE,) if stale else ())
