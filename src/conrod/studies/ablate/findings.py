"""Findings of an ablation study as plain values, and the verdict on each ingredient."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from conrod.comparison.trajectory import Outcome
from conrod.execution.paired_timing import PairedTiming


class Role(Enum):
    """Role of a model in an ablation study."""

    MINIMAL = "minimal"
    ADDED_TO_MINIMAL = "added"  # minimal with one more ingredient
    REMOVED_FROM_MINIMAL = "reduced"  # minimal without one of its ingredients
    FULL = "full"  # minimal with all ingredients that have no effect on it
    REMOVED_FROM_FULL = "taken"  # full without one of these, or without an ingredient that minimal does not require


class Effect(Enum):
    """Effect of an ingredient on the observed motion."""

    NONE = "none"
    REQUIRED = "required"
    WORSE = "worse"
    UNDECIDED = "undecided"


class IngredientVerdict(Enum):
    """Verdict on an ingredient, from measured errors and costs."""

    REQUIRED = "required"
    FREE = "free"
    COSTLY = "costly"
    HARMFUL = "harmful"
    UNDECIDED = "undecided"


VERDICT_MEANINGS = {
    IngredientVerdict.REQUIRED: "without it the observed motion is wrong",
    IngredientVerdict.FREE: "the motion is right with it and without it, and it costs nothing",
    IngredientVerdict.COSTLY: "the motion is right with it and without it, and it costs time",
    IngredientVerdict.HARMFUL: "makes the motion worse",
    IngredientVerdict.UNDECIDED: "no measurement decides",
}


@dataclass(frozen=True)
class VariantResult:
    """Result of one model of a study.

    Attributes:
        role, ingredient: see `conrod.studies.ablate.study.Variant`.
        outcome, reason: how its run ended.
        errors: largest errors of the observed points: position, velocity, acceleration, total; None unless the run
            completed.
        change: largest difference of the observed points from the model it is compared with, at the same crank angles:
            position, velocity, acceleration, normalised as errors are; None unless both completed.
        cost: timing over the minimal model; None unless the run completed and could be timed.
        cost_in_full: timing over the full model, of a model with one ingredient removed from it.
        settings: settings as plain values.
    """

    role: Role
    ingredient: str
    outcome: str
    reason: str
    errors: Mapping[str, float] | None
    change: Mapping[str, float] | None
    cost: PairedTiming | None
    cost_in_full: PairedTiming | None
    settings: Mapping[str, Any]


@dataclass(frozen=True)
class Evidence:
    """Evidence on an ingredient from two models that differ by it alone.

    Attributes:
        full: True if the models have all other ingredients, False if they have only the minimal ones.
        cost: cost with the ingredient over cost without it.
        change: change of the observed motion by quantity.
        effect: effect of the ingredient on the motion.
        because: quantity that shows the effect, or the outcome of a run that did not complete.
    """

    full: bool
    cost: PairedTiming | None
    change: Mapping[str, float] | None
    effect: Effect
    because: str


@dataclass(frozen=True)
class IngredientResult:
    """Verdict on an ingredient, with its evidence.

    Attributes:
        name, meaning, minimal: see `engines.variants.Ingredient`.
        needed_by: quantities that need it by definition.
        because: quantity or outcome that decided the verdict.
    """

    name: str
    meaning: str
    minimal: bool
    needed_by: tuple[str, ...]
    verdict: IngredientVerdict
    because: str
    evidence: tuple[Evidence, ...]


@dataclass(frozen=True)
class EngineAblation:
    """Findings of an ablation study in one engine.

    Attributes:
        machine: fingerprint of the machine on which the costs were measured.
        ingredients: verdicts in the order of the engine's list.
        variants: results of all models, the minimal model first.
        distrust: scenes and engines whose figures cannot be trusted, and why, in words; empty if all can.
        absent: reasons why the machine cannot have ingredients of the engine, by name.
    """

    engine: str
    version: str
    steps_per_revolution: int
    revolutions: float
    machine: str
    ingredients: tuple[IngredientResult, ...]
    variants: tuple[VariantResult, ...]
    distrust: str = ""
    absent: Mapping[str, str] = field(default_factory=dict)

    def variant(self, role: Role, ingredient: str = "") -> VariantResult | None:
        """Return the result of the model with a role and an ingredient; None if it was not run."""
        return next((v for v in self.variants if (v.role, v.ingredient) == (role, ingredient)), None)

    @property
    def needless(self) -> tuple[str, ...]:
        """Names of the full model's ingredients that the minimal model has not, and whose verdict is free or costly."""
        verdicts = (IngredientVerdict.FREE, IngredientVerdict.COSTLY)
        return tuple(one.name for one in self.ingredients if not one.minimal and one.verdict in verdicts)


@dataclass(frozen=True)
class AblationStudy:
    """Findings of an ablation study on one scene.

    Attributes:
        name, kind, title, parameters: identification of the scene.
        engines: findings by engine.
        unsupported: reasons why engines have no ingredients to study, by engine name.
        lengths: length L of each observed point [m]; empty in reports of an earlier conrod.
    """

    name: str
    kind: str
    title: str
    parameters: Mapping[str, Any]
    engines: tuple[EngineAblation, ...]
    unsupported: Mapping[str, str]
    lengths: Mapping[str, float] = field(default_factory=dict)

    @property
    def distrust(self) -> str:
        """Engines whose figures cannot be trusted, and why, in words; empty if all can."""
        return "; ".join(found.distrust for found in self.engines if found.distrust)


