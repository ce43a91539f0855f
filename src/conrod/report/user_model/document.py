"""The files of a report on a user's model, and what they must not replace."""

from __future__ import annotations

import json
from pathlib import Path

from conrod.files import Batch, check_apart, file_to_write, folder_to_write, single
from conrod.model_files import as_outputs_must_not_be
from conrod.report.own_folder import check_own_folder, holds_document
from conrod.report.pages import FIGURES
from conrod.studies.user_model.serialise import KEYS, model_document
from conrod.studies.user_model.study import ModelStudy


def page_file(file: str) -> str:
    """Name of the page on a model's file."""
    return f"{Path(file).stem}.md"


def figure_file(file: str) -> str:
    """Name of its figure."""
    return f"{FIGURES}/{Path(file).stem}-model.svg"


def document_file(file: str) -> str:
    """Name of its results."""
    return f"{Path(file).stem}.json"


def outputs_of(file: str, out: str | None, document: str | None) -> tuple[Path | None, Path | None]:
    """The report's folder and the JSON file, refused before any work where something would be lost by them.

    Raises:
        InvalidInput: names what is in the way.
    """
    folder = None if out is None else folder_to_write(out, "--out")
    target = None if document is None else file_to_write(document, "--json")
    files = as_outputs_must_not_be(Path(file))
    if target is not None:
        files["--json"] = target
    if folder is not None:
        own = holds_document(folder / document_file(file), KEYS)
        pages = (page_file(file), document_file(file))
        check_own_folder(folder, pages, (figure_file(file),), FIGURES, own, "a report of conrod on a model")
        files |= {f"{name} of the report": folder / name for name in (*pages, figure_file(file))}
    check_apart(files)
    return folder, target


def results_text(study: ModelStudy) -> str:
    """The results as JSON."""
    return json.dumps(model_document(study), indent=1, allow_nan=False) + "\n"


def results_file(study: ModelStudy, target: Path) -> Batch:
    """The results in a file of their own."""
    return single(target, results_text(study))
