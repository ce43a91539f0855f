"""What an author is to correct, the most important first."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from conrod.own.printed.judging import Kind, Verdict
from conrod.report.audit.words import counted, is_formula, lines_text, off_text, plain, printed_text, right_text
from conrod.report.tables import paragraphs, table

IMPORTANCE = (Kind.WRONG_STEP, Kind.MISPRINT)
# Items of one cause that are named one by one; more are counted.
NAMED = 6
ORDER = (
    "Wrong steps first, because other numbers follow from them, then misprints; in each, numbers before formulas, and "
    "by how far the print is off (the share of the right value, of a formula's peak); units and names last."
)


def corrections(verdicts: Sequence[Verdict]) -> list[tuple[Verdict, ...]]:
    """Wrong items in the order of their importance; equal ones that stand in several places together."""
    groups: dict[tuple[str, ...], list[Verdict]] = {}
    for verdict in verdicts:
        if verdict.kind in IMPORTANCE:
            key = (verdict.kind, verdict.quantity, verdict.condition, verdict.printed, str(verdict.should_be))
            groups.setdefault(key, []).append(verdict)
    return sorted(
        (tuple(group) for group in groups.values()),
        key=lambda group: rank(group[0]),
    )


def rank(verdict: Verdict) -> tuple[float, ...]:
    """Where a correction stands among the others, the smallest first."""
    share = -round(verdict.off or 0.0, 9)
    return (IMPORTANCE.index(verdict.kind), is_formula(verdict), share, verdict.line)


def corrections_section(verdicts: Sequence[Verdict]) -> str:
    """The corrections, the causes behind what is explained, and what could not be settled."""
    rows = [
        [
            str(number),
            lines_text(v.line for v in group),
            plain(_what(group[0])),
            printed_text(group[0]),
            right_text(group[0]),
            off_text(group[0]),
            group[0].kind.value,
            plain(group[0].reason),
        ]
        for number, group in enumerate(corrections(verdicts), start=1)
    ]
    head = ["", "line", "what", "printed", "should be", "off by", "verdict", "computation"]
    return paragraphs(
        "## What to correct",
        ORDER if rows else "Nothing is wrong.",
        table(head, rows),
        *_explained(verdicts),
        *_open(verdicts),
    )


def _explained(verdicts: Sequence[Verdict]) -> list[str]:
    causes: dict[str, list[Verdict]] = {}
    for verdict in verdicts:
        if verdict.kind is Kind.EXPLAINED:
            causes.setdefault(verdict.cause or "", []).append(verdict)
    if not causes:
        return []
    rows = [
        [plain(cause.rstrip(",")), counted(len(group), "item"), _largest(group), _named(group)]
        for cause, group in causes.items()
    ]
    return [
        "### What a cause explains",
        "These are off for a reason that is at work throughout; each cause was put into the computation and gave the "
        "printed digits. What the exact motion gives stands behind the arrows and in the tables below.",
        table(["cause", "items", "largest difference", "which"], rows),
    ]


def _largest(group: Sequence[Verdict]) -> str:
    differences = [abs(v.difference) for v in group if v.difference is not None]
    if not differences:
        return f"{off_text(max(group, key=lambda v: v.off or 0.0))} of the peak"
    return f"{max(differences):.2f} in the last digit"


def _named(group: Sequence[Verdict]) -> str:
    if len(group) > NAMED:
        return "see below"
    return "; ".join(
        f"line {v.line}, {plain(v.quantity)}" + ("" if is_formula(v) else f": {v.printed} → {right_text(v)}")
        for v in group
    )


def _open(verdicts: Sequence[Verdict]) -> list[str]:
    rows = [
        [str(v.line), plain(_what(v)), printed_text(v), plain(v.reason)]
        for v in verdicts
        if v.kind is Kind.NOT_REPRODUCIBLE
    ]
    if not rows:
        return []
    return [
        "### Not reproducible as printed",
        "Not called wrong: what is known does not lead to the print.",
        table(["line", "what", "printed", "what was tried"], rows),
    ]


def _what(verdict: Verdict) -> str:
    parts: Iterable[str] = (verdict.place, verdict.quantity, "" if is_formula(verdict) else verdict.condition)
    return ": ".join([", ".join(filter(None, list(parts)[:2])), *filter(None, list(parts)[2:])])
