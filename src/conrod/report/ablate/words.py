"""Costs, changes, verdicts and counts in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from conrod.report import numbers
from conrod.studies.ablate.results import (
    CompiledCount,
    EngineAblation,
    Evidence,
    Gruebler,
    IngredientResult,
    Verdict,
)
from conrod.studies.ablate.variants import Role
from conrod.studies.ablate.verdict import COSTS
from conrod.studies.paired_clock import PairedTiming

TORQUE = "drive torque"
# A model's constraints are named one by one up to so many.
NAMED = 4


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


def torque_text(ingredient: IngredientResult) -> str:
    """What measurement says of the drive torque: required, harmful, no change, or nothing."""
    if not any(one.torque_effect for one in ingredient.evidence):
        return numbers.MISSING
    return ingredient.torque or "no change"


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
        return "No ingredient is there to be added."
    if dressed.cost is None or dressed.change is None:
        return f"The fully dressed model did not run to its end: {dressed.reason or dressed.outcome}."
    cost = dressed.cost
    return (
        f"The minimal model is **{ratio_text(cost.ratio)} times** as fast as the fully dressed one "
        f"({ratio_text(cost.low)} .. {ratio_text(cost.high)}), and the observed motion of the two differs by at most "
        f"{numbers.measured(dressed.change['position'])} in position, {numbers.measured(dressed.change['velocity'])} "
        f"in velocity and {numbers.measured(dressed.change['acceleration'])} in acceleration."
    )


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
    parts = [f"redundant: {_listed(repeated)}"] if repeated else []
    if count.empty:
        parts.append(f"empty: {_listed(count.empty)}")
    return "; ".join(parts) or "none"


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(names[:NAMED])
    return shown if len(names) <= NAMED else f"{shown} and {len(names) - NAMED} more"
