"""The report on invariances: changes that must not matter, the difference that each made, and a verdict."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from conrod.models.invariances.results import Invariance, InvarianceOutcome, InvarianceStudy
from conrod.report import numbers
from conrod.report.kind import Kind
from conrod.report.table import VERDICT, Cell, ColouredCell, Table, table
from conrod.report.terminal import PrintedPart, verdict_line


def finding(study: InvarianceStudy) -> str:
    """Say in a sentence how many invariances hold, and which are broken."""
    tried = sum(one.outcome is not InvarianceOutcome.UNSUPPORTED for one in study.found)
    if not study.broken:
        return f"None of {tried} invariances is broken."
    sizes = ", ".join(f"{one.change}{_size_words(one)}" for one in study.broken)
    return f"{len(study.broken)} of {tried} invariances {'is' if len(study.broken) == 1 else 'are'} BROKEN: {sizes}."


def _size_words(one: Invariance) -> str:
    """Say how large a difference is, and when it first occurs."""
    if one.difference is None:
        return ""
    when = "" if one.time is None else f", first at {one.time:.4g} s"
    return f" ({numbers.measured_text(one.difference)} of the largest acceleration{when})"


def invariances_table(study: InvarianceStudy) -> Table:
    """Return a row for each change, with the difference that it made."""
    rows: list[tuple[Cell, ...]] = []
    for one in study.found:
        difference, over = (
            "" if value is None else text(value) if value else "0"
            for value, text in ((one.difference, numbers.measured_text), (one.over_bound, "{:.0e}".format))
        )
        rows.append((one.change, one.bound, difference, over, _verdict_cell(one)))
    measured = "difference", "over its bound"
    return table(("changed", "must hold to", *measured, VERDICT), rows, measured)


def _verdict_cell(one: Invariance) -> Cell:
    if one.outcome is InvarianceOutcome.UNSUPPORTED:
        return f"unsupported: {one.reason}"
    broken = one.outcome is InvarianceOutcome.BROKEN
    words = one.outcome.value.upper() if broken else one.outcome.value
    if one.cases > 1:
        words += f" in {one.broken} of {one.cases} models" if one.broken else f" in {one.cases} models"
    return ColouredCell(words, "bad" if broken else "good")


def notes(study: InvarianceStudy) -> list[str]:
    """List the smallest model that breaks each broken invariance, and describe the runs."""
    cases = [f"{one.change}: broken in the model with {one.case}" for one in study.broken if one.case]
    return [*cases, f"MuJoCo {study.engine_version}; {study.run}"]


def _summary(study: InvarianceStudy) -> dict[str, Any]:
    return {"passed": study.passed, "finding": finding(study)}


def results_to_print(studies: Sequence[InvarianceStudy]) -> Iterator[PrintedPart]:
    """Yield the verdict on each model, a table of the changes, and notes."""
    for study in studies:
        yield verdict_line(f"{study.name}: {finding(study)}", study.passed)
        yield invariances_table(study)
        yield from (*notes(study), "")


INVARIANCES_REPORT = Kind(
    name="invariances",
    findings=InvarianceStudy,
    title=lambda study: study.name,
    summary=_summary,
    printed=results_to_print,
    verdict=finding,
    results="invariances.json",
    index_file="invariances.md",
    suffix="-invariances",
)
