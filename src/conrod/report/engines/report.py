"""The report of engines at equal error: a page for each machine, and an index over all of them."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from conrod.report.charts.styles import engine_title
from conrod.report.engines import tables
from conrod.report.figure import Figure
from conrod.report.kind import Index, Page, Part
from conrod.report.sweep.points import timed_points
from conrod.report.sweep.report import KIND as SWEEP
from conrod.report.sweep.work_precision import work_precision_figure
from conrod.report.template import rendered
from conrod.studies.sweep.findings import SweepStudy


def _page(part: Part[SweepStudy]) -> Page:
    study = part.findings
    figure = _diagram(study, f"{study.name}-work-precision") if timed_points(study) else None
    versions = ", ".join(f"{engine_title(name)} {version}" for name, version in study.engines.items())
    text = rendered(
        "engines", study=study, studies=[study], figure=figure, tables=tables, versions=versions, command=part.command
    )
    return Page(text, (figure,) if figure else ())


def _diagram(study: SweepStudy, name: str, *quantities: str) -> Figure:
    alt = f"Error against cost of the presets of all engines, {study.name}"
    return Figure(name, alt, partial(work_precision_figure, study, *([quantities] if quantities else [])))


def _summary(study: SweepStudy) -> dict[str, Any]:
    return {"cheapest": tables.winners_lines([study]), "engines": dict(study.engines), "machine": study.machine}


def _index(index: Index[SweepStudy]) -> Page:
    studies = [index.findings(name) for name in index.entries]
    timed = next((study for study in studies if timed_points(study)), None)
    figure = None if timed is None else _diagram(timed, "acceleration", "acceleration")
    text = rendered(
        "engines-index",
        entries=index.entries,
        studies=studies,
        tables=tables,
        figure=figure,
        versions=index.versions,
        origin=index.origin,
    )
    return Page(text, (figure,) if figure else ())


KIND = replace(SWEEP, name="engines", summary=_summary, page=_page, index=_index)
