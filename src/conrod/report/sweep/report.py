"""The report of a sweep: a page for each machine, and an index of the cheapest settings."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure
from conrod.report.html.spots import Spot, spots_in
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.sweep import tables
from conrod.report.sweep.work_precision import work_precision_figure
from conrod.report.table import table
from conrod.report.template import rendered
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.findings import SweepStudy, SweptPoint


def _page(part: Part[SweepStudy]) -> Page:
    study, diagram = part.findings, _diagram(part.findings)
    text = rendered(
        "sweep",
        study=study,
        versions=", ".join(f"{engine_title(name)} {version}" for name, version in study.engines.items()),
        findings=tables.findings(study),
        ends=tables.end_words(study),
        diagram=diagram,
        tables=tables,
        command=part.command,
        one_pass=study.one_pass,
        untimed=len([p for p in study.points if p.completed]) - len(tables.timed_points(study)),
    )
    return Page(text, (diagram,) if diagram else ())


def _diagram(study: SweepStudy) -> Figure | None:
    """Error against cost; None where nothing was timed."""
    if not tables.timed_points(study):
        return None
    alt = f"Error against cost of every run, {study.name}"
    return Figure(f"{study.name}-work-precision", alt, partial(work_precision_figure, study))


def _spots(study: SweepStudy) -> dict[str, list[Spot]]:
    """Spots of the diagram, one for each timed point, with its settings to paste in further lines."""
    diagram = _diagram(study)
    if diagram is None:
        return {}
    figure, points = work_precision_figure(study), tables.timed_points(study)
    found = []
    for axes, quantity in zip(figure.axes, QUANTITIES, strict=True):
        places = [(p.cost or 0.0, p.error(quantity) or 0.0, _words(study, p)) for p in points]
        found += spots_in(figure, axes, places)
    return {diagram.name: found}


def _words(study: SweepStudy, point: SweptPoint) -> str:
    errors = ", ".join(f"{quantity} {numbers.measured(point.error(quantity))}" for quantity in QUANTITIES)
    return (
        f"{point.label}: {engine_title(point.engine)} {point.rule}, {point.steps_per_revolution} steps a revolution: "
        f"errors {errors}; {numbers.duration(point.cost or 0.0)} a revolution.\n{study.lines_of(point)}"
    )


def _summary(study: SweepStudy) -> dict[str, Any]:
    return {"findings": tables.findings(study), "cheapest": tables.cheapest_rows(study, "position")}


def _index(index: Index[SweepStudy]) -> Page:
    studies = [index.findings(name) for name in index.entries]
    rows = [
        [f"[{name}]({entry['page']})", *row]
        for name, entry in index.entries.items()
        for row in entry["summary"]["cheapest"]
    ]
    head = ["machine", "position " + tables.CHEAPEST_HEAD[0], *tables.CHEAPEST_HEAD[1:]]
    figure = _first_figure(studies)
    text = rendered(
        "sweep-index",
        entries=index.entries,
        cheapest=table(head, rows, right=head[4:]),
        figure=figure,
        one_pass=any(study.one_pass for study in studies),
        versions=index.versions,
        origin=index.origin,
    )
    return Page(text, (figure,) if figure else ())


def _first_figure(studies: Sequence[SweepStudy]) -> Figure | None:
    """The diagram of one quantity, of the study with most points; None where none was timed."""
    study = max((study for study in studies if tables.timed_points(study)), key=lambda s: len(s.points), default=None)
    if study is None:
        return None
    alt = f"Position error against cost of every run, {study.name}"
    return Figure("position", alt, partial(work_precision_figure, study, ("position",)))


KIND = Kind(
    name="sweep",
    findings=SweepStudy,
    title=lambda study: study.title,
    summary=_summary,
    page=_page,
    spots=_spots,
    index=_index,
    digits=6,
)
