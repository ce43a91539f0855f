"""Costs, changes, verdicts and counts of a study of ingredients in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from conrod.report import numbers
from conrod.studies.ablate.findings import (
    CompiledCount,
    EngineAblation,
    Evidence,
    Gruebler,
    IngredientResult,
    Role,
    Verdict,
)
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

TORQUE = "drive torque"
POSITION = JUDGED[0]


def cost_text(cost: PairedTiming | None) -> str:
    """A ratio with its interval: `1.44 (1.43 .. 1.45)`."""
    if cost is None:
        return numbers.MISSING
    return f"{ratio_text(cost.ratio)} ({ratio_text(cost.low)} .. {ratio_text(cost.high)})"


def ratio_text(ratio: float) -> str:
    """A ratio of costs: to a hundredth, large ones to a tenth."""
    return f"{ratio:.2f}" if ratio < 9.995 else f"{ratio:.1f}"


def change_text(change: Mapping[str, float] | None, quantity: str = POSITION) -> str:
    """The largest difference of a quantity."""
    return numbers.measured(None if change is None else change[quantity])


def alone(ingredient: IngredientResult) -> Evidence | None:
    """The evidence where no other ingredient was there; None where there is none."""
    return next((one for one in ingredient.evidence if not one.full), None)


def in_full(ingredient: IngredientResult) -> Evidence | None:
    """The evidence among all the others; None where there is none."""
    return next((one for one in ingredient.evidence if one.full), None)


def verdict_text(ingredient: IngredientResult) -> str:
    """The verdict, and what it was seen in."""
    word = ingredient.verdict.value
    return f"{word} ({ingredient.because})" if ingredient.because else word


def saves_time(ingredient: IngredientResult) -> bool:
    """True if it is free and makes the model faster for certain."""
    costs = [one.cost for one in ingredient.evidence if one.cost is not None]
    return ingredient.verdict is Verdict.FREE and bool(costs) and all(c.high < 1.0 / COSTS for c in costs)


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
    reported = [one for one in ingredient.evidence if one.torque_effect is not None]
    if not reported:
        return numbers.MISSING
    if not ingredient.torque:
        return "no change"
    showing = [one for one in reported if torque_verdict([one]) == ingredient.torque]
    first = next((one for one in showing if not one.full), showing[0])
    size = f", by {numbers.measured(first.torque_change)}" if ingredient.torque == CHANGES_TORQUE else ""
    others = f" ({BESIDE_OTHERS})" if first.full and alone(ingredient) else ""
    return f"{ingredient.torque}{size}{others}"


def needs_of(ingredient: IngredientResult) -> tuple[str, ...]:
    """Studies that need an ingredient: of the drive torque where measurement says so, others by what it is."""
    measured = (TORQUE,) if ingredient.torque == Verdict.REQUIRED.value else ()
    return tuple(dict.fromkeys((*measured, *ingredient.needed_by)))


# -- the minimal model against the full one --------------------------------------------------------------------------


def speed_up(found: EngineAblation) -> str:
    """Ratio of the full model's cost to the minimal one's, and by how much their motion differs."""
    full = found.variant(Role.FULL)
    if full is None:
        return "There is no ingredient that could be added."
    if full.cost is None or full.change is None:
        return f"The full model did not run to its end: {full.reason or full.outcome}."
    change = {quantity: numbers.measured(value) for quantity, value in full.change.items()}
    equal = f": they are equal within {numbers.quantity(NO_CHANGE)}" if max(full.change.values()) <= NO_CHANGE else ""
    return (
        f"The minimal model is **{ratio_text(full.cost.ratio)} times** as fast as the full one "
        f"({ratio_text(full.cost.low)} .. {ratio_text(full.cost.high)}), and the observed motion of the two "
        f"differs by at most {change['position']} in position, {change['velocity']} in velocity and "
        f"{change['acceleration']} in acceleration{equal}."
    )


def left_out(found: EngineAblation) -> str:
    """Ingredients that the full model lacks, and what it would be with them; empty where there are none."""
    names = [f"`{variant.ingredient}`" for variant in found.variants if variant.role is Role.HARMED]
    whole = found.variant(Role.ALL)
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
    """Constraints that repeat others, and rows that constrain nothing."""
    repeated = [f"{rows} of {name}" for name, rows in count.redundant.items()]
    parts = [f"redundant: {', '.join(repeated)}"] if repeated else []
    if count.empty:
        parts.append(f"empty: {', '.join(count.empty)}")
    return "; ".join(parts) or "none"


def missing_text(count: CompiledCount, taken: Sequence[str]) -> str:
    """Number of constraints that a model lacks, and with what they were taken away: titles of ingredients."""
    if not count.missing:
        return "none"
    return f"{count.missing}, of {' or '.join(dict.fromkeys(taken))}" if taken else str(count.missing)
