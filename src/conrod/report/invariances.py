"""The report on invariances: changes that must not matter, what each changed, and the finding in a sentence."""

from __future__ import annotations

from typing import Any

from conrod.mjcf.results import Invariance, InvarianceStudy, Kept
from conrod.report import numbers
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.table import VERDICT, Table, Tone, Toned, table
from conrod.report.template import rendered

TONES: dict[Kept, Tone] = {
    Kept.BROKEN: "bad",
    Kept.EXPLAINED: "odd",
    Kept.BITS: "good",
    Kept.HOLDS: "good",
}


def finding(study: InvarianceStudy) -> str:
    """Summary of what holds and what does not, in a sentence."""
    tried = [one for one in study.found if one.outcome is not Kept.UNSUPPORTED]
    if study.broken:
        sizes = ", ".join(f"{one.change}{_size(one)}" for one in study.broken)
        verb = "is" if len(study.broken) == 1 else "are"
        return f"{len(study.broken)} of {len(tried)} invariances {verb} BROKEN: {sizes}."
    other = [f"{one.change} {one.outcome.value}" for one in tried if TONES[one.outcome] == "odd"]
    return f"None of {len(tried)} invariances is broken{'; ' if other else ''}{', '.join(other)}."


def _size(one: Invariance) -> str:
    """Size of a difference, and the smallest case in which it is out of bounds."""
    if one.difference is None:
        return ""
    when = "" if one.time is None else f", first at {one.time:.4g} s"
    return f" ({numbers.measured(one.difference)} of the largest acceleration{when})"


def invariances_table(study: InvarianceStudy) -> Table:
    """A row for each change."""
    rows = [(one.change, one.bound, _difference(one), _over(one), _verdict(one)) for one in study.found]
    return table(
        ("changed", "must hold to", "difference", "over its bound", VERDICT), rows, ("difference", "over its bound")
    )


def _difference(one: Invariance) -> str:
    return "" if one.difference is None else numbers.measured(one.difference) if one.difference else "0"


def _over(one: Invariance) -> str:
    return "" if one.over_bound is None else f"{one.over_bound:.0e}" if one.over_bound else "0"


def _verdict(one: Invariance) -> Toned | str:
    if one.outcome is Kept.UNSUPPORTED:
        return f"unsupported: {one.reason}"
    words = one.outcome.value.upper() if one.outcome is Kept.BROKEN else one.outcome.value
    if one.cases > 1:
        words += f" in {one.broken} of {one.cases} models" if one.broken else f" in {one.cases} models"
    return Toned(words, TONES[one.outcome])


def notes(study: InvarianceStudy) -> list[str]:
    """The smallest case of what is broken, causes that were found, and how the states were made."""
    cases = [f"{one.change}: broken in the model with {one.case}" for one in study.broken if one.case]
    causes = [f"{one.change}: {one.reason}" for one in study.found if one.outcome is Kept.EXPLAINED]
    return [*cases, *causes, f"MuJoCo {study.engine_version}; {study.run}"]


def _page(part: Part[InvarianceStudy]) -> Page:
    study = part.findings
    results = invariances_table(study)
    text = rendered("invariances", finding=finding(study), results=results, notes=notes(study), part=part)
    return Page(text)


def _summary(study: InvarianceStudy) -> dict[str, Any]:
    return {"passed": study.passed, "finding": finding(study)}


def _index(index: Index[InvarianceStudy]) -> Page:
    return Page(rendered("invariances-index", entries=index.entries, origin=index.origin))


KIND = Kind(
    name="invariances",
    findings=InvarianceStudy,
    title=lambda study: study.name,
    summary=_summary,
    page=_page,
    index=_index,
    results="invariances.json",
    index_file="invariances.md",
    suffix="-invariances",
)
