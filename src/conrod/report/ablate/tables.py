"""Tables of a study of ingredients: costs, changes and verdicts, every model that was run, and degrees of freedom."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from conrod.engines.mobility import MobilityCount
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.table import Cell, Table, Tone, Toned, table
from conrod.report.template import listed
from conrod.studies.ablate.findings import (
    AblationStudy,
    EngineAblation,
    Evidence,
    IngredientResult,
    Role,
    VariantResult,
    Verdict,
)
from conrod.studies.ablate.verdict import (
    AS_GOOD,
    BESIDE_OTHERS,
    CHANGES_TORQUE,
    COSTS,
    NO_CHANGE,
    torque_verdict,
)
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.frame.paired_timing import PairedTiming

ABSENT = "-"
TORQUE, POSITION = "drive torque", "position"
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
NAMED = 3  # of models with one count


def cost_text(cost: PairedTiming | None) -> str:
    """A ratio with its interval, to a hundredth, large ones to a tenth: `1.44 (1.43 .. 1.45)`."""
    if cost is None:
        return numbers.MISSING
    ratio, low, high = (f"{x:.{2 if x < 9.995 else 1}f}" for x in (cost.ratio, cost.low, cost.high))
    return f"{ratio} ({low} .. {high})"


def _change(
    change: Mapping[str, float] | None, quantity: str = POSITION, lengths: Mapping[str, float] = MappingProxyType({})
) -> str:
    return numbers.error(quantity, None if change is None else change[quantity], lengths)


# -- ingredients -----------------------------------------------------------------------------------------------------


def ingredients_table(found: EngineAblation, title: str = "") -> Table:
    """A row for each ingredient: cost, change, verdict, and which studies need it."""
    head = ("ingredient", "cost alone", "cost in full", "change", "verdict", TORQUE, "needed by")
    return table(head, [_ingredient(found, one) for one in found.ingredients], title=title)


def _ingredient(found: EngineAblation, one: IngredientResult) -> list[Cell]:
    pair = [next((e for e in one.evidence if e.full is full), None) for full in (False, True)]
    first = pair[0] or pair[1]
    verdict = f"{one.verdict.value} ({one.because})" if one.because else one.verdict.value
    costs = [evidence.cost for evidence in one.evidence if evidence.cost is not None]
    saves = one.verdict is Verdict.FREE and costs and all(cost.high < 1.0 / COSTS for cost in costs)
    verdict = "; ".join(filter(None, [verdict, "faster with it" if saves else "", finer_text(found, one)]))
    return [
        f"{one.name}{' (part of the minimal model)' if one.minimal else ''}",
        *("" if evidence is None else cost_text(evidence.cost) for evidence in pair),
        "" if first is None else _change(first.change),
        Toned(verdict, TONES[one.verdict]) if one.verdict in TONES else verdict,
        torque_text(one),
        ", ".join(_needs(one)),
    ]


def finer_text(found: EngineAblation, ingredient: IngredientResult) -> str:
    """By how much an ingredient makes a position better that is right without it; empty where it does not."""
    minimal = found.variant(Role.MINIMAL)
    other = found.variant(Role.REDUCED if ingredient.minimal else Role.ADDED, ingredient.name)
    without, with_it = (other, minimal) if ingredient.minimal else (minimal, other)
    right_without = ingredient.verdict in (Verdict.FREE, Verdict.COSTLY)
    if not right_without or not (without and without.errors and with_it and with_it.errors):
        return ""
    ratio = without.errors[POSITION] / max(with_it.errors[POSITION], NO_CHANGE)
    return f"position {ratio:.{0 if ratio >= 9.95 else 1}f} times as accurate with it" if ratio > AS_GOOD else ""


def torque_text(ingredient: IngredientResult) -> str:
    """Effect on the drive torque: required, harmful, by how much it changes it, or nothing."""
    if all(one.torque_effect is None for one in ingredient.evidence):
        return numbers.MISSING
    if not ingredient.torque:
        return "no change"
    showing: list[Evidence] = [one for one in ingredient.evidence if torque_verdict([one]) == ingredient.torque]
    first = min(showing, key=lambda one: one.full)
    size = f", by {numbers.measured(first.torque_change)}" if ingredient.torque == CHANGES_TORQUE else ""
    others = f" ({BESIDE_OTHERS})" if first.full and not all(one.full for one in ingredient.evidence) else ""
    return f"{ingredient.torque}{size}{others}"


def _needs(ingredient: IngredientResult) -> tuple[str, ...]:
    """Studies that need an ingredient: of the drive torque where measurement says so, others by what it is."""
    measured = (TORQUE,) if ingredient.torque == Verdict.REQUIRED.value else ()
    return tuple(dict.fromkeys((*measured, *ingredient.needed_by)))


def verdicts_table(engine: str, studies: Mapping[str, AblationStudy]) -> Table:
    """A row for each ingredient of an engine, a column for each machine."""
    found = {name: one for name, study in studies.items() for one in study.engines if one.engine == engine}
    named = {name: {one.name: one for one in of_engine.ingredients} for name, of_engine in found.items()}
    rows = []
    for name in dict.fromkeys(name for own in named.values() for name in own):
        known = [own[name] for own in named.values() if name in own]
        needs = dict.fromkeys(need for one in known for need in _needs(one))
        verdicts = [own[name].verdict.value if name in own else ABSENT for own in named.values()]
        rows.append([f"`{name}`", *verdicts, ", ".join(needs)])
    return table(["ingredient", *found, "needed by studies of"], rows)


# -- models ----------------------------------------------------------------------------------------------------------


def models_table(found: EngineAblation, lengths: Mapping[str, float]) -> Table:
    """A row for each model that was run; L [m] by point."""
    head = ["model", "ended", "cost over minimal", *(f"{q} error" for q in QUANTITIES)]
    head += [*(f"change of {q}" for q in QUANTITIES), "torque error"]
    rows = [
        [
            ROLES[variant.role].format(variant.ingredient),
            f"`{variant.outcome}`" + (f": {variant.reason}" if variant.reason else ""),
            cost_text(variant.cost),
            *(_change(size, q, lengths) for size in (variant.errors, variant.change) for q in QUANTITIES),
            numbers.measured(variant.torque_error),
        ]
        for variant in found.variants
    ]
    return table(head, rows, right=head[3:])


def full_table(studies: Mapping[str, AblationStudy]) -> Table:
    """The full model beside the minimal one, a row for each machine and engine."""
    head = ["machine", "engine", "full over minimal, CPU time", "largest difference of the observed position"]
    head += ["position error, minimal", "position error, full"]
    rows = []
    for name, study in studies.items():
        for found in study.engines:
            minimal, full, cells = found.variant(Role.MINIMAL), found.variant(Role.FULL), [ABSENT] * 4
            if minimal and full:
                errors = [
                    _change(v.errors, lengths=study.lengths) if v.errors else f"`{v.outcome}`" for v in (minimal, full)
                ]
                cells = [cost_text(full.cost), _change(full.change, lengths=study.lengths), *errors]
            rows.append([f"[{name}]({name}.md)", engine_title(found.engine), *cells])
    return table(head, rows)


def speed_up(found: EngineAblation) -> str:
    """Ratio of the full model's cost to the minimal one's, and by how much their motion differs."""
    full = found.variant(Role.FULL)
    if full is None:
        return "There is no ingredient that could be added."
    if full.cost is None or full.change is None:
        return f"The full model did not run to its end: {full.reason or full.outcome}."
    changes = listed([f"{numbers.measured(value)} in {quantity}" for quantity, value in full.change.items()])
    equal = f": they are equal within {numbers.quantity(NO_CHANGE)}" if max(full.change.values()) <= NO_CHANGE else ""
    ratio, _, interval = cost_text(full.cost).partition(" ")
    return (
        f"The minimal model is **{ratio} times** as fast as the full one {interval}, and the observed motion of the "
        f"two differs by at most {changes}{equal}."
    )


def left_out(found: EngineAblation) -> str:
    """Ingredients that the full model lacks, and what it would be with them; empty where there are none."""
    names = [f"`{variant.ingredient}`" for variant in found.variants if variant.role is Role.HARMED]
    whole = found.variant(Role.ALL)
    if not names or whole is None:
        return ""
    cost = f", at {cost_text(whole.cost)} times the cost of the minimal one" if whole.cost else ""
    off = f"is {_change(whole.change)} off the minimal one in position{cost}"
    end = f"ends as `{whole.outcome}`" if whole.change is None else off
    return f"Left out of it, as it does harm alone: {', '.join(names)}. A model with everything {end}."


# -- degrees of freedom ----------------------------------------------------------------------------------------------


def counts_table(found: EngineAblation, mobility: int) -> Table:
    """A row for all models of the same count, beside Gruebler's mobility."""
    head = ["model", "degrees of freedom", "constraint rows", "rank", "left", "redundant and empty rows", "missing"]
    groups: dict[str, list[VariantResult]] = {}
    for variant in found.variants:
        if variant.mobility is not None:
            groups.setdefault(repr(variant.mobility), []).append(variant)
    titles = {one.name: one.title for one in found.ingredients}
    rows = []
    for alike in groups.values():
        taken = dict.fromkeys(titles[variant.ingredient] for variant in alike if variant.ingredient in titles)
        names = [ROLES[variant.role].format(variant.ingredient) for variant in alike]
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        rows.append(["; ".join(names[:NAMED]) + more, *_count(alike[0].mobility, mobility, " or ".join(taken))])
    return table(head, rows)


def _count(count: MobilityCount | None, mobility: int, taken: str) -> list[str]:
    assert count is not None
    some_poses = count.least_rank != count.most_rank
    poses = f" ({count.most_freedom} at some poses)" if some_poses else ""
    same = "as counted" if count.freedom == mobility else f"**Gruebler: {mobility}**"
    repeated = ", ".join(f"{rows} of {name}" for name, rows in count.redundant.items())
    idle = {"redundant": repeated, "empty": ", ".join(count.empty)}
    return [
        str(count.coordinates),
        str(count.rows),
        f"{count.least_rank} .. {count.most_rank}" if some_poses else str(count.most_rank),
        f"{count.freedom}{poses}, {same}",
        "; ".join(f"{what}: {which}" for what, which in idle.items() if which) or "none",
        (f"{count.missing}, of {taken}" if taken else str(count.missing)) if count.missing else "none",
    ]
