"""What `conrod audit` prints."""

from __future__ import annotations

from collections.abc import Sequence

from rich.markup import escape
from rich.table import Table

from conrod.audit import Audited, Kind, Verdict, count
from conrod.console import console

# Items of a user's file that are told one by one.
MOST = 20
GOOD = (Kind.AGREES, Kind.AFTER_ROUNDING)
ORDER = (Kind.MISPRINT, Kind.WRONG_STEP, Kind.NOT_REPRODUCIBLE, Kind.EXPLAINED)


def print_counts(audits: Sequence[Audited]) -> None:
    """A line a document: how many items have which verdict."""
    out = console()
    shown = Table(box=None, pad_edge=False)
    shown.add_column("document")
    for kind in Kind:
        shown.add_column(kind.value.removesuffix(" as printed"), justify="right")
    shown.add_column("items", justify="right")
    for audited in audits:
        name = f"{audited.document} {audited.name}" if audited.shipped else audited.document
        shown.add_row(escape(name), *(str(n) for n in count(audited.verdicts).values()), str(len(audited.verdicts)))
    out.print(shown)


def print_items(audited: Audited) -> None:
    """The items that do not agree, each with what it should be."""
    out = console()
    # What is to be corrected first, in the order of the file; what one cause explains comes last.
    told = sorted((v for v in audited.verdicts if v.kind not in GOOD), key=lambda verdict: ORDER.index(verdict.kind))
    for verdict in told[:MOST]:
        out.print(_told(verdict), markup=False, highlight=False, soft_wrap=True)
    if len(told) > MOST:
        out.print(f"... and {len(told) - MOST} more; --out DIR writes all", markup=False, soft_wrap=True)


def _told(verdict: Verdict) -> str:
    right = "" if verdict.should_be is None else f", should be {verdict.should_be}"
    place = f"{verdict.place}: " if verdict.place else ""
    what = f"{verdict.quantity} at {verdict.condition}: {verdict.printed} {verdict.unit}"
    return f"{place}{what}{right}: {verdict.kind.value} ({verdict.reason})"
