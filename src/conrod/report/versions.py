"""The report on the releases of an engine: what changed when, on the console and as pages."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from statistics import median
from typing import Any

from conrod.engines.registry import look_of
from conrod.report import numbers
from conrod.report.charts.releases import releases_figure
from conrod.report.figure import Figure
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.table import Cell, Table, Toned, table
from conrod.report.template import rendered
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.versions.findings import Change, History, VersionStudy

UNEXPLAINED = "unexplained"

# -- words -------------------------------------------------------------------------------------------------------------


def unsupported_lines(study: VersionStudy) -> list[str]:
    """A line for each release that could not be had."""
    return [f"{study.engine} {version} unsupported: {why}" for version, why in study.unsupported.items()]


def size_words(change: Change) -> str:
    """How a run changed: its outcome, the sizes of what is above rounding, or that last digits did."""
    if change.outcomes[0] != change.outcomes[1]:
        return f"{change.outcomes[0]}, now {change.outcomes[1]}"
    if not change.size:
        return f"other bits, {change.outcomes[1]}"
    if not change.last_digits:
        above = {q: size for q, size in change.size.items() if size > numbers.ROUNDING}
        return ", ".join(f"{quantity} {numbers.measured(size)}" for quantity, size in above.items())
    return "last digits, of outputs alone" if change.in_outputs_alone else "last digits"


def explanation(change: Change) -> Cell:
    """What the changelog says that can be the cause."""
    return " ".join(change.explained) if change.explained else Toned(UNEXPLAINED, "odd")


def headline(study: VersionStudy) -> str:
    """The largest change of position, and how many changes the changelog does not name."""
    changes = [(one, change) for version in study.measured for one, change in study.changes_at(version)]
    if not changes:
        return "No release changed a bit."
    unnamed = sum(not change.explained for _, change in changes)
    said = f"{len(changes)} changes of a run from one release to the next, {unnamed} of them unexplained"
    sized = [
        (change.size["position"], one, change) for one, change in changes if change.size and not change.last_digits
    ]
    if not sized:
        return f"{said}; none is more than last digits."
    size, one, change = max(sized, key=lambda each: each[0])
    where = f"{change.version} ({one.scene}, {one.settings}: position {numbers.measured(size)} of L)"
    return f"{said}; the largest came with {where}."


# -- tables ------------------------------------------------------------------------------------------------------------


def changes_table(study: VersionStudy) -> Table:
    """A row for each change of a run from one release to the next."""
    rows = [
        (version, one.scene, one.settings, size_words(change), *_errors(one, change), explanation(change))
        for version in study.measured
        for one, change in study.changes_at(version)
    ]
    title = f"{look_of(study.engine).title}: what changed from the release before, over L, ω L, ω² L"
    headings = ("release", "scene", "settings", "motion changed by", "position error before", "after", "its changelog")
    return table(headings, rows, title=title, names=3)


def _errors(one: History, change: Change) -> Iterable[str]:
    """The position error before and after."""
    runs = {run.version: run for run in one.runs}
    return [numbers.measured(runs[version].errors["position"]) for version in (change.before, change.version)]


def releases_table(study: VersionStudy) -> Table:
    """A row for each release: how many runs changed and how, what they cost."""
    newest = {(one.scene, one.settings): one.runs[-1].seconds for one in study.histories}
    rows = []
    for k, version in enumerate(study.measured):
        changes = [change for _, change in study.changes_at(version)]
        others = [c for c in changes if c.outcomes[0] != c.outcomes[1]]
        more = [c for c in changes if c.size and not c.last_digits]
        largest = [max((c.size[q] for c in more), default=None) for q in QUANTITIES]
        costs = [
            cost / last
            for one in study.histories
            if (cost := one.runs[k].seconds) and (last := newest[one.scene, one.settings])
        ]
        unnamed = sum(not c.explained for c in changes)
        rows.append(
            (
                version,
                *(str(n) if n else "" for n in (len(changes), len(changes) - len(others) - len(more), len(others))),
                *("" if size is None else numbers.measured(size) for size in largest),
                str(unnamed) if unnamed else "",
                f"{median(costs):.2f}" if costs else numbers.MISSING,
            )
        )
    headings = (
        "release", "runs changed", "last digits", "outcome", *QUANTITIES, UNEXPLAINED, "cost",
    )  # fmt: skip
    return table(headings, rows, headings[1:])


def runs_table(study: VersionStudy) -> Table:
    """A row for each run at the releases where it changed: outcome, errors, orders, costs."""
    rows = []
    for one in study.histories:
        for k, run in enumerate(one.runs):
            if k and one.change_at(run.version) is None:
                continue
            orders = ", ".join(numbers.order(run.order[q]) for q in QUANTITIES)
            errors = [numbers.measured(run.errors[q]) for q in QUANTITIES]
            cost = "n/a" if run.ratio is None else f"{run.ratio:.0f}"
            rows.append((one.scene, one.settings, run.version, run.outcome, *errors, orders, cost))
    headings = ("scene", "settings", "from", "outcome", *QUANTITIES, "order x, v, a", "cost ratio")
    return table(headings, rows, (*QUANTITIES, "cost ratio"), names=2)


# -- pages -------------------------------------------------------------------------------------------------------------


def _figure(study: VersionStudy) -> Figure:
    alt = f"Which runs changed with each release of {look_of(study.engine).title}, and by how much"
    return Figure(study.engine, alt, partial(releases_figure, study))


def _page(part: Part[VersionStudy]) -> Page:
    study, figure = part.findings, _figure(part.findings)
    text = rendered(
        "versions", study=study, title=look_of(study.engine).title, figure=figure, headline=headline(study),
        releases=releases_table(study), changes=changes_table(study), runs=runs_table(study),
        unsupported=unsupported_lines(study), command=part.command,
    )  # fmt: skip
    return Page(text, (figure,))


def _summary(study: VersionStudy) -> dict[str, Any]:
    return {"headline": headline(study), "releases": list(study.measured)}


def _index(index: Index[VersionStudy]) -> Page:
    studies = {name: index.findings(name) for name in index.entries}
    figures = {name: _figure(study) for name, study in studies.items()}
    return Page(rendered("versions-index", entries=index.entries, figures=figures, origin=index.origin))


KIND = Kind(
    name="versions",
    findings=VersionStudy,
    title=lambda study: look_of(study.engine).title,
    summary=_summary,
    page=_page,
    index=_index,
    digits=4,
)
