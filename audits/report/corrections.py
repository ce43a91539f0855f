"""What a document has to correct: its wrong items in the order of their importance, its formulas, and causes."""

from __future__ import annotations

import re
from collections.abc import Sequence

from conrod.models.printed.report import escape_marks, verdict_text
from conrod.models.printed.verdicts import NUMBER_PATTERN, PrintedVerdict, VerdictKind
from conrod.report.numbers import MISSING, quantity, round_to_digits
from conrod.report.table import Table, table

# Wrong steps first, because other numbers follow from them.
IMPORTANCE = (VerdictKind.WRONG_STEP, VerdictKind.MISPRINT)


def is_formula(verdict: PrintedVerdict) -> bool:
    """True if the item is no number."""
    return not NUMBER_PATTERN.fullmatch(verdict.printed)


def code(text: str) -> str:
    """A formula as it stands."""
    return f"`{text.replace('`', ' ')}`"


def share_text(share: float) -> str:
    """A share in percent, in two significant digits and without an exponent."""
    percent = round_to_digits(100.0 * share, 2)
    return f"{percent:.0f}" if percent >= 10.0 else quantity(percent, 2)


def off_text(verdict: PrintedVerdict) -> str:
    """Error of the print in percent."""
    return MISSING if verdict.off is None else f"{share_text(verdict.off)} %"


def printed_text(verdict: PrintedVerdict) -> str:
    """The print with its unit, or the formula."""
    return code(verdict.printed) if is_formula(verdict) else f"{verdict.printed} {escape_marks(verdict.unit)}".strip()


def right_text(verdict: PrintedVerdict) -> str:
    """The text that is to stand in its place, with the unit."""
    if verdict.should_be is None:
        return MISSING
    number = NUMBER_PATTERN.fullmatch(verdict.should_be)
    if not number and re.search(r"[*^]", verdict.should_be) and " in place of " not in verdict.should_be:
        # A formula is to be copied: no mark of Markdown may come into it.
        return f"**{code(verdict.should_be)}**"
    return f"**{escape_marks(verdict.should_be)}**" + (f" {escape_marks(verdict.unit)}".rstrip() if number else "")


def corrections(verdicts: Sequence[PrintedVerdict]) -> list[tuple[PrintedVerdict, ...]]:
    """Wrong items in the order of their importance; equal ones that stand in several places together."""
    groups: dict[tuple[str, ...], list[PrintedVerdict]] = {}
    for verdict in verdicts:
        if verdict.kind in IMPORTANCE:
            key = (verdict.kind, verdict.quantity, verdict.condition, verdict.printed, str(verdict.should_be))
            groups.setdefault(key, []).append(verdict)
    return sorted((tuple(group) for group in groups.values()), key=lambda group: rank(group[0]))


def rank(verdict: PrintedVerdict) -> tuple[float, ...]:
    """Key by which corrections are sorted."""
    return (IMPORTANCE.index(verdict.kind), is_formula(verdict), -round(verdict.off or 0.0, 9), verdict.line)


def corrections_table(verdicts: Sequence[PrintedVerdict]) -> Table:
    """Wrong items with what should stand in their places."""
    rows = [
        [
            str(number), _lines(group), escape_marks(_what(first)), printed_text(first), right_text(first),
            off_text(first), first.kind.value, escape_marks(first.reason),
        ]
        for number, group in enumerate(corrections(verdicts), start=1)
        for first in group[:1]
    ]  # fmt: skip
    return table(["", "line", "what", "printed", "should be", "off by", "verdict", "computation"], rows)


def causes_table(verdicts: Sequence[PrintedVerdict]) -> Table:
    """Causes with how many items each explains."""
    causes: dict[str, list[PrintedVerdict]] = {}
    for verdict in verdicts:
        if verdict.kind is VerdictKind.EXPLAINED:
            causes.setdefault(verdict.cause or "", []).append(verdict)
    rows = [[escape_marks(cause.rstrip(",")), str(len(group))] for cause, group in causes.items()]
    return table(["cause", "items"], rows)


def formulas_table(verdicts: Sequence[PrintedVerdict]) -> Table:
    """All formulas of a document."""
    rows = [
        [
            str(v.line), escape_marks(v.place), escape_marks(v.quantity), code(v.printed), off_text(v), verdict_text(v),
            right_text(v), escape_marks(v.reason),
        ]
        for v in verdicts
        if is_formula(v)
    ]  # fmt: skip
    return table(["line", "where", "quantity", "printed", "off by", "verdict", "should be", "computation"], rows)


def _lines(group: Sequence[PrintedVerdict]) -> str:
    return ", ".join(str(line) for line in dict.fromkeys(verdict.line for verdict in group))


def _what(verdict: PrintedVerdict) -> str:
    subject = ", ".join(filter(None, (verdict.place, verdict.quantity)))
    return subject if is_formula(verdict) or not verdict.condition else f"{subject}: {verdict.condition}"
