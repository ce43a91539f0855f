"""The kind of report on the four documents: that on printed values, with formulas and what else is to be said."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from audits.report.cam_figures import pressure_angle, series_error
from audits.report.sections import cam_section, module_section, saw_section
from conrod.own.printed.judging import Audited, Verdict
from conrod.report import printed_values
from conrod.report.figure import Figure
from conrod.report.kind import Page, Part
from conrod.report.printed_values import code, escaped, is_formula, off_text, page_text, right_text, verdict_text
from conrod.report.table import Table, table

# By page: what is said of a document beyond its items, and its figures.
SECTIONS: Mapping[str, Callable[[], str]] = {
    "course-module": module_section, "power-hacksaw": saw_section, "arc-cam": cam_section,
}  # fmt: skip
FIGURES = {
    "arc-cam": (
        Figure("series-error", "Error of the series over the cam angle for R = 36 mm", series_error),
        Figure("pressure-angle", "Largest pressure angle of every cam, with the rule of 30 degrees", pressure_angle),
    )
}


def formulas_table(verdicts: tuple[Verdict, ...]) -> Table:
    """All formulas of a document."""
    rows = [
        [
            str(v.line), escaped(v.place), escaped(v.quantity), code(v.printed), off_text(v), verdict_text(v),
            right_text(v), escaped(v.reason),
        ]
        for v in verdicts
        if is_formula(v)
    ]  # fmt: skip
    return table(["line", "where", "quantity", "printed", "off by", "verdict", "should be", "computation"], rows)


def _page(part: Part[Audited]) -> Page:
    section = SECTIONS[part.name]() if part.name in SECTIONS else ""
    text = page_text(part, section, formulas_table(part.findings.verdicts))
    return Page(text, FIGURES.get(part.name, ()))


KIND = replace(printed_values.KIND, name="documents", page=_page)
