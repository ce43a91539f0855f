"""Findings of a study of ingredients: plain values that the report and the command line read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from conrod.engines.mobility import MobilityCount
from conrod.studies.frame.paired_timing import PairedTiming


class Role(Enum):
    """Place of a model in the study."""

    MINIMAL = "minimal"
    ADDED = "added"  # minimal and one ingredient more
    REDUCED = "reduced"  # minimal without one of its own parts
    FULL = "full"  # minimal and all ingredients that do it no harm, of each group the last one
    TAKEN = "taken"  # full without one of them, or without a part of the minimal model
    HARMED = "harmed"  # full and one of those that do harm
    ALL = "all"  # minimal and all ingredients, those that do harm as well


# Made from the full model; all others are made from the minimal one.
OF_FULL = (Role.TAKEN, Role.HARMED)


class Effect(Enum):
    """Effect of an ingredient on a quantity."""

    NONE = "none"
    REQUIRED = "required"
    WORSE = "worse"
    CHANGED = "changed"  # between two models neither of which has it right
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
        torque_error: of the drive over the exact peak; None where the engine does not report it.
        torque_change: largest difference of it, likewise.
        mobility: None where it was not counted.
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
    torque_error: float | None
    torque_change: float | None
    mobility: MobilityCount | None
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
        effect: on the motion.
        because: what the effect was seen in: a quantity, or how the run ended that did not complete.
        torque_effect: on the drive torque; None where the engine does not report it.
    """

    full: bool
    cost: PairedTiming | None
    change: Mapping[str, float] | None
    effect: Effect
    because: str
    torque_change: float | None
    torque_effect: Effect | None


@dataclass(frozen=True)
class IngredientResult:
    """An ingredient, the evidence on it and what follows.

    Attributes:
        name, title, meaning, minimal, group: see `engines.capabilities.Ingredient`.
        needed_by: quantities that need it by what it is.
        because: what the verdict was seen in.
        torque: effect on the drive torque, empty where it is not reported, or not touched.
    """

    name: str
    title: str
    meaning: str
    minimal: bool
    group: str
    needed_by: tuple[str, ...]
    verdict: Verdict
    because: str
    torque: str
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
class Gruebler:
    """Gruebler's count of a mechanism: mobility = 3 (links - 1) - 2 lower pairs - higher pairs."""

    links: int
    lower_pairs: int
    higher_pairs: int
    mobility: int


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
    gruebler: Gruebler
    engines: tuple[EngineAblation, ...]
    unsupported: Mapping[str, str]
    lengths: Mapping[str, float] = field(default_factory=dict)
