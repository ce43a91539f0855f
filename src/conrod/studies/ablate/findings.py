"""Findings of a study of ingredients: plain values that the report and the command line read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

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
    """

    engine: str
    version: str
    steps_per_revolution: int
    revolutions: float
    machine: str
    ingredients: tuple[IngredientResult, ...]
    variants: tuple[VariantResult, ...]

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
