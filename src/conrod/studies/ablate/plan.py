"""The models that are compared: the minimal one, with each ingredient, with all, with all but one, with a part less.

What a study of the ingredients of a scene's model in one engine has to run: first each alone, then all together.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import reduce
from typing import Any

from conrod.engines import Engine
from conrod.engines.capabilities import HasIngredients, required
from conrod.engines.engine import default_steps
from conrod.engines.ingredients import Ingredient
from conrod.runs.trajectory import Outcome, Settings
from conrod.scenes import Scene
from conrod.studies.ablate.cell import ChangeCell, CostCell
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.timing import fingerprint


class Role(Enum):
    """What a variant is; the members' values are for results."""

    MINIMAL = "minimal"
    ADDED = "added"  # minimal and one ingredient more
    REDUCED = "reduced"  # minimal without one of its own parts
    DRESSED = "dressed"  # minimal and all ingredients that do it no harm, of each group the last one
    TAKEN = "taken"  # dressed without one of them, or without a part of the minimal model
    HARMED = "harmed"  # dressed and one of those that do harm
    ALL = "all"  # minimal and all ingredients, those that do harm as well


@dataclass(frozen=True)
class Variant:
    """A model.

    Attributes:
        ingredient: name of the one that it differs by from what it is compared with; empty where it is none.
        settings: that it is run with.
        against: settings of what it is compared with: the dressed model for TAKEN and HARMED, the minimal one for all
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
    """The dressed model, those that differ from it by one ingredient, and the one with all of them.

    Args:
        harmful: names of ingredients that spoil the minimal model: what others do could not be seen beside them.
    """
    extra = [one for one in ingredients if not one.minimal]
    worn = last_of_groups([one for one in extra if one.name not in harmful])
    every = last_of_groups(extra)
    if not worn:
        return ()
    dressed = with_all(minimal, worn)
    spoiling = [one for one in every if one.name in harmful]
    return (
        Variant(Role.DRESSED, "", dressed, minimal),
        *(Variant(Role.TAKEN, one.name, one.removed(dressed), dressed) for one in worn),
        *(Variant(Role.TAKEN, one.name, one.removed(dressed), dressed) for one in ingredients if one.minimal),
        *(Variant(Role.HARMED, one.name, one.added(dressed), dressed) for one in spoiling),
        *([Variant(Role.ALL, "", with_all(minimal, every), minimal)] if spoiling else []),
    )


def last_of_groups(ingredients: Sequence[Ingredient[Any]]) -> list[Ingredient[Any]]:
    """Ingredients that a model can have together: of each group the last one."""
    last = {one.group: one.name for one in ingredients if one.group}
    return [one for one in ingredients if not one.group or last[one.group] == one.name]


def with_all(minimal: Settings, ingredients: Sequence[Ingredient[Any]]) -> Settings:
    """The minimal model with some ingredients, added in their order."""
    dressed: Settings = reduce(lambda settings, one: one.added(settings), ingredients, minimal)
    return dressed


Measurements = Mapping[str, Measurement]
BESIDE_DRESSED = (Role.TAKEN, Role.HARMED)


@dataclass(frozen=True)
class AblationPlan:
    """What is to be run of a scene in an engine.

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

    def change_cell(self, variant: Variant) -> ChangeCell:
        """The run of a variant."""
        return ChangeCell(self.name, self.scene, variant.settings, against=variant.against)

    def change_cells(self) -> list[ChangeCell]:
        """Runs of all variants."""
        return [self.change_cell(variant) for variant in self.variants]

    def cost_cell(self, variant: Variant, in_full: bool = False) -> CostCell:
        """The timing of a variant over the minimal model, or over the dressed one."""
        return CostCell(
            self.name,
            self.scene,
            variant.settings,
            against=variant.against if in_full else self.minimal,
            machine=fingerprint(),
            rounds=self.rounds,
        )

    def cost_cells(self, runs: Measurements) -> list[CostCell]:
        """Timings of all variants that ran to their end. The minimal model is timed against itself: a control."""
        if not self.completed(self.variants[0], runs):
            return []
        timed = [variant for variant in self.variants if self.completed(variant, runs)]
        dressed = any(variant.role is Role.DRESSED for variant in timed)
        beside = [variant for variant in timed if dressed and variant.role in BESIDE_DRESSED]
        return [*map(self.cost_cell, timed), *(self.cost_cell(variant, in_full=True) for variant in beside)]

    def completed(self, variant: Variant, runs: Measurements) -> bool:
        """Whether a variant ran to its end."""
        return runs[self.change_cell(variant).key].outcome == Outcome.COMPLETED.slug


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
