"""Findings of a study of ingredients, plain values that report and command line read, and the verdicts on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from conrod.runs.trajectory import Outcome
from conrod.studies.frame.paired_timing import PairedTiming


class Role(Enum):
    """Place of a model in the study."""

    MINIMAL = "minimal"
    ADDED = "added"  # minimal and one ingredient more
    REDUCED = "reduced"  # minimal without one of its own parts
    FULL = "full"  # minimal and all ingredients that do it no harm
    TAKEN = "taken"  # full without one of them, or without a part that the minimal model can do without


class Effect(Enum):
    """Effect of an ingredient on the observed motion."""

    NONE = "none"
    REQUIRED = "required"
    WORSE = "worse"
    UNDECIDED = "undecided"


class Verdict(Enum):
    """Verdict of measurement on an ingredient."""

    REQUIRED = "required"
    FREE = "free"
    COSTLY = "costly"
    HARMFUL = "harmful"
    UNDECIDED = "undecided"


MEANINGS = {
    Verdict.REQUIRED: "without it the observed motion is wrong",
    Verdict.FREE: "the motion is right with it and without it, and it costs nothing",
    Verdict.COSTLY: "the motion is right with it and without it, and it costs time",
    Verdict.HARMFUL: "makes the motion worse",
    Verdict.UNDECIDED: "no measurement decides",
}


@dataclass(frozen=True)
class VariantResult:
    """A model of a study.

    Attributes:
        ingredient: that it differs by from what it is compared with; empty where it is none.
        errors: largest of the observed points against the exact motion: position, velocity, acceleration, total;
            None unless the run completed.
        change: largest difference of the observed points from what it is compared with, at the same instants:
            position, velocity, acceleration, normalised as errors are; None unless both completed.
        cost: over the minimal model; None where the run did not complete or could not be timed.
        cost_in_full: of a variant with one ingredient taken from the full model: over that model.
        settings: as plain values.
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
    """Two models that differ by an ingredient alone.

    Attributes:
        full: whether all other ingredients are there, or none.
        cost: with it over without it.
        change: of the observed motion.
        because: what the effect was seen in: a quantity, or how the run ended that did not complete.
    """

    full: bool
    cost: PairedTiming | None
    change: Mapping[str, float] | None
    effect: Effect
    because: str


@dataclass(frozen=True)
class IngredientResult:
    """An ingredient, the evidence on it and what follows.

    Attributes:
        name, meaning, minimal: see `engines.variants.Ingredient`.
        needed_by: quantities that need it by what it is.
        because: what the verdict was seen in.
    """

    name: str
    meaning: str
    minimal: bool
    needed_by: tuple[str, ...]
    verdict: Verdict
    because: str
    evidence: tuple[Evidence, ...]


@dataclass(frozen=True)
class EngineAblation:
    """Findings in one engine.

    Attributes:
        machine: that the costs were taken on.
        ingredients: in the engine's own order.
        variants: the minimal model first.
        distrust: scenes and engines whose figures cannot be trusted, and why, in words; empty if there are none.
    """

    engine: str
    version: str
    steps_per_revolution: int
    revolutions: float
    machine: str
    ingredients: tuple[IngredientResult, ...]
    variants: tuple[VariantResult, ...]
    distrust: str = ""

    def variant(self, role: Role, ingredient: str = "") -> VariantResult | None:
        """The variant of a role; None where there is none."""
        return next((v for v in self.variants if (v.role, v.ingredient) == (role, ingredient)), None)


@dataclass(frozen=True)
class AblationStudy:
    """Findings on a scene.

    Attributes:
        name, kind, title, parameters: of the scene.
        unsupported: engine -> why it has no ingredients to study.
        lengths: L of each observed point [m]; empty in reports of an earlier conrod.
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
        """Engines whose figures cannot be trusted, and why, in words; empty if there are none."""
        return "; ".join(found.distrust for found in self.engines if found.distrust)


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
