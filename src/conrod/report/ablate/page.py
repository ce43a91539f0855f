"""The page of one scene's ingredients, in Markdown."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from conrod.report import numbers
from conrod.report.ablate import words
from conrod.report.ablate import words as prose
from conrod.report.charts.styles import engine_title
from conrod.report.names import FIGURES
from conrod.report.tables import paragraphs, table
from conrod.studies.ablate.plan import Role
from conrod.studies.ablate.results import AblationStudy, EngineAblation, Gruebler, IngredientResult, VariantResult

QUANTITIES = ("position", "velocity", "acceleration")
ROLES = {
    Role.MINIMAL: "minimal",
    Role.ADDED: "minimal + {}",
    Role.REDUCED: "minimal - {}",
    Role.DRESSED: "fully dressed",
    Role.TAKEN: "fully dressed - {}",
    Role.HARMED: "fully dressed + {}",
    Role.ALL: "all ingredients",
}

# A model, and those that are made from it.
FAMILIES = ((Role.MINIMAL, (Role.ADDED, Role.REDUCED)), (Role.DRESSED, (Role.TAKEN, Role.HARMED, Role.ALL)))


def ablate_page(study: AblationStudy, entry: Mapping[str, Any], drawn: Collection[str]) -> str:
    """The page.

    Args:
        entry: of the scene in the document.
        drawn: engines of which there is a figure.
    """
    versions = ", ".join(f"{engine_title(found.engine)} {found.version}" for found in study.engines)
    commands = ", then ".join(f"`{command}`" for command in entry["commands"])
    blocks = [
        f"# {study.name}: what the model needs",
        f"{study.title}, with {versions}. See the [index](README.md) for the other machines.",
        f"Reproduced by {commands}.",
        prose.VERDICTS,
        prose.COLUMNS,
        *(block for found in study.engines for block in _engine(study, found, drawn)),
        "## Degrees of freedom",
        prose.COUNTS,
        f"Gruebler: {words.gruebler_text(study.gruebler)}.",
        *(block for found in study.engines for block in _counts(found, study.gruebler)),
    ]
    return paragraphs(*blocks) + "\n"


def _engine(study: AblationStudy, found: EngineAblation, drawn: Collection[str]) -> list[str]:
    title = engine_title(found.engine)
    shown = (
        f"![Cost and change of every ingredient in {title}, {study.name}]({FIGURES}/{study.name}-{found.engine}.svg)"
    )
    return [
        f"## {title}",
        f"{words.speed_up(found)} {words.left_out(found)}",
        _made_on(found),
        *([shown, prose.FIGURE] if found.engine in drawn else []),
        _ingredients(found),
        *_meanings(found),
        f"### Every model in {title}",
        prose.MODELS,
        _models(found),
    ]


def _made_on(found: EngineAblation) -> str:
    steps, turns = found.steps_per_revolution, numbers.quantity(found.revolutions)
    # An input that cannot turn fully makes one pass.
    runs = f"{turns} revolutions at {steps} steps each"
    made = runs if float(found.revolutions).is_integer() else f"the one pass of {runs}"
    return f"Runs of {made}; costs taken on {found.machine}."


def _ingredients(found: EngineAblation) -> str:
    head = ["ingredient", "in words", "cost alone", "cost in full", "change", "verdict", "drive torque", "needed by"]
    return table(head, [_ingredient(found, one) for one in found.ingredients])


def _ingredient(found: EngineAblation, one: IngredientResult) -> list[str]:
    alone, full = words.alone(one), words.in_full(one)
    beside = ["faster with it"] if words.saves_time(one) else []
    finer = words.finer_text(found, one)
    beside += [finer] if finer else []
    return [
        f"`{one.name}`",
        f"{one.title}{' (part of the minimal model)' if one.minimal else ''}",
        words.cost_of(alone),
        words.cost_of(full),
        words.change_of(alone or full),
        f"**{one.verdict}**{f' ({one.because})' if one.because else ''}{''.join(f'; {text}' for text in beside)}",
        words.torque_text(one),
        words.needs_text(one),
    ]


def _meanings(found: EngineAblation) -> list[str]:
    told = [f"- `{one.name}`: {one.meaning}" for one in found.ingredients if one.meaning]
    return ["What each of them is:", "\n".join(told)] if told else []


# -- all models ------------------------------------------------------------------------------------------------------


def variant_name(variant: VariantResult) -> str:
    """What a model is called."""
    return ROLES[Role(variant.role)].format(variant.ingredient)


def _models(found: EngineAblation) -> str:
    head = ["model", "ended", "cost over minimal", *(f"{q} error" for q in QUANTITIES)]
    head += [*(f"change of {q}" for q in QUANTITIES), "torque error"]
    return table(head, [_model(variant) for variant in found.variants])


def _model(variant: VariantResult) -> list[str]:
    errors, change = variant.errors, variant.change
    ended = f"`{variant.outcome}`" + (f": {variant.reason}" if variant.reason else "")
    return [
        variant_name(variant),
        ended,
        words.cost_text(variant.cost),
        *(numbers.measured(None if errors is None else errors[q]) for q in QUANTITIES),
        *(words.change_text(change, q) for q in QUANTITIES),
        numbers.measured(variant.torque_error),
    ]


# -- counts ----------------------------------------------------------------------------------------------------------


def _counts(found: EngineAblation, gruebler: Gruebler) -> list[str]:
    head = ["model", "degrees of freedom", "constraint rows", "rank", "left", "redundant and empty rows", "missing"]
    titles = {one.name: one.title for one in found.ingredients}
    rows = [_count(alike, gruebler, titles) for alike in _alike(found)]
    return [f"### Counted in {engine_title(found.engine)}", table(head, rows)] if rows else []


def _alike(found: EngineAblation) -> list[Sequence[VariantResult]]:
    """Models of the same count together."""
    groups: dict[str, list[VariantResult]] = {}
    for variant in found.variants:
        if variant.mobility is not None:
            groups.setdefault(repr(variant.mobility), []).append(variant)
    return list(groups.values())


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
        family = [variant for variant in alike if Role(variant.role) in (base, *others)]
        if len(family) > 1 and any(variant.role == base.value for variant in family):
            names.append(f"{ROLES[base]}, and all others made from it that are not named")
        else:
            names += [variant_name(variant) for variant in family]
    return "; ".join(names)
