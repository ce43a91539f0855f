"""What a study of the ingredients of a scene's model in one engine has to run: first each alone, then all together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from conrod.engines import Engine
from conrod.engines.engine import default_steps
from conrod.engines.ingredient import Ingredient
from conrod.scenes import Scene
from conrod.studies.ablate.cell import ChangeCell, CostCell
from conrod.studies.ablate.variants import Role, Variant, single_variants
from conrod.studies.clock import fingerprint
from conrod.studies.measurement import Measurement
from conrod.trajectory import Outcome, Settings

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
    """
    minimal = engine.minimal(scene, steps or default_steps(scene))
    ingredients = engine.ingredients(scene, minimal)
    return AblationPlan(name, scene, engine, ingredients, single_variants(minimal, ingredients), rounds)
