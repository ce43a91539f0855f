"""The report on a user's model, rendered."""

from __future__ import annotations

from pathlib import Path

from conrod.files import Batch
from conrod.report.canvas import drawing_style, svg_text
from conrod.report.user_model.document import document_file, figure_file, page_file, results_text
from conrod.report.user_model.figure import model_figure
from conrod.report.user_model.page import model_page
from conrod.studies.user_model.study import ModelStudy


def model_report_batch(study: ModelStudy, folder: Path, command: str) -> Batch:
    """Page, figure and results; nothing is written yet."""
    with drawing_style():
        drawn = svg_text(model_figure(study))
    files = {
        figure_file(study.file): drawn,
        page_file(study.file): model_page(study, command),
        document_file(study.file): results_text(study),
    }
    return Batch(folder, files)
