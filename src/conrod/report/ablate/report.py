"""The report on a model's ingredients: a page for each machine, and an index of verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from conrod.report import numbers
from conrod.report.ablate import words
from conrod.report.ablate.figure import ingredients_figure
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.table import Cell, Table, Tone, Toned, table
from conrod.report.template import rendered
from conrod.studies.ablate.findings import (
    MEANINGS,
    AblationStudy,
    EngineAblation,
    Gruebler,
    IngredientResult,
    Role,
    VariantResult,
    Verdict,
)
from conrod.studies.ablate.verdict import AS_GOOD, COSTS, JUDGED, NO_CHANGE
from conrod.studies.frame.measurement import QUANTITIES

ABSENT = "-"
TONES: Mapping[Verdict, Tone] = {Verdict.FREE: "good", Verdict.COSTLY: "odd", Verdict.HARMFUL: "bad"}
ROLES = {
    Role.MINIMAL: "minimal",
    Role.ADDED: "minimal + {}",
    Role.REDUCED: "minimal - {}",
    Role.FULL: "full",
    Role.TAKEN: "full - {}",
    Role.HARMED: "full + {}",
    Role.ALL: "all ingredients",
}
# A model, and those that are made from it.
FAMILIES = ((Role.MINIMAL, (Role.ADDED, Role.REDUCED)), (Role.FULL, (Role.TAKEN, Role.HARMED, Role.ALL)))


def merged(earlier: AblationStudy, new: AblationStudy) -> AblationStudy:
    """The new study with the engines that the earlier one looked at besides; none of another machine's."""
    if (earlier.kind, dict(earlier.parameters)) != (new.kind, dict(new.parameters)):
        return new
    known = {found.engine: found for found in (*earlier.engines, *new.engines)}
    return replace(new, engines=tuple(known.values()), unsupported={**earlier.unsupported, **new.unsupported})


# -- tables ----------------------------------------------------------------------------------------------------------


def ingredients_table(found: EngineAblation, title: str = "") -> Table:
    """A row for each ingredient: cost, change, verdict, and which studies need it."""
    head = ("ingredient", "in words", "cost alone", "cost in full", "change", "verdict", "drive torque", "needed by")
    return table(head, [_ingredient(found, one) for one in found.ingredients], title=title)


def _ingredient(found: EngineAblation, one: IngredientResult) -> list[Cell]:
    alone, full = words.alone(one), words.in_full(one)
    first = alone or full
    more = [*(["faster with it"] if words.saves_time(one) else []), words.finer_text(found, one)]
    verdict = "; ".join([words.verdict_text(one), *filter(None, more)])
    return [
        one.name,
        f"{one.title}{' (part of the minimal model)' if one.minimal else ''}",
        *("" if evidence is None else words.cost_text(evidence.cost) for evidence in (alone, full)),
        "" if first is None else words.change_text(first.change),
        Toned(verdict, TONES[one.verdict]) if one.verdict in TONES else verdict,
        words.torque_text(one),
        ", ".join(words.needs_of(one)),
    ]


def models_table(found: EngineAblation) -> Table:
    """A row for each model that was run."""
    head = ["model", "ended", "cost over minimal", *(f"{q} error" for q in QUANTITIES)]
    head += [*(f"change of {q}" for q in QUANTITIES), "torque error"]
    return table(head, [_model(variant) for variant in found.variants], right=head[3:])


def _model(variant: VariantResult) -> list[str]:
    errors = variant.errors
    return [
        ROLES[variant.role].format(variant.ingredient),
        f"`{variant.outcome}`" + (f": {variant.reason}" if variant.reason else ""),
        words.cost_text(variant.cost),
        *(numbers.measured(None if errors is None else errors[q]) for q in QUANTITIES),
        *(words.change_text(variant.change, q) for q in QUANTITIES),
        numbers.measured(variant.torque_error),
    ]


def counts_table(found: EngineAblation, gruebler: Gruebler) -> Table:
    """A row for all models of the same count."""
    head = ["model", "degrees of freedom", "constraint rows", "rank", "left", "redundant and empty rows", "missing"]
    groups: dict[str, list[VariantResult]] = {}
    for variant in found.variants:
        if variant.mobility is not None:
            groups.setdefault(repr(variant.mobility), []).append(variant)
    titles = {one.name: one.title for one in found.ingredients}
    return table(head, [_count(alike, gruebler, titles) for alike in groups.values()])


def _count(alike: Sequence[VariantResult], gruebler: Gruebler, titles: Mapping[str, str]) -> list[str]:
    count = alike[0].mobility
    assert count is not None
    rank = str(count.most_rank) if count.least_rank == count.most_rank else f"{count.least_rank} .. {count.most_rank}"
    return [
        _names(alike),
        str(count.coordinates),
        str(count.rows),
        rank,
        words.freedom_text(count, gruebler.mobility),
        words.redundant_text(count),
        words.missing_text(count, [titles[variant.ingredient] for variant in alike if variant.ingredient in titles]),
    ]


