"""The report on printed values that were audited: pages of tables, the index, and lines for the console."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from conrod.own.printed.judging import DIGITS, Audited, Number, Verdict
from conrod.own.printed.judging import Kind as Judgement
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.numbers import MISSING, quantity, rounded
from conrod.report.table import Table, table
from conrod.report.template import rendered

GOOD = (Judgement.AGREES, Judgement.AFTER_ROUNDING)
# Wrong steps first, because other numbers follow from them.
IMPORTANCE = (Judgement.WRONG_STEP, Judgement.MISPRINT)
CONSOLE_ORDER = (Judgement.MISPRINT, Judgement.WRONG_STEP, Judgement.NOT_REPRODUCIBLE, Judgement.EXPLAINED)
# Digits of an exact value beyond the printed ones, shown and saved; of a difference; significant ones of a share.
SHOWN, SAVED, DIFFERENCE, OFF = 3, 6, 4, 4


# -- words -----------------------------------------------------------------------------------------------------------


def is_formula(verdict: Verdict) -> bool:
    """True if the item is no number."""
    return not DIGITS.fullmatch(verdict.printed)


def escaped(text: str) -> str:
    """Text in which Markdown sees no mark of its own."""
    return re.sub(r"([*_<>\[\]`])", r"\\\1", text)


def code(text: str) -> str:
    """A formula as it stands."""
    return f"`{text.replace('`', ' ')}`"


def unsigned_zero(text: str) -> str:
    """The same without the sign of a zero, which is rounding noise."""
    return text.lstrip("+-") if not re.search("[1-9]", text) else text


def share_text(share: float) -> str:
    """A share in percent, in two significant digits and without an exponent."""
    percent = rounded(100.0 * share, 2)
    return f"{percent:.0f}" if percent >= 10.0 else quantity(percent, 2)


def off_text(verdict: Verdict) -> str:
    """Error of the print in percent."""
    return MISSING if verdict.off is None else f"{share_text(verdict.off)} %"


def printed_text(verdict: Verdict) -> str:
    """The print with its unit, or the formula."""
    return code(verdict.printed) if is_formula(verdict) else f"{verdict.printed} {escaped(verdict.unit)}".strip()


def right_text(verdict: Verdict) -> str:
    """The text that is to stand in its place, with the unit."""
    if verdict.should_be is None:
        return MISSING
    number = DIGITS.fullmatch(verdict.should_be)
    if not number and re.search(r"[*^]", verdict.should_be) and " in place of " not in verdict.should_be:
        # A formula is to be copied: no mark of Markdown may come into it.
        return f"**{code(verdict.should_be)}**"
    return f"**{escaped(verdict.should_be)}**" + (f" {escaped(verdict.unit)}".rstrip() if number else "")


def counts_text(audited: Audited) -> str:
    """Number of items with each verdict, in words."""
    count = len(audited.verdicts)
    found = (f"{number} {kind.value}" for kind, number in audited.counts.items() if number)
    return f"{count} item{'s' * (count != 1)}, {', '.join(found)}"


def verdict_text(verdict: Verdict) -> str:
    """The verdict, bold where the print is not right."""
    return verdict.kind.value if verdict.kind in GOOD else f"**{verdict.kind.value}**"


def console_lines(audited: Audited, most: int) -> Iterator[str]:
    """The items that do not agree, first those to be corrected, each with its computation."""
    wrong = sorted((v for v in audited.verdicts if v.kind not in GOOD), key=lambda v: CONSOLE_ORDER.index(v.kind))
    for verdict in wrong[:most]:
        place = f"{verdict.place}: " if verdict.place else ""
        right = "" if verdict.should_be is None else f", should be {verdict.should_be}"
        what = f"{verdict.quantity} at {verdict.condition}: {verdict.printed} {verdict.unit}"
        yield f"{place}{what}{right}: {verdict.kind.value} ({verdict.reason})"
    if len(wrong) > most:
        yield f"... and {len(wrong) - most} more; --out DIR writes all"


# -- tables ----------------------------------------------------------------------------------------------------------


def counts_table(audits: Mapping[str, Audited]) -> Table:
    """Number of items of each document with each verdict; keys are what it is called."""
    head = ["document", *(kind.value.removesuffix(" as printed") for kind in Judgement), "items"]
    rows = [[name, *map(str, one.counts.values()), str(len(one.verdicts))] for name, one in audits.items()]
    return table(head, rows, right=head[1:])


def corrections(verdicts: Sequence[Verdict]) -> list[tuple[Verdict, ...]]:
    """Wrong items in the order of their importance; equal ones that stand in several places together."""
    groups: dict[tuple[str, ...], list[Verdict]] = {}
    for verdict in verdicts:
        if verdict.kind in IMPORTANCE:
            key = (verdict.kind, verdict.quantity, verdict.condition, verdict.printed, str(verdict.should_be))
            groups.setdefault(key, []).append(verdict)
    return sorted((tuple(group) for group in groups.values()), key=lambda group: rank(group[0]))


def rank(verdict: Verdict) -> tuple[float, ...]:
    """Key by which corrections are sorted."""
    return (IMPORTANCE.index(verdict.kind), is_formula(verdict), -round(verdict.off or 0.0, 9), verdict.line)


def _corrections_table(verdicts: Sequence[Verdict]) -> Table:
    rows = [
        [
            str(number), _lines(group), escaped(_what(first)), printed_text(first), right_text(first), off_text(first),
            first.kind.value, escaped(first.reason),
        ]
        for number, group in enumerate(corrections(verdicts), start=1)
        for first in group[:1]
    ]  # fmt: skip
    return table(["", "line", "what", "printed", "should be", "off by", "verdict", "computation"], rows)


def _causes_table(verdicts: Sequence[Verdict]) -> Table:
    causes: dict[str, list[Verdict]] = {}
    for verdict in verdicts:
        if verdict.kind is Judgement.EXPLAINED:
            causes.setdefault(verdict.cause or "", []).append(verdict)
    rows = [[escaped(cause.rstrip(",")), str(len(group))] for cause, group in causes.items()]
    return table(["cause", "items"], rows)


def _numbers_table(verdicts: Sequence[Verdict]) -> Table:
    head = ["line", "where", "quantity", "for", "unit", "printed", "exact", "difference", "verdict", "computation"]
    rows = [
        [
            str(v.line), escaped(v.place), escaped(v.quantity), escaped(v.condition), escaped(v.unit), v.printed,
            MISSING if v.exact is None else unsigned_zero(f"{v.exact:.{Number(v.printed).decimals + SHOWN}f}"),
            MISSING if v.difference is None else unsigned_zero(f"{v.difference:+.2f}"),
            verdict_text(v), escaped(v.reason),
        ]
        for v in verdicts
        if not is_formula(v)
    ]  # fmt: skip
    return table(head, rows)


def _lines(group: Sequence[Verdict]) -> str:
    return ", ".join(str(line) for line in dict.fromkeys(verdict.line for verdict in group))


def _what(verdict: Verdict) -> str:
    subject = ", ".join(filter(None, (verdict.place, verdict.quantity)))
    return subject if is_formula(verdict) or not verdict.condition else f"{subject}: {verdict.condition}"


# -- the report ------------------------------------------------------------------------------------------------------


def page_text(part: Part[Audited], section: str = "", formulas: Table | None = None) -> str:
    """A page in Markdown.

    Args:
        section: more about this document, between the corrections and the items.
        formulas: all of them, where it has some.
    """
    audited = part.findings
    return rendered(
        "printed-values", title=escaped(audited.title), document=escaped(audited.document), command=part.command,
        counts=counts_text(audited), corrections=_corrections_table(audited.verdicts),
        causes=_causes_table(audited.verdicts),
        notes=[escaped(note) for note in audited.notes], section=section, numbers=_numbers_table(audited.verdicts),
        formulas=formulas,
    )  # fmt: skip


def _index(index: Index[Audited]) -> Page:
    audits = {name: index.findings(name) for name in index.entries}
    counts = counts_table({f"[{escaped(one.title)}]({name}.md)": one for name, one in audits.items()})
    return Page(rendered("printed-values-index", counts=counts, origin=index.origin))


def _summary(audited: Audited) -> dict[str, Any]:
    counts = {kind.value: number for kind, number in audited.counts.items()}
    return {"document": audited.document, "counts": counts, "corrections": len(corrections(audited.verdicts))}


def _kept(audited: Audited) -> Audited:
    """Numbers rounded to what comes out the same on every machine."""
    return replace(audited, verdicts=tuple(map(_rounded, audited.verdicts)))


def _rounded(verdict: Verdict) -> Verdict:
    exact, difference, off = verdict.exact, verdict.difference, verdict.off
    if exact is not None:
        exact = None if is_formula(verdict) else round(exact, Number(verdict.printed).decimals + SAVED) + 0.0
    return replace(
        verdict,
        exact=exact,
        difference=None if difference is None else round(difference, DIFFERENCE) + 0.0,
        off=None if off is None else float(f"{off:.{OFF}g}"),
    )


KIND = Kind(
    name="printed-values",
    findings=Audited,
    title=lambda audited: audited.title,
    summary=_summary,
    page=lambda part: Page(page_text(part)),
    index=_index,
    kept=_kept,
)
