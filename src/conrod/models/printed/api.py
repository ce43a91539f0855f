"""Printed values of a textbook, judged by the exact motion."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.models.printed.report import PRINTED_VALUES_REPORT
from conrod.models.printed.table import audit_file
from conrod.models.printed.verdicts import AuditedDocument
from conrod.report.findings import Findings


def audit(files: str | Path | Sequence[str | Path]) -> Findings[AuditedDocument]:
    """Judge printed values, each by the exact motion of the machine that its row names.

    Args:
        files: tables of printed values, in the format of docs/audit.md.

    Raises:
        InvalidInput: a file cannot be read or used; names the file, the row and the field.
    """
    pages = page_names([files] if isinstance(files, str | Path) else files)
    found = {page: audit_file(Path(file)) for page, file in pages.items()}
    return Findings(PRINTED_VALUES_REPORT, found, f"conrod.audit({list(pages.values())!r})", typed=pages)


def page_names(files: Sequence[str | Path]) -> dict[str, str]:
    """Files by the names of their pages: their stems in plain letters.

    Raises:
        InvalidInput: two files would have one page.
    """
    pages: dict[str, str] = {}
    for file in map(str, files):
        name = re.sub("[^a-z0-9]+", "-", Path(file).stem.lower()).strip("-") or "table"
        if name in (*pages, "readme"):
            raise InvalidInput(f"{file}: its page would be {name}.md, which is taken; give the file another name")
        pages[name] = file
    return pages
