"""Verdicts on an ingredient, from measurements of pairs of models that differ by it alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from conrod.runs.trajectory import Outcome
from conrod.studies.ablate.findings import Effect, Evidence, Role, VariantResult, Verdict
from conrod.studies.frame.paired_timing import PairedTiming

# A difference of this share of the travel (and of omega L, omega^2 L) is none: what rounding grows
# to in a long chain of steps is a hundred times less, and no user of an engine asks for more.
NO_CHANGE = 1e-9
# A motion is as good as another one while its largest error is at most twice as large. Errors that hang on single
# samples, as those of a contact that chatters, differ by half without any cause.
AS_GOOD = 2.0
# Cost counts where the whole interval of the ratio lies above this. Settings timed against themselves, twenty times on
# a busy machine of two cores, gave medians up to 2.6 % off one and an interval that began 1.9 % above it: two models
# of one kind differ a little for as long as they live.
COSTS = 1.03
BESIDE_OTHERS = "beside all others"
JUDGED = ("position", "velocity", "acceleration", "total")


def levels(minimal: VariantResult) -> dict[str, float]:
    """Errors up to which a run is as good as can be asked for: the minimal model's own, or what is none."""
    own = minimal.errors or {}
    return {q: max(own.get(q, 0.0), NO_CHANGE) for q in JUDGED}


def evidence_of(model: VariantResult, base: VariantResult, level: Mapping[str, float]) -> Evidence:
    """Evidence of a model and the one that it is made from on the ingredient that they differ by."""
    removed, full = model.role is not Role.ADDED, model.role is Role.TAKEN
    without, with_it = (model, base) if removed else (base, model)
    cost = model.cost_in_full if full else model.cost
    effect, because = motion_effect(without, with_it, level)
    return Evidence(full, cost.inverse if cost and removed else cost, model.change, effect, because)


def motion_effect(without: VariantResult, with_it: VariantResult, level: Mapping[str, float]) -> tuple[Effect, str]:
    """Effect of an ingredient on the observed motion, and what it is seen in."""
    for run in (without, with_it):
        if run.outcome == Outcome.UNSUPPORTED.slug:
            return Effect.UNDECIDED, run.reason
    wrong_without, wrong_with = _wrong(without, level), _wrong(with_it, level)
    if wrong_without and wrong_with:
        return Effect.UNDECIDED, f"wrong with it and without: {wrong_with}"
    if wrong_without:
        return Effect.REQUIRED, wrong_without
    if wrong_with:
        return Effect.WORSE, wrong_with
    worse = _worse(without, with_it, level)
    return (Effect.WORSE, f"{worse}, better without it") if worse else (Effect.NONE, "")


def _wrong(run: VariantResult, level: Mapping[str, float]) -> str:
    """In what a run is not as good as the minimal model; empty where it is."""
    if run.errors is None:
        return run.outcome
    return next((q for q in JUDGED if run.errors[q] > AS_GOOD * level[q]), "")


def _worse(without: VariantResult, with_it: VariantResult, level: Mapping[str, float]) -> str:
    """In what a run is no better than the minimal model while it would be without the ingredient."""
    before, after = without.errors or {}, with_it.errors or {}
    return next((q for q in JUDGED if after[q] >= level[q] and after[q] > AS_GOOD * max(before[q], NO_CHANGE)), "")


def costs_time(cost: PairedTiming | None) -> bool:
    """True if a ratio is above one for certain."""
    return cost is not None and cost.low > COSTS


def verdict(evidence: Sequence[Evidence]) -> tuple[Verdict, str]:
    """Verdict of all evidence on an ingredient, and what it was seen in. Harm in any of it counts most."""
    for effect, found in ((Effect.WORSE, Verdict.HARMFUL), (Effect.REQUIRED, Verdict.REQUIRED)):
        seen = [one for one in evidence if one.effect is effect]
        if seen:
            return found, _seen_in(seen[0], evidence)
    decided = [one for one in evidence if one.effect is Effect.NONE]
    if not decided:
        return Verdict.UNDECIDED, evidence[0].because if evidence else ""
    dear = [one for one in decided if costs_time(one.cost)]
    if dear:
        return Verdict.COSTLY, _seen_in(dear[0], evidence)
    if any(one.cost is not None for one in decided):
        return Verdict.FREE, ""
    return Verdict.UNDECIDED, "it could not be timed"


def _seen_in(one: Evidence, evidence: Sequence[Evidence]) -> str:
    """Reason that evidence gives; where the ingredient alone does not show it, that it takes the others."""
    alone = any(not other.full for other in evidence)
    return ", ".join(text for text in (one.because, BESIDE_OTHERS if one.full and alone else "") if text)
