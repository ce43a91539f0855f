"""The page of one document: what to correct, what is uncertain, and every item."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.own.printed.audited import Audited
from conrod.own.printed.judging import Kind, Verdict
from conrod.report.audit.corrections import corrections_section
from conrod.report.audit.words import (
    code,
    counted,
    difference_text,
    exact_text,
    is_formula,
    off_text,
    plain,
    right_text,
)
from conrod.report.tables import paragraphs, table

ITEMS = (
    "Lines count in the document's text; *exact* is what the mechanism determines, in the printed unit; *difference* "
    "is printed less exact in units of the last printed digit (half a unit is what rounding may do). The mark of the "
    "decimals is the document's own."
)


def page(audited: Audited, command: str, section: str = "") -> str:
    """The page in Markdown.

    Args:
        command: what reproduces it.
        section: more to say on this document, between the corrections and the items.
    """
    numbers = [v for v in audited.verdicts if not is_formula(v)]
    formulas = [v for v in audited.verdicts if is_formula(v)]
    blocks = [
        f"# {plain(audited.title)}",
        f"{plain(audited.document)} against the exact motion: {_counts(audited)}. Reproduced by `{command}`; "
        "the [index](README.md) says what the verdicts mean.",
        corrections_section(audited.verdicts),
        "## What is not certain" if audited.notes else "",
        "\n".join(f"- {plain(note)}" for note in audited.notes),
        section,
        "## Every number" if numbers else "",
        ITEMS if numbers else "",
        numbers_table(numbers),
        "## Every formula" if formulas else "",
        formulas_table(formulas),
    ]
    return paragraphs(*blocks) + "\n"


def _counts(audited: Audited) -> str:
    found = ", ".join(f"{number} {kind.value}" for kind, number in audited.counts.items() if number)
    return f"{counted(len(audited.verdicts), 'item')}, {found}"


def numbers_table(verdicts: Sequence[Verdict]) -> str:
    """All printed numbers."""
    head = ["line", "where", "quantity", "for", "unit", "printed", "exact", "difference", "verdict", "computation"]
    return table(
        head,
        [
            [
                str(v.line),
                plain(v.place),
                plain(v.quantity),
                plain(v.condition),
                plain(v.unit),
                v.printed,
                exact_text(v),
                difference_text(v),
                _verdict(v),
                plain(v.reason),
            ]
            for v in verdicts
        ],
    )


def formulas_table(verdicts: Sequence[Verdict]) -> str:
    """All formulas."""
    head = ["line", "where", "quantity", "printed", "off by", "verdict", "should be", "computation"]
    return table(
        head,
        [
            [
                str(v.line),
                plain(v.place),
                plain(v.quantity),
                code(v.printed),
                off_text(v),
                _verdict(v),
                right_text(v),
                plain(v.reason),
            ]
            for v in verdicts
        ],
    )


def _verdict(verdict: Verdict) -> str:
    return verdict.kind.value if verdict.kind in (Kind.AGREES, Kind.AFTER_ROUNDING) else f"**{verdict.kind.value}**"
