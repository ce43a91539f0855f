"""The report on a model's ingredients: a page for each machine, and an index of verdicts."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from conrod.report.ablate import tables
from conrod.report.ablate.figure import ingredients_figure
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.template import rendered
from conrod.studies.ablate.findings import MEANINGS, AblationStudy, EngineAblation
from conrod.studies.ablate.verdict import AS_GOOD, COSTS, NO_CHANGE

RULES: dict[str, Any] = {"verdicts": MEANINGS, "as_good": AS_GOOD, "no_change": NO_CHANGE, "costs": COSTS}


def merged(earlier: AblationStudy, new: AblationStudy) -> AblationStudy:
    """The new study with the engines that the earlier one looked at besides; none of another machine's."""
    if (earlier.kind, dict(earlier.parameters)) != (new.kind, dict(new.parameters)):
        return new
    known = {found.engine: found for found in (*earlier.engines, *new.engines)}
    return replace(new, engines=tuple(known.values()), unsupported={**earlier.unsupported, **new.unsupported})


def _figures(study: AblationStudy) -> dict[str, Figure]:
    """Engine -> its figure, of engines that have ingredients."""
    alt = f"Cost and change of every ingredient in {{}}, {study.name}"
    return {
        found.engine: Figure(
            f"{study.name}-{found.engine}", alt.format(engine_title(found.engine)), partial(ingredients_figure, found)
        )
        for found in study.engines
        if found.ingredients
    }


def _finding(found: EngineAblation) -> str:
    return f"{tables.speed_up(found)} {tables.left_out(found)}".strip()


def _page(part: Part[AblationStudy]) -> Page:
    figures = _figures(part.findings)
    names = {"figures": figures, "tables": tables, "title": engine_title, "finding": _finding}
    return Page(
        rendered("ablate", study=part.findings, command=part.command, **names, **RULES), tuple(figures.values())
    )


def _summary(study: AblationStudy) -> dict[str, Any]:
    return {
        "findings": {found.engine: _finding(found) for found in study.engines},
        "verdicts": {
            found.engine: {one.name: one.verdict.value for one in found.ingredients} for found in study.engines
        },
        "engines": {found.engine: found.version for found in study.engines},
        "machines": sorted({found.machine for found in study.engines}),
    }


def _index(index: Index[AblationStudy]) -> Page:
    studies = {name: index.findings(name) for name in index.entries}
    engines = dict.fromkeys(found.engine for study in studies.values() for found in study.engines)
    drawn = [figure for study in studies.values() for figure in _figures(study).values()]
    text = rendered(
        "ablate-index", entries=index.entries, headline=tables.full_table(studies), figure=drawn[0] if drawn else None,
        by_engine={engine_title(engine): tables.verdicts_table(engine, studies) for engine in engines},
        versions=index.versions, origin=index.origin, **RULES,
    )  # fmt: skip
    return Page(text)


KIND = Kind(
    name="ablate",
    findings=AblationStudy,
    title=lambda study: study.title,
    summary=_summary,
    page=_page,
    index=_index,
    merged=merged,
    digits=4,
)
