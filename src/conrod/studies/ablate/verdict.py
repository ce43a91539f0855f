"""What follows from measurement for an ingredient, from pairs of models that differ by it alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum

from conrod.studies.ablate.results import Evidence, VariantResult, Verdict
from conrod.studies.paired_clock import PairedTiming

# A difference of this share of the travel (and of omega L, omega^2 L, the torque's peak) is none: what rounding grows
# to in a long chain of steps is a hundred times less, and no user of an engine asks for more.
NO_CHANGE = 1e-9
# A motion is as good as another one while its largest error is at most twice as large. Errors that hang on single
# samples, as those of a contact that chatters, differ by half without any cause.
AS_GOOD = 2.0
# Cost counts where the whole interval of the ratio lies above this. Settings timed against themselves on a busy machine
# of two cores gave medians up to 2.6 % off one, and intervals that began up to 1.9 % above it: where in the memory a
# model happens to lie makes it faster or slower.
COSTS = 1.03
JUDGED = ("position", "velocity", "acceleration", "total")


class Effect(Enum):
    """What an ingredient does to a quantity."""

    NONE = "none"
    NEEDED = "needed"
    WORSE = "worse"
    UNTOLD = "not told"


def levels(minimal: VariantResult) -> dict[str, float]:
    """Errors up to which a run is as good as the minimal model's: its own, or what is none."""
    return {quantity: max((minimal.errors or {}).get(quantity, 0.0), NO_CHANGE) for quantity in JUDGED}


def motion_effect(without: VariantResult, with_it: VariantResult, level: Mapping[str, float]) -> tuple[Effect, str]:
    """What an ingredient does to the observed motion, and what that is seen in.

    Args:
        level: see `levels`.
    """
    if "unsupported" in (without.outcome, with_it.outcome):
        return Effect.UNTOLD, "the engine cannot do it on this machine"
    wrong_without, wrong_with = _wrong(without, level), _wrong(with_it, level)
    if wrong_without and wrong_with:
        return Effect.UNTOLD, f"wrong with and without it ({wrong_with})"
    if wrong_without:
        return Effect.NEEDED, wrong_without
    if wrong_with:
        return Effect.WORSE, wrong_with
    worse = _worse(without, with_it, level)
    return (Effect.WORSE, worse) if worse else (Effect.NONE, "")


def _wrong(run: VariantResult, level: Mapping[str, float]) -> str:
    """In what a run is not as good as the minimal model; empty where it is."""
    if run.errors is None:
        return run.outcome
    return next((q for q in JUDGED if run.errors[q] > AS_GOOD * level[q]), "")


def _worse(without: VariantResult, with_it: VariantResult, level: Mapping[str, float]) -> str:
    """In what a run is no better than the minimal model while it would be without the ingredient."""
    before, after = without.errors or {}, with_it.errors or {}
    return next((q for q in JUDGED if after[q] >= level[q] and after[q] > AS_GOOD * max(before[q], NO_CHANGE)), "")


def torque_effect(without: VariantResult, with_it: VariantResult) -> Effect | None:
    """What an ingredient does to the drive torque; None where that is not told.

    The minimal model is the one that has the motion right, so nothing says that its torque is: two are compared with
    each other.
    """
    before, after = without.torque_error, with_it.torque_error
    if before is None or after is None:
        return None
    if before > AS_GOOD * max(after, NO_CHANGE):
        return Effect.NEEDED
    return Effect.WORSE if after > AS_GOOD * max(before, NO_CHANGE) else Effect.NONE


def costs_time(cost: PairedTiming | None) -> bool:
    """Whether a ratio is above one for certain."""
    return cost is not None and cost.low > COSTS


def verdict(evidence: Sequence[Evidence]) -> tuple[Verdict, str]:
    """What all evidence of an ingredient comes to, and what it was seen in. Harm in any of it counts most."""
    for effect, found in ((Effect.WORSE, Verdict.HARMFUL), (Effect.NEEDED, Verdict.REQUIRED)):
        seen = [one for one in evidence if one.effect == effect.value]
        if seen:
            return found, _seen_in(seen[0], evidence)
    told = [one for one in evidence if one.effect == Effect.NONE.value]
    if not told:
        return Verdict.UNTOLD, evidence[0].because if evidence else ""
    dear = [one for one in told if costs_time(one.cost)]
    if dear:
        return Verdict.COSTLY, _seen_in(dear[0], evidence) if dear[0].full else ""
    if any(one.cost is not None for one in told):
        return Verdict.FREE, ""
    return Verdict.UNTOLD, "it could not be timed"


def _seen_in(one: Evidence, evidence: Sequence[Evidence]) -> str:
    """What evidence shows; where another kind of evidence does not show it, of which kind it is."""
    alone = [other for other in evidence if not other.full]
    where = "with all the others" if one.full and alone else ""
    return ", ".join(text for text in (one.because, where) if text)


def torque_verdict(evidence: Sequence[Evidence]) -> str:
    """The same of the drive torque; empty where no model shows an effect on it."""
    effects = {one.torque_effect for one in evidence}
    if Effect.WORSE.value in effects:
        return Verdict.HARMFUL.slug
    return Verdict.REQUIRED.slug if Effect.NEEDED.value in effects else ""
