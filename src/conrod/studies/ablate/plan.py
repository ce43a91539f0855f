"""Models that a study of ingredients compares: the minimal one, with each ingredient, with all, with all but one."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any

from conrod.engines import Engine
from conrod.engines.capabilities import HasIngredients, required
from conrod.engines.engine import default_steps
from conrod.engines.ingredients import Ingredient
from conrod.runs.trajectory import Outcome, Settings
from conrod.scenes import Scene
from conrod.studies.ablate.case import ChangeCase, CostCase
from conrod.studies.ablate.findings import Role
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.timing import fingerprint

Measurements = Mapping[str, Measurement]
OF_FULL = (Role.TAKEN, Role.HARMED)


@dataclass(frozen=True)
class Variant:
    """A model.

    Attributes:
        ingredient: name of the one that it differs by from what it is compared with; empty where it is none.
        settings: that it is run with.
        against: settings of what it is compared with: the full model for TAKEN and HARMED, the minimal one for all
            others.
    """

    role: Role
    ingredient: str
    settings: Settings
    against: Settings


def single_variants(minimal: Settings, ingredients: Sequence[Ingredient[Any]]) -> tuple[Variant, ...]:
    """The minimal model, and those that differ from it by one ingredient."""
    return (
        Variant(Role.MINIMAL, "", minimal, minimal),
        *(Variant(Role.ADDED, one.name, one.added(minimal), minimal) for one in ingredients if not one.minimal),
        *(Variant(Role.REDUCED, one.name, one.removed(minimal), minimal) for one in ingredients if one.minimal),
    )


def full_variants(
    minimal: Settings, ingredients: Sequence[Ingredient[Any]], harmful: Collection[str]
) -> tuple[Variant, ...]:
    """The full model, those that differ from it by one ingredient, and the one with all of them.

    Args:
        harmful: names of ingredients that spoil the minimal model: what others do could not be seen beside them.
    """
    extra = [one for one in ingredients if not one.minimal]
    chosen = last_of_groups([one for one in extra if one.name not in harmful])
    every = last_of_groups(extra)
    if not chosen:
        return ()
    full = with_all(minimal, chosen)
    spoiling = [one for one in every if one.name in harmful]
    removable = [*chosen, *(one for one in ingredients if one.minimal)]
    return (
        Variant(Role.FULL, "", full, minimal),
        *(Variant(Role.TAKEN, one.name, one.removed(full), full) for one in removable),
        *(Variant(Role.HARMED, one.name, one.added(full), full) for one in spoiling),
        *([Variant(Role.ALL, "", with_all(minimal, every), minimal)] if spoiling else []),
    )


def last_of_groups(ingredients: Sequence[Ingredient[Any]]) -> list[Ingredient[Any]]:
    """Ingredients that a model can have together: of each group the last one."""
    last = {one.group: one.name for one in ingredients if one.group}
    return [one for one in ingredients if not one.group or last[one.group] == one.name]


def with_all(minimal: Settings, ingredients: Sequence[Ingredient[Any]]) -> Settings:
    """The minimal model with some ingredients, added in their order."""
    full: Settings = reduce(lambda settings, one: one.added(settings), ingredients, minimal)
    return full


@dataclass(frozen=True)
class AblationPlan:
    """Models of a scene in an engine, and the cases that compare them.

    Attributes:
        name: of the scene.
        variants: the minimal model first.
        rounds: of each timing.
    """

    name: str
    scene: Scene = field(repr=False)
    engine: Engine[Any]
    ingredients: tuple[Ingredient[Any], ...]
    variants: tuple[Variant, ...]
    rounds: int

    @property
    def minimal(self) -> Settings:
        """The minimal model."""
        return self.variants[0].settings

    def with_variants(self, more: tuple[Variant, ...]) -> AblationPlan:
        """The plan with more models."""
        return replace(self, variants=(*self.variants, *more))

    def change_case(self, variant: Variant) -> ChangeCase:
        """The run of a variant."""
        return ChangeCase(self.name, self.scene, variant.settings, against=variant.against)

    def change_cases(self) -> list[ChangeCase]:
        """Runs of all variants."""
        return [self.change_case(variant) for variant in self.variants]

    def cost_case(self, variant: Variant, in_full: bool = False) -> CostCase:
        """The timing of a variant over the minimal model, or over the full one."""
        against = variant.against if in_full else self.minimal
        return CostCase(
            self.name, self.scene, variant.settings, against=against, machine=fingerprint(), rounds=self.rounds
        )

    def cost_cases(self, runs: Measurements) -> list[CostCase]:
        """Timings of all variants that ran to their end. The minimal model is timed against itself: a control."""
        if not self.completed(self.variants[0], runs):
            return []
        timed = [variant for variant in self.variants if self.completed(variant, runs)]
        has_full = any(variant.role is Role.FULL for variant in timed)
        of_full = [variant for variant in timed if has_full and variant.role in OF_FULL]
        return [*map(self.cost_case, timed), *(self.cost_case(variant, in_full=True) for variant in of_full)]

    def completed(self, variant: Variant, runs: Measurements) -> bool:
        """True if a variant ran to its end."""
        return runs[self.change_case(variant).key].outcome == Outcome.COMPLETED.slug


def plan_ablation(name: str, scene: Scene, engine: Engine[Any], steps: int | None, rounds: int) -> AblationPlan:
    """The first part of a plan: the minimal model, and those that differ from it by one ingredient.

    Args:
        steps: a revolution; None for the usual number.

    Raises:
        InvalidInput: the engine has no ingredients.
    """
    models = required(engine, HasIngredients)
    minimal = models.minimal(scene, steps or default_steps(scene))
    ingredients = models.ingredients(scene, minimal)
    return AblationPlan(name, scene, engine, ingredients, single_variants(minimal, ingredients), rounds)
