"""The report on printed values that were audited: pages of tables, the index, and lines for the console."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from conrod.models.printed.verdicts import ACCEPTED_KINDS, AuditedDocument, PrintedNumber, PrintedVerdict
from conrod.models.printed.verdicts import VerdictKind as Judgement
from conrod.report.kind import Index, Kind
from conrod.report.numbers import MISSING
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart

CONSOLE_ORDER = (Judgement.MISPRINT, Judgement.WRONG_STEP, Judgement.NOT_REPRODUCIBLE, Judgement.EXPLAINED)
SYSTEMATIC_KINDS = (Judgement.WRONG_STEP, Judgement.EXPLAINED)  # of a user's table: a whole column has the cause
EXTRA_DIGITS = 3  # of an exact value, beyond the digits in print
MAX_PRINTED_ITEMS = 20  # of a document, on the console
MAX_LISTED_LINES = 4


def escape_marks(text: str) -> str:
    """Escape the characters that Markdown would read as marks."""
    return re.sub(r"([*_<>\[\]`])", r"\\\1", text)


def unsigned_zero(text: str) -> str:
    """Drop the sign of a number in text if all its digits are zero."""
    return text.lstrip("+-") if not re.search("[1-9]", text) else text


def counts_text(audited: AuditedDocument) -> str:
    """Say how many items of a document have each verdict."""
    count = len(audited.verdicts)
    found = (f"{number} {kind.value}" for kind, number in audited.counts.items() if number)
    return f"{count} item{'s' * (count != 1)}, {', '.join(found)}"


def verdict_text(verdict: PrintedVerdict) -> str:
    """Return the verdict in Markdown, bold where the printed value is wrong."""
    return verdict.kind.value if verdict.kind in ACCEPTED_KINDS else f"**{verdict.kind.value}**"


def console_lines(audited: AuditedDocument, max_lines: int) -> Iterator[str]:
    """Yield the items that disagree, with their computation; the ones to correct first."""
    wrong = sorted(
        (v for v in audited.verdicts if v.kind not in ACCEPTED_KINDS), key=lambda v: CONSOLE_ORDER.index(v.kind)
    )
    for verdict in wrong[:max_lines]:
        place = f"{verdict.place}: " if verdict.place else ""
        right = "" if verdict.should_be is None else f", should be {verdict.should_be}"
        what = f"{verdict.quantity} at {verdict.condition}: {verdict.printed} {verdict.unit}"
        yield f"{place}{what}{right}: {verdict.kind.value} ({verdict.reason})"
    if len(wrong) > max_lines:
        yield f"... and {len(wrong) - max_lines} more; --out DIR writes all"


def cause_lines(audited: AuditedDocument) -> Iterator[str]:
    """Yield each cause with the lines that it explains, and the lines of its columns that it leaves."""
    causes = dict.fromkeys(v.cause for v in audited.verdicts if v.cause and v.kind in SYSTEMATIC_KINDS)
    for cause in filter(None, causes):
        lines = [v.line for v in audited.verdicts if v.cause == cause]
        left = [v.line for v in audited.verdicts if f"left over by {cause}," in v.reason]
        rest = f"; left over: {_lines_text(left)}" if left else ""
        yield f"{cause}: {len(lines)} item{'s' * (len(lines) != 1)}, {_lines_text(lines)}{rest}"


def _lines_text(lines: Sequence[int]) -> str:
    """List line numbers; of many, the first and the last."""
    if len(lines) <= MAX_LISTED_LINES:
        return f"line{'s' * (len(lines) != 1)} {', '.join(map(str, lines))}"
    return f"lines {lines[0]} to {lines[-1]}"


def counts_table(audits: Mapping[str, AuditedDocument]) -> Table:
    """Return a row for each document: number of items by verdict.

    Args:
        audits: by the name of the document in the table."""
    head = ["document", *(kind.value.removesuffix(" as printed") for kind in Judgement), "items"]
    rows = [[name, *map(str, one.counts.values()), str(len(one.verdicts))] for name, one in audits.items()]
    return table(head, rows, right=head[1:])


def numbers_table(verdicts: Sequence[PrintedVerdict]) -> Table:
    """Return a row for each printed number, with the exact one and the difference."""
    head = ["line", "where", "quantity", "for", "unit", "printed", "exact", "difference", "verdict", "computation"]
    rows = [
        [
            str(v.line), *map(escape_marks, (v.place, v.quantity, v.condition, v.unit)), v.printed,
            MISSING
            if v.exact is None
            else unsigned_zero(f"{v.exact:.{PrintedNumber(v.printed).decimals + EXTRA_DIGITS}f}"),
            MISSING if v.difference is None else unsigned_zero(f"{v.difference:+.2f}"),
            verdict_text(v), escape_marks(v.reason),
        ]
        for v in verdicts
    ]  # fmt: skip
    return table(head, rows)


def audits_by_link(index: Index[AuditedDocument]) -> dict[str, AuditedDocument]:
    """Return the audits of an index by a Markdown link to their pages."""
    return {f"[{escape_marks(one.title)}]({name}.md)": one for name, one in index.studies.items()}


def _summary(audited: AuditedDocument) -> dict[str, Any]:
    return {"document": audited.document, "counts": {kind.value: n for kind, n in audited.counts.items()}}


def results_to_print(audits: Sequence[AuditedDocument]) -> Iterator[PrintedPart]:
    """Yield the counts of verdicts on each document, then the items that disagree."""
    yield counts_table({one.document: one for one in audits})
    for audited in audits:
        yield from cause_lines(audited)
        yield from console_lines(audited, MAX_PRINTED_ITEMS)


PRINTED_VALUES_REPORT = Kind(
    name="printed-values",
    findings=AuditedDocument,
    title=lambda audited: audited.title,
    summary=_summary,
    printed=results_to_print,
    verdict=counts_text,
)