# A difference up to this share of the travel L (of omega L, omega^2 L) counts as none: rounding over many steps is a
# hundred times smaller, and no user of an engine needs a smaller one.
MAX_NO_CHANGE = 1e-9
# A motion is as good as another if its largest error is at most this many times larger. Errors of single samples, as of
# a contact that chatters, differ by half without a cause.
MAX_EQUAL_ERROR_RATIO = 2.0
# An ingredient costs time if the whole 95 % interval of its cost ratio lies above this. Settings timed against
# themselves, twenty times on a busy machine of two cores, gave medians up to 2.6 % from 1 and an interval that began
# 1.9 % above 1: two equal models in memory differ a little.
MIN_COST_RATIO = 1.03
IN_FULL_MODEL = "beside all others"  # words in a verdict
JUDGED_ERRORS = ("position", "velocity", "acceleration", "total")


def reference_errors(minimal: VariantResult) -> dict[str, float]:
    """Return the errors that changes are compared with: the minimal model's, at least MAX_NO_CHANGE."""
    own = minimal.errors or {}
    return {q: max(own.get(q, 0.0), MAX_NO_CHANGE) for q in JUDGED_ERRORS}


def evidence_of(model: VariantResult, base: VariantResult, level: Mapping[str, float]) -> Evidence:
    """Return the evidence of two models on the ingredient by which they differ."""
    removed, full = model.role is not Role.ADDED_TO_MINIMAL, model.role is Role.REMOVED_FROM_FULL
    without, with_it = (model, base) if removed else (base, model)
    cost = model.cost_in_full if full else model.cost
    effect, because = motion_effect(without, with_it, level)
    return Evidence(full, cost.inverse if cost and removed else cost, model.change, effect, because)


def motion_effect(without: VariantResult, with_it: VariantResult, level: Mapping[str, float]) -> tuple[Effect, str]:
    """Return the effect of an ingredient on the motion, with what shows it."""
    for run in (without, with_it):
        if run.outcome == Outcome.UNSUPPORTED.slug:
            return Effect.UNDECIDED, run.reason
    wrong_without, wrong_with = _wrong_quantity(without, level), _wrong_quantity(with_it, level)
    if wrong_without and wrong_with:
        return Effect.UNDECIDED, f"wrong with it and without: {wrong_with}"
    if wrong_without:
        return Effect.REQUIRED, wrong_without
    if wrong_with:
        return Effect.WORSE, wrong_with
    worse = _worsened_quantity(without, with_it, level)
    return (Effect.WORSE, f"{worse}, better without it") if worse else (Effect.NONE, "")


def _wrong_quantity(run: VariantResult, level: Mapping[str, float]) -> str:
    """Outcome or quantity that is worse in a run than in the minimal model; empty if none is."""
    if run.errors is None:
        return run.outcome
    return next((q for q in JUDGED_ERRORS if run.errors[q] > MAX_EQUAL_ERROR_RATIO * level[q]), "")


def _worsened_quantity(without: VariantResult, with_it: VariantResult, level: Mapping[str, float]) -> str:
    """First quantity whose error an ingredient enlarges above minimal's; empty if none."""
    before, after = without.errors or {}, with_it.errors or {}
    for q in JUDGED_ERRORS:
        if after[q] >= level[q] and after[q] > MAX_EQUAL_ERROR_RATIO * max(before[q], MAX_NO_CHANGE):
            return q
    return ""


def costs_time(cost: PairedTiming | None) -> bool:
    """Return True if the whole interval of a cost ratio is above MIN_COST_RATIO."""
    return cost is not None and cost.low > MIN_COST_RATIO


def ingredient_verdict(evidence: Sequence[Evidence]) -> tuple[IngredientVerdict, str]:
    """Return the verdict on an ingredient with its reason; harm outweighs all other evidence."""
    for effect, found in ((Effect.WORSE, IngredientVerdict.HARMFUL), (Effect.REQUIRED, IngredientVerdict.REQUIRED)):
        seen = [one for one in evidence if one.effect is effect]
        if seen:
            return found, _effect_words(seen[0], evidence)
    decided = [one for one in evidence if one.effect is Effect.NONE]
    if not decided:
        return IngredientVerdict.UNDECIDED, evidence[0].because if evidence else ""
    dear = [one for one in decided if costs_time(one.cost)]
    if dear:
        return IngredientVerdict.COSTLY, _effect_words(dear[0], evidence)
    if any(one.cost is not None for one in decided):
        return IngredientVerdict.FREE, ""
    return IngredientVerdict.UNDECIDED, "it could not be timed"


def _effect_words(one: Evidence, evidence: Sequence[Evidence]) -> str:
    """Reason of evidence in words, with `IN_FULL_MODEL` if only the full model shows it."""
    alone = any(not other.full for other in evidence)
    return ", ".join(text for text in (one.because, IN_FULL_MODEL if one.full and alone else "") if text)
