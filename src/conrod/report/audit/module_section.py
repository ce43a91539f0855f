"""What document 001 asks for and does not print."""

from __future__ import annotations

from conrod.audit.documents.module_answers import answers
from conrod.report.audit.words import plain
from conrod.report.numbers import quantity
from conrod.report.tables import paragraphs, table


def module_section() -> str:
    """The answers, with their computation."""
    rows = [
        [str(a.line), plain(a.place), plain(a.quantity), quantity(a.value, 6), plain(a.unit), plain(a.why)]
        for a in answers()
    ]
    return paragraphs(
        "## Asked for and not printed",
        "What the examples ask and leave open, from their printed lengths and speeds.",
        table(["line", "where", "quantity", "value", "unit", "computation"], rows),
    )
