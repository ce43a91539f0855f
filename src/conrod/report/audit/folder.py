"""The folder of an audit's report."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from conrod.report.own_folder import check_own_folder, document_in, holds_document

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
