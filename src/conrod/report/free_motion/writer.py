"""All files of scenes' free motion, rendered before any is written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from conrod.files import Batch
from conrod.report.canvas import drawing_style, svg_text
from conrod.report.free_motion.document import page_document
from conrod.report.free_motion.figure import motion_figure
from conrod.report.free_motion.folder import figure_file, numbers_file, page_file
from conrod.report.free_motion.page import motion_page
from conrod.report.reproduction import Reproduction
from conrod.studies.free_motion.results import MotionStudy


def motion_batch(studies: Sequence[MotionStudy], folder: Path, command: Reproduction) -> Batch:
    """A figure, the numbers and the page of each scene; a figure that only an earlier page had goes."""
    files: dict[str, str | bytes] = {}
    stale = []
    for study in studies:
        alone = command.of(study.name)
        if any(result.curves is not None for result in study.results):
            with drawing_style():
                files[figure_file(study.name)] = svg_text(motion_figure(study))
        elif (folder / figure_file(study.name)).is_file():
            stale.append(figure_file(study.name))
        files[numbers_file(study.name)] = page_document(study, alone)
        files[page_file(study.name)] = motion_page(study, alone)
    return Batch(folder, files, tuple(stale))
