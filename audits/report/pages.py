"""The kind of report on the four documents: that on printed values, with formulas and what else is to be said."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from audits.report.cam_figures import pressure_angle, series_error
from audits.report.corrections import causes_table, corrections, corrections_table, formulas_table, is_formula
from audits.report.sections import cam_section, module_section, saw_section
from conrod.own.printed.verdicts import Audited, Number, Verdict
from conrod.report import printed_values
from conrod.report.figure import Figure
from conrod.report.kind import Index, Page, Part
from conrod.report.printed_values import counts_table, counts_text, escaped, numbers_table
from conrod.report.table import Table, in_markdown
from conrod.report.template import bullets, table_text, unwrapped

# Digits of an exact value beyond the printed ones, and of a difference, that are saved; significant ones of a share.
SAVED, DIFFERENCE, OFF = 6, 4, 4
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


def _page(part: Part[Audited]) -> Page:
    audited, section = part.findings, SECTIONS.get(part.name, lambda: "")
    text = _rendered(
        "page.md.jinja", title=escaped(audited.title), document=escaped(audited.document), command=part.command,
        counts=counts_text(audited), corrections=corrections_table(audited.verdicts),
        causes=causes_table(audited.verdicts), notes=[escaped(note) for note in audited.notes], section=section(),
        numbers=numbers_table([verdict for verdict in audited.verdicts if not is_formula(verdict)]),
        formulas=formulas_table(audited.verdicts),
    )  # fmt: skip
    return Page(text, FIGURES.get(part.name, ()))


def _index(index: Index[Audited]) -> Page:
    audits = {name: index.findings(name) for name in index.entries}
    counts = counts_table({f"[{escaped(one.title)}]({name}.md)": one for name, one in audits.items()})
    return Page(_rendered("index.md.jinja", counts=counts, origin=index.origin))


def _rendered(template: str, **names: Any) -> str:
    """A page from a template beside this module."""
    environment = Environment(
        loader=PackageLoader("audits.report", "."), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        finalize=lambda value: in_markdown(table_text(value) if isinstance(value, Table) else value),
    )  # fmt: skip
    environment.filters["bullets"] = bullets
    return unwrapped(environment.get_template(template).render(**names))


def _summary(audited: Audited) -> dict[str, Any]:
    return {**printed_values.KIND.summary(audited), "corrections": len(corrections(audited.verdicts))}


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


KIND = replace(printed_values.KIND, name="documents", page=_page, index=_index, summary=_summary, kept=_kept)
