"""The folder of a table's report."""

from __future__ import annotations

from pathlib import Path

from conrod.report.own_folder import check_own_folder, holds_document

PAGE, RESULTS, FIGURES = "README.md", "results.json", "figures"
ERROR_FIGURE = f"{FIGURES}/error.svg"
FILES = (PAGE, RESULTS, ERROR_FIGURE, FIGURES)
# Of a table's results, by which its report is known.
KEYS = {"schema", "table", "scene", "causes"}


def check_table_folder(directory: Path) -> None:
    """Refuse a folder in which a table's report would replace what is none.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    own = holds_document(directory / RESULTS, KEYS)
    check_own_folder(directory, (PAGE, RESULTS), (ERROR_FIGURE,), FIGURES, own, "the report of a table")