def _names(alike: Sequence[VariantResult]) -> str:
    """Their names; where most of those made from a model are like it, that they are."""
    names = []
    for base, others in FAMILIES:
        family = [variant for variant in alike if variant.role in (base, *others)]
        if len(family) > 1 and any(variant.role is base for variant in family):
            names.append(f"{ROLES[base]}, and all others made from it that are not named")
        else:
            names += [ROLES[variant.role].format(variant.ingredient) for variant in family]
    return "; ".join(names)


# -- pages -----------------------------------------------------------------------------------------------------------


def _figures(study: AblationStudy) -> dict[str, Figure]:
    """Engine -> its figure, of engines that have ingredients."""
    alt = "Cost and change of every ingredient in {}, {}"
    return {
        found.engine: Figure(
            f"{study.name}-{found.engine}",
            alt.format(engine_title(found.engine), study.name),
            partial(ingredients_figure, found),
        )
        for found in study.engines
        if found.ingredients
    }


def _page(part: Part[AblationStudy]) -> Page:
    study, figures = part.findings, _figures(part.findings)
    engines = [
        {
            "title": engine_title(found.engine),
            "found": found,
            "finding": f"{words.speed_up(found)} {words.left_out(found)}",
            "figure": figures.get(found.engine),
            # An input that cannot turn fully makes one pass.
            "pass": not float(found.revolutions).is_integer(),
            "ingredients": ingredients_table(found),
            "models": models_table(found),
            "counts": counts_table(found, study.gruebler),
        }
        for found in study.engines
    ]
    text = rendered(
        "ablate", study=study, command=part.command, engines=engines, verdicts=MEANINGS, as_good=AS_GOOD,
        no_change=NO_CHANGE, costs=COSTS, gruebler=words.gruebler_text(study.gruebler),
    )  # fmt: skip
    return Page(text, tuple(figures.values()))


def _summary(study: AblationStudy) -> dict[str, Any]:
    return {
        "findings": {found.engine: f"{words.speed_up(found)} {words.left_out(found)}" for found in study.engines},
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
        "ablate-index", entries=index.entries, headline=_headline(studies), figure=drawn[0] if drawn else None,
        by_engine={engine_title(engine): _verdicts(engine, studies) for engine in engines}, verdicts=MEANINGS,
        as_good=AS_GOOD, no_change=NO_CHANGE, costs=COSTS, versions=_versions(index.entries), origin=index.origin,
    )  # fmt: skip
    return Page(text)


def _headline(studies: Mapping[str, AblationStudy]) -> Table:
    head = ["machine", "engine", "full over minimal, CPU time", "largest difference of the observed position"]
    head += ["position error, minimal", "position error, full"]
    return table(head, [_full(name, found) for name, study in studies.items() for found in study.engines])


def _full(name: str, found: EngineAblation) -> list[str]:
    minimal, full = found.variant(Role.MINIMAL), found.variant(Role.FULL)
    first = [f"[{name}]({name}.md)", engine_title(found.engine)]
    if minimal is None or full is None:
        return [*first, *[ABSENT] * 4]
    errors = [numbers.measured(v.errors[JUDGED[0]]) if v.errors else f"`{v.outcome}`" for v in (minimal, full)]
    return [*first, words.cost_text(full.cost), words.change_text(full.change), *errors]


def _verdicts(engine: str, studies: Mapping[str, AblationStudy]) -> Table:
    """A row for each ingredient, a column for each machine."""
    found = {name: one for name, study in studies.items() for one in study.engines if one.engine == engine}
    named = {name: {one.name: one for one in of_engine.ingredients} for name, of_engine in found.items()}
    rows = []
    for name in dict.fromkeys(name for own in named.values() for name in own):
        known = [own[name] for own in named.values() if name in own]
        needs = dict.fromkeys(need for one in known for need in words.needs_of(one))
        verdicts = [own[name].verdict.value if name in own else ABSENT for own in named.values()]
        rows.append([f"`{name}`", known[0].title, *verdicts, ", ".join(needs)])
    return table(["ingredient", "in words", *found, "needed by studies of"], rows)


def _versions(entries: Mapping[str, Mapping[str, Any]]) -> Table:
    """All versions that occur: scenes that were looked at earlier stay as they were."""
    found: dict[str, set[str]] = {"conrod": {entry["conrod"] for entry in entries.values()}}
    for summary in (entry["summary"] for entry in entries.values()):
        for engine, version in summary["engines"].items():
            found.setdefault(engine_title(engine), set()).add(version)
        found.setdefault("costs taken on", set()).update(summary["machines"])
    return table(["what", "which"], [[name, "; ".join(sorted(versions))] for name, versions in found.items()])


KIND = Kind(
    name="ablate",
    findings=AblationStudy,
    title=lambda study: study.title,
    summary=_summary,
    page=_page,
    index=_index,
    digits=4,
)
