"""The standing text of a report on ingredients: what was done, and what its words mean.

Costs, changes, verdicts and counts in words.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from conrod.report import numbers
from conrod.report.numbers import quantity
from conrod.studies.ablate.plan import Role
from conrod.studies.ablate.results import CompiledCount, EngineAblation, Evidence, Gruebler, IngredientResult, Verdict
from conrod.studies.ablate.verdict import (
    AS_GOOD,
    BESIDE_OTHERS,
    CHANGES_TORQUE,
    COSTS,
    JUDGED,
    NO_CHANGE,
    torque_verdict,
)
from conrod.studies.frame.paired_timing import PairedTiming

PURPOSE = (
    "A model carries more than its motion needs. Each ingredient below was added to the minimal model alone, and each "
    "part of that model was taken from it. Then all that do no harm alone were added together, which is the fully "
    "dressed model; from it each was taken away again, and those that do harm were put on top, one by one and all. "
    "What an ingredient costs and what it changes was measured, and the verdict follows from nothing else."
)

_VERDICTS = "\n".join(f"- **{verdict.slug}**: {verdict.meaning}" for verdict in Verdict)
VERDICTS = f"""{_VERDICTS}

A motion is right if no error of it against the exact one (position, velocity, acceleration, position at the nominal \
time) is more than {AS_GOOD:g} times that of the minimal model, or than {quantity(NO_CHANGE)} where that one's is \
smaller. An ingredient costs time if the whole interval of its cost lies above {COSTS:g}: settings timed against \
themselves differ by nearly that. What an ingredient does is looked at where it is alone and where all others are \
there; harm in either counts most, then need, then cost.
"""

COLUMNS = (
    "*Cost* is CPU time with the ingredient over CPU time without it: both models in turns in one process, in short "
    "blocks through the same crank angles; the median, and in brackets the interval that holds it with 95 %. *Alone*: "
    "in the minimal model; *in full*: in the fully dressed one, which of several amounts of one thing has the last. "
    "*Change* is the largest difference of an observed point's position over the run between the two models, over the "
    "travel L. *Drive torque* is what measurement says of the torque against that of the exact motion, with the "
    "weight and the masses that the machine is described with, and over its peak. What the machine is described "
    "without, such as damping, changes it. The last column names all studies that need the ingredient although the "
    "motion may not: by what it is, and of the drive torque also where measurement says so."
)

FIGURE = (
    "Left: what each ingredient costs, filled alone, open in the fully dressed model, with the interval of the median. "
    "Right: how much it changes the position; the shaded part is no change: less than the minimal model's own error, "
    f"or than {quantity(NO_CHANGE)}."
)

MODELS = (
    "Every model that was run. Errors are the largest over the run and the observed points against the exact motion "
    "(over L, ω L, ω² L); the change is against the minimal model, of those with one ingredient taken away against the "
    "fully dressed one. The minimal model is timed against itself, which shows how far such a ratio can be relied on."
)

COUNTS = (
    "Gruebler's count knows the mechanism; the compiled model has its own degrees of freedom, of which the rank of its "
    "constraints' Jacobian is taken away, at 36 crank angles of a turn. Redundant constraints say what others say; "
    "empty rows are those that no coordinate of the model enters. The drive is not counted."
)


TORQUE = "drive torque"
POSITION = JUDGED[0]
RIGHT_WITHOUT = (Verdict.FREE.slug, Verdict.COSTLY.slug)


def cost_text(cost: PairedTiming | None) -> str:
    """A ratio with its interval: `1.44 (1.43 .. 1.45)`."""
    if cost is None:
        return numbers.MISSING
    return f"{ratio_text(cost.ratio)} ({ratio_text(cost.low)} .. {ratio_text(cost.high)})"


def ratio_text(ratio: float) -> str:
    """A ratio of costs: to a hundredth, large ones to a tenth."""
    return f"{ratio:.2f}" if ratio < 9.995 else f"{ratio:.1f}"


def change_text(change: Mapping[str, float] | None, quantity: str = "position") -> str:
    """The largest difference of a quantity."""
    return numbers.measured(None if change is None else change[quantity])


def alone(ingredient: IngredientResult) -> Evidence | None:
    """What was seen of an ingredient where no other one was there; None where it was not looked at so."""
    return next((one for one in ingredient.evidence if not one.full), None)


def in_full(ingredient: IngredientResult) -> Evidence | None:
    """What was seen of it among all the others."""
    return next((one for one in ingredient.evidence if one.full), None)


def cost_of(evidence: Evidence | None) -> str:
    """The cost of an ingredient."""
    return "" if evidence is None else cost_text(evidence.cost)


def change_of(evidence: Evidence | None) -> str:
    """The change of the position that an ingredient makes."""
    return "" if evidence is None else change_text(evidence.change)


def verdict_text(ingredient: IngredientResult) -> str:
    """The verdict, and what it was seen in."""
    return f"{ingredient.verdict} ({ingredient.because})" if ingredient.because else ingredient.verdict


def saves_time(ingredient: IngredientResult) -> bool:
    """Whether it is free and makes the model faster for certain."""
    costs = [one.cost for one in ingredient.evidence if one.cost is not None]
    return ingredient.verdict == Verdict.FREE.slug and bool(costs) and all(c.high < 1.0 / COSTS for c in costs)


def finer_text(found: EngineAblation, ingredient: IngredientResult) -> str:
    """By how much an ingredient makes a position better that is right without it; empty where it does not."""
    minimal = found.variant(Role.MINIMAL.value)
    other = found.variant(Role.REDUCED.value if ingredient.minimal else Role.ADDED.value, ingredient.name)
    without, with_it = (other, minimal) if ingredient.minimal else (minimal, other)
    if ingredient.verdict not in RIGHT_WITHOUT or not (without and without.errors and with_it and with_it.errors):
        return ""
    ratio = without.errors[POSITION] / max(with_it.errors[POSITION], NO_CHANGE)
    return f"position {ratio:.{0 if ratio >= 9.95 else 1}f} times as accurate with it" if ratio > AS_GOOD else ""


def torque_text(ingredient: IngredientResult) -> str:
    """What measurement says of the drive torque: required, harmful, by how much it changes it, or nothing."""
    told = [one for one in ingredient.evidence if one.torque_effect]
    if not told:
        return numbers.MISSING
    if not ingredient.torque:
        return "no change"
    showing = [one for one in told if torque_verdict([one]) == ingredient.torque]
    first = next((one for one in showing if not one.full), showing[0])
    size = f", by {numbers.measured(first.torque_change)}" if ingredient.torque == CHANGES_TORQUE else ""
    beside = f" ({BESIDE_OTHERS})" if first.full and alone(ingredient) else ""
    return f"{ingredient.torque}{size}{beside}"


def needs_of(ingredient: IngredientResult) -> tuple[str, ...]:
    """Studies that need an ingredient: of the drive torque where measurement says so, others by what it is."""
    measured = (TORQUE,) if ingredient.torque == Verdict.REQUIRED.slug else ()
    return tuple(dict.fromkeys((*measured, *ingredient.needed_by)))


def needs_text(ingredient: IngredientResult) -> str:
    """The same in a line."""
    return ", ".join(needs_of(ingredient))


# -- the minimal model against the dressed one -----------------------------------------------------------------------


def speed_up(found: EngineAblation) -> str:
    """How much faster the minimal model is than the dressed one, and by how much their motion differs."""
    dressed = found.variant(Role.DRESSED.value)
    if dressed is None:
        return "There is no ingredient that could be added."
    if dressed.cost is None or dressed.change is None:
        return f"The fully dressed model did not run to its end: {dressed.reason or dressed.outcome}."
    change = {quantity: numbers.measured(value) for quantity, value in dressed.change.items()}
    largest = max(dressed.change.values())
    equal = f": they are equal within {numbers.quantity(NO_CHANGE)}" if largest <= NO_CHANGE else ""
    return (
        f"The minimal model is **{ratio_text(dressed.cost.ratio)} times** as fast as the fully dressed one "
        f"({ratio_text(dressed.cost.low)} .. {ratio_text(dressed.cost.high)}), and the observed motion of the two "
        f"differs by at most {change['position']} in position, {change['velocity']} in velocity and "
        f"{change['acceleration']} in acceleration{equal}."
    )


def left_out(found: EngineAblation) -> str:
    """What the dressed model was not given, and what it would be with it; empty where that is nothing."""
    names = [f"`{variant.ingredient}`" for variant in found.variants if variant.role == Role.HARMED.value]
    whole = found.variant(Role.ALL.value)
    if not names or whole is None:
        return ""
    if whole.change is None:
        end = f"ends as `{whole.outcome}`"
    else:
        cost = f", at {cost_text(whole.cost)} times the cost of the minimal one" if whole.cost else ""
        end = f"is {numbers.measured(whole.change['position'])} off the minimal one in position{cost}"
    each = "it does" if len(names) == 1 else "each of them does"
    return f"Left out of it: {', '.join(names)}; {each} harm alone. A model with everything {end}."


# -- counts ----------------------------------------------------------------------------------------------------------


def gruebler_text(count: Gruebler) -> str:
    """Gruebler's count with its numbers."""
    higher = f" - {count.higher_pairs}" if count.higher_pairs else ""
    return (
        f"n = {count.links} links, j = {count.lower_pairs} lower pairs, h = {count.higher_pairs} higher pairs: "
        f"3 (n - 1) - 2 j - h = {3 * (count.links - 1)} - {2 * count.lower_pairs}{higher} = {count.mobility}"
    )


def freedom_text(count: CompiledCount, mobility: int) -> str:
    """Degrees of freedom that a compiled model has left, and whether these are Gruebler's."""
    poses = "" if count.least_rank == count.most_rank else f" ({count.coordinates - count.least_rank} at some poses)"
    same = "as counted" if count.freedom == mobility else f"**Gruebler: {mobility}**"
    return f"{count.freedom}{poses}, {same}"


def redundant_text(count: CompiledCount) -> str:
    """Constraints that say what others say, and rows that say nothing."""
    repeated = [f"{rows} of {name}" for name, rows in count.redundant.items()]
    parts = [f"redundant: {', '.join(repeated)}"] if repeated else []
    if count.empty:
        parts.append(f"empty: {', '.join(count.empty)}")
    return "; ".join(parts) or "none"


def missing_text(count: CompiledCount, taken: Sequence[str]) -> str:
    """How many constraints a model lacks, and with what they were taken away: titles of ingredients."""
    if not count.missing:
        return "none"
    return f"{count.missing}, of {' or '.join(dict.fromkeys(taken))}" if taken else str(count.missing)
