"""What a study of ingredients finds; plain values that the report and the command line read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Any

from conrod.studies.frame.paired_timing import PairedTiming


class Verdict(Enum):
    """What measurement says of an ingredient: the value is for results, the meaning for people."""

    REQUIRED = ("required", "without it the observed motion is wrong")
    FREE = ("free", "the motion is right with it and without it, and it costs nothing")
    COSTLY = ("costly", "the motion is right with it and without it, and it costs time")
    HARMFUL = ("harmful", "makes the motion worse")
    UNTOLD = ("not told", "nothing was measured that tells")

    def __init__(self, slug: str, meaning: str) -> None:
        self.slug = slug
        self.meaning = meaning


@dataclass(frozen=True)
class CompiledCount:
    """Degrees of freedom and constraints of a compiled model along its motion, see `engines.mobility_count`.

    Attributes:
        empty: rows that no coordinate enters.
        redundant: constraint -> rows of it that say what others say already.
    """

    coordinates: int
    rows: int
    least_rank: int
    most_rank: int
    empty: tuple[str, ...]
    redundant: Mapping[str, int]

    @property
    def freedom(self) -> int:
        """Degrees of freedom that are left, singular poses apart."""
        return self.coordinates - self.most_rank

    @property
    def missing(self) -> int:
        """Constraints that a machine with one driven crank lacks."""
        return max(self.freedom - 1, 0)

    @classmethod
    def of(cls, values: Mapping[str, Any] | None) -> CompiledCount | None:
        """The inverse of `asdict`; None of None."""
        return None if values is None else cls(**{**values, "empty": tuple(values["empty"])})


@dataclass(frozen=True)
class VariantResult:
    """A model of a study.

    Attributes:
        role: see `variants.Role`.
        ingredient: that it differs by from what it is compared with; empty where it is none.
        errors: largest of the observed points against the exact motion: position, velocity, acceleration, total;
            None unless the run completed.
        change: largest difference of the observed points from what it is compared with, at the same instants:
            position, velocity, acceleration, normalised as errors are; None unless both completed.
        torque_error: of the drive over the exact peak; None where it is not told.
        torque_change: largest difference of it, likewise.
        mobility: None where it was not counted.
        cost: over the minimal model; None where the run did not complete or could not be timed.
        cost_in_full: of a variant with one ingredient taken from the dressed model: over that model.
        settings: as plain values.
    """

    role: str
    ingredient: str
    outcome: str
    reason: str
    errors: Mapping[str, float] | None
    change: Mapping[str, float] | None
    torque_error: float | None
    torque_change: float | None
    mobility: CompiledCount | None
    cost: PairedTiming | None
    cost_in_full: PairedTiming | None
    settings: Mapping[str, Any]

    @property
    def completed(self) -> bool:
        """Whether it has errors."""
        return self.errors is not None

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> VariantResult:
        """The inverse of `asdict`."""
        costs = {name: PairedTiming.of(values[name]) for name in ("cost", "cost_in_full")}
        return cls(**{**values, **costs, "mobility": CompiledCount.of(values["mobility"])})


@dataclass(frozen=True)
class Evidence:
    """Two models that differ by an ingredient alone.

    Attributes:
        full: whether all other ingredients are there, or none.
        cost: with it over without it.
        change: of the observed motion.
        effect: of it on the motion, one of `verdict.Effect`; and on the drive torque, empty where that is not told.
        because: what the effect was seen in: a quantity, or how the run ended that did not complete.
    """

    full: bool
    cost: PairedTiming | None
    change: Mapping[str, float] | None
    effect: str
    because: str
    torque_change: float | None
    torque_effect: str

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Evidence:
        """The inverse of `asdict`."""
        return cls(**{**values, "cost": PairedTiming.of(values["cost"])})


@dataclass(frozen=True)
class IngredientResult:
    """An ingredient, what was seen of it and what follows.

    Attributes:
        name, title, meaning, minimal, group: see `engines.ingredient.Ingredient`.
        needed_by: quantities that need it by what it is.
        verdict, torque: slugs of `Verdict`; torque is empty where the drive torque is not told, or not touched.
        because: what the verdict was seen in.
    """

    name: str
    title: str
    meaning: str
    minimal: bool
    group: str
    needed_by: tuple[str, ...]
    verdict: str
    because: str
    torque: str
    evidence: tuple[Evidence, ...]

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> IngredientResult:
        """The inverse of `asdict`."""
        evidence = tuple(Evidence.of(one) for one in values["evidence"])
        return cls(**{**values, "needed_by": tuple(values["needed_by"]), "evidence": evidence})


@dataclass(frozen=True)
class EngineAblation:
    """What was found in one engine.

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

    def variant(self, role: str, ingredient: str = "") -> VariantResult | None:
        """The variant of a role; None where there is none."""
        return next((v for v in self.variants if (v.role, v.ingredient) == (role, ingredient)), None)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> EngineAblation:
        """The inverse of `asdict`."""
        ingredients = tuple(IngredientResult.of(one) for one in values["ingredients"])
        variants = tuple(VariantResult.of(one) for one in values["variants"])
        return cls(**{**values, "ingredients": ingredients, "variants": variants})


@dataclass(frozen=True)
class Gruebler:
    """Gruebler's count of a mechanism: mobility = 3 (links - 1) - 2 lower pairs - higher pairs."""

    links: int
    lower_pairs: int
    higher_pairs: int
    mobility: int


@dataclass(frozen=True)
class AblationStudy:
    """What was found on a scene.

    Attributes:
        name, kind, title, parameters: of the scene.
    """

    name: str
    kind: str
    title: str
    parameters: Mapping[str, float]
    gruebler: Gruebler
    engines: tuple[EngineAblation, ...]

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> AblationStudy:
        """The inverse of `as_dict`."""
        engines = tuple(EngineAblation.of(one) for one in values["engines"])
        return cls(**{**values, "gruebler": Gruebler(**values["gruebler"]), "engines": engines})
