"""The report on a model's ingredients: costs, changes and verdicts of each machine, and an index of verdicts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from conrod.execution.paired_timing import PairedTiming
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.kind import Kind
from conrod.report.numbers import lengths
from conrod.report.results import distrust_lines, distrust_words
from conrod.report.table import Cell, ColouredCell, Table, Tone, table
from conrod.report.template import join_words
from conrod.report.terminal import PrintedPart
from conrod.studies.ablate.findings import (
    JUDGED_ERRORS,
    MAX_EQUAL_ERROR_RATIO,
    MAX_NO_CHANGE,
    MIN_COST_RATIO,
    VERDICT_MEANINGS,
    AblationStudy,
    EngineAblation,
    IngredientResult,
    IngredientVerdict,
    Role,
)

ABSENT = "-"
TONES: Mapping[IngredientVerdict, Tone] = {
    IngredientVerdict.FREE: "good",
    IngredientVerdict.COSTLY: "odd",
    IngredientVerdict.HARMFUL: "bad",
}


CAPTION = (
    "cost: with it over without it, the median and the interval that holds it with 95 %; change: of the position, "
    "over the travel L"
)


def cost_text(cost: PairedTiming | None) -> str:
    """Return a cost ratio with its 95 % interval: `1.44 (1.43 .. 1.45)`."""
    if cost is None:
        return numbers.MISSING
    ratio, low, high = (f"{x:.{2 if x < 9.995 else 1}f}" for x in (cost.ratio, cost.low, cost.high))
    return f"{ratio} ({low} .. {high})"


# -- ingredients -----------------------------------------------------------------------------------------------------


def ingredients_table(found: EngineAblation, title: str = "") -> Table:
    """Return a row for each ingredient: cost, change, verdict, and the studies that need it."""
    head = ("ingredient", "cost alone", "cost in full", "change", "verdict", "needed by")
    return table(head, [_ingredient_cells(one) for one in found.ingredients], title=title)


def _ingredient_cells(one: IngredientResult) -> list[Cell]:
    pair = [next((e for e in one.evidence if e.full is full), None) for full in (False, True)]
    first = pair[0] or pair[1]
    verdict = f"{one.verdict.value} ({one.because})" if one.because else one.verdict.value
    return [
        f"{one.name}{' (part of the minimal model)' if one.minimal else ''}",
        *("" if evidence is None else cost_text(evidence.cost) for evidence in pair),
        "" if first is None else numbers.error("position", first.change and first.change["position"]),
        ColouredCell(verdict, TONES[one.verdict]) if one.verdict in TONES else verdict,
        ", ".join(one.needed_by),
    ]


def engines_of(studies: Mapping[str, AblationStudy]) -> list[str]:
    """Names of the engines of all studies, each once."""
    return list(dict.fromkeys(found.engine for study in studies.values() for found in study.engines))


def verdicts_table(engine: str, studies: Mapping[str, AblationStudy]) -> Table:
    """Return a row for each ingredient of an engine, with its verdict on each machine."""
    found = {name: one for name, study in studies.items() for one in study.engines if one.engine == engine}
    named = {name: {one.name: one for one in of_engine.ingredients} for name, of_engine in found.items()}
    rows = []
    for name in dict.fromkeys(name for own in named.values() for name in own):
        known = [own[name] for own in named.values() if name in own]
        needs = dict.fromkeys(need for one in known for need in one.needed_by)
        verdicts = [own[name].verdict.value if name in own else ABSENT for own in named.values()]
        rows.append([f"`{name}`", *verdicts, ", ".join(needs)])
    return table(["ingredient", *found, "needed by studies of"], rows)


def speed_up(found: EngineAblation) -> str:
    """Say how many ingredients can go, how much cheaper that makes a step, and how the motions differ."""
    full = found.variant(Role.FULL)
    if full is None:
        return "There is no ingredient that could be added."
    if full.cost is None or full.change is None:
        return f"The full model did not run to its end: {full.reason or full.outcome}."
    changes = join_words([f"{numbers.measured_text(value)} in {quantity}" for quantity, value in full.change.items()])
    equal = max(full.change.values()) <= MAX_NO_CHANGE
    change = f"is equal within {numbers.quantity(MAX_NO_CHANGE)}" if equal else f"differs by at most {changes}"
    interval = cost_text(full.cost).partition(" ")[2]
    return f"Of what a naive model contains, {_gain(found, interval)} The observed motion of the two {change}."


def largest_gain(studies: Mapping[str, AblationStudy]) -> str:
    """State the largest gain of all machines and engines; empty if no full model completed."""
    gains = [
        (full.cost.ratio, name, found)
        for name, study in studies.items()
        for found in study.engines
        if (full := found.variant(Role.FULL)) and full.cost and full.errors
    ]
    if not gains:
        return ""
    _, name, found = max(gains, key=lambda gain: gain[0])
    return f"Of what a naive model of {name} contains in {engine_title(found.engine)}, {_gain(found)}"


def _gain(found: EngineAblation, interval: str = "") -> str:
    """The number of ingredients that can go, how much cheaper that makes a step, and the error then, as a clause."""
    minimal, full = found.variants[0], found.variant(Role.FULL)
    assert full is not None
    assert full.cost is not None
    ratio, count = cost_text(full.cost).partition(" ")[0], len(found.needless)
    many = f"{count} ingredient{'s' * (count != 1)} can go"
    own, other = minimal.errors or {}, full.errors or {}
    larger = max(own[q] / max(other[q], MAX_NO_CHANGE) for q in JUDGED_ERRORS)
    error = "the same error" if larger <= MAX_EQUAL_ERROR_RATIO else f"{numbers.measured_text(larger)} times the error"
    return f"{many}: that makes a step **{ratio} times** cheaper {interval}{' ' * bool(interval)}at {error}."


def absent_words(found: EngineAblation) -> str:
    """Say which ingredients of the engine the machine cannot have, and why; empty if it can have all."""
    reasons = dict.fromkeys(found.absent.values())
    named = {reason: [name for name, why in found.absent.items() if why == reason] for reason in reasons}
    parts = [f"{join_words(names)} ({reason})" for reason, names in named.items()]
    return f"Not on this machine: {'; '.join(parts)}." if parts else ""


# -- pages -------------------------------------------------------------------------------------------------------------

RULES = {
    "verdicts": VERDICT_MEANINGS,
    "as_good": MAX_EQUAL_ERROR_RATIO,
    "no_change": MAX_NO_CHANGE,
    "costs": MIN_COST_RATIO,
}  # quoted in pages


def _summary(study: AblationStudy) -> dict[str, Any]:
    return {
        "findings": {found.engine: speed_up(found) for found in study.engines},
        "verdicts": {
            found.engine: {one.name: one.verdict.value for one in found.ingredients} for found in study.engines
        },
        "engines": {found.engine: found.version for found in study.engines},
        "machines": sorted({found.machine for found in study.engines}),
    }


def results_to_print(studies: Sequence[AblationStudy]) -> Iterator[PrintedPart]:
    """Yield costs, changes and verdicts of all ingredients, and the speed-up of each engine."""
    yield from distrust_lines(studies)
    for study in studies:
        for found in study.engines:
            if found.ingredients:
                yield ingredients_table(found, f"{study.name}, {found.engine}")
                yield CAPTION + lengths(study.lengths)
            if found.absent:
                yield f"{found.engine}: {absent_words(found)}"
            yield speed_up(found).replace("**", "")
        yield from (f"{name} unsupported: {why}" for name, why in study.unsupported.items())
    if named := [one.name for study in studies for found in study.engines for one in found.ingredients]:
        yield f"what an ingredient is, or a verdict: conrod explain {named[0]}"


def verdict(study: AblationStudy) -> str:
    """Say for each engine how much faster the minimal model runs, or that its figures cannot be trusted."""
    found = distrust_words(study) or " ".join(speed_up(found).replace("**", "") for found in study.engines)
    return f"{study.name}: {found}"


SPEED_UP = re.compile(r"\*\*([\d.]+ times)\*\*")  # in the words of `speed_up`


def headline(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Say how many times as fast as the full model the minimal one is, by machine and engine."""
    found = [
        f"{name} {engine_title(engine)} {ratio[1]}"
        for name, entry in entries.items()
        for engine, words in entry["summary"]["findings"].items()
        if (ratio := SPEED_UP.search(words))
    ]
    return f"The minimal model is faster than the full one: {', '.join(found)}." if found else ""


ABLATE_REPORT = Kind(
    name="ablate",
    findings=AblationStudy,
    title=lambda study: study.title,
    summary=_summary,
    printed=results_to_print,
    verdict=verdict,
    headline=headline,
    digits=4,
)
