"""A study of the ingredients of a scene's model in one engine: the runs that it needs, and what they come to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from conrod.engines import Engine
from conrod.engines.engine import default_steps
from conrod.engines.ingredient import Ingredient
from conrod.mechanism import Mechanism
from conrod.scenes import Scene
from conrod.studies.ablate.cell import ChangeCell, CostCell
from conrod.studies.ablate.results import (
    AblationStudy,
    CompiledCount,
    EngineAblation,
    Evidence,
    Gruebler,
    IngredientResult,
    VariantResult,
)
from conrod.studies.ablate.variants import Role, Variant, variants_of
from conrod.studies.ablate.verdict import JUDGED, levels, motion_effect, torque_effect, torque_verdict, verdict
from conrod.studies.cell import REVOLUTIONS
from conrod.studies.clock import fingerprint
from conrod.studies.measurement import Measurement
from conrod.studies.paired_clock import PairedTiming
from conrod.trajectory import Outcome

Measurements = Mapping[str, Measurement]


@dataclass(frozen=True)
class AblationPlan:
    """What is to be run of a scene in an engine.

    Attributes:
        name: of the scene.
        rounds: of each timing.
    """

    name: str
    scene: Scene = field(repr=False)
    engine: Engine[Any]
    ingredients: tuple[Ingredient[Any], ...]
    variants: tuple[Variant, ...]
    rounds: int

    @property
    def steps_per_revolution(self) -> int:
        """Of the minimal model."""
        return self.variants[0].settings.steps_per_revolution

    def change_cell(self, variant: Variant) -> ChangeCell:
        """The run of a variant."""
        return ChangeCell(self.name, self.scene, variant.settings, against=variant.against)

    def cells(self) -> list[ChangeCell]:
        """Runs of all variants."""
        return [self.change_cell(variant) for variant in self.variants]

    def cost_cell(self, variant: Variant, full: bool = False) -> CostCell:
        """The timing of a variant against the minimal model, or against what it was taken from."""
        against = variant.against if full else self.variants[0].settings
        made_on = fingerprint()
        return CostCell(self.name, self.scene, variant.settings, against=against, machine=made_on, rounds=self.rounds)

    def cost_cells(self, measurements: Measurements) -> list[CostCell]:
        """Timings of all variants that ran to their end. The minimal model is timed against itself: a control."""
        if not self._completed(self.variants[0], measurements):
            return []
        found = []
        for variant in self.variants:
            if self._completed(variant, measurements):
                found.append(self.cost_cell(variant))
                if variant.role is Role.TAKEN and self._dressed_completed(measurements):
                    found.append(self.cost_cell(variant, full=True))
        return found

    def _dressed_completed(self, measurements: Measurements) -> bool:
        return any(v.role is Role.DRESSED and self._completed(v, measurements) for v in self.variants)

    def _completed(self, variant: Variant, measurements: Measurements) -> bool:
        return measurements[self.change_cell(variant).key].outcome == Outcome.COMPLETED.slug


def plan_ablation(name: str, scene: Scene, engine: Engine[Any], steps: int | None, rounds: int) -> AblationPlan:
    """The plan for a scene and an engine.

    Args:
        steps: a revolution; None for the usual number.
    """
    minimal = engine.minimal(scene, steps or default_steps(scene))
    ingredients = engine.ingredients(scene, minimal)
    return AblationPlan(name, scene, engine, ingredients, variants_of(minimal, ingredients), rounds)


def ablation_study(plans: Sequence[AblationPlan], runs: Measurements, costs: Measurements) -> AblationStudy:
    """What the plans of one scene found.

    Args:
        runs, costs: key -> measurement, of all cells.
    """
    name, scene = plans[0].name, plans[0].scene
    return AblationStudy(
        name,
        type(scene).kind,
        type(scene).title,
        dict(scene.parameters),
        gruebler(scene.kinematics.mechanism),
        tuple(_of_engine(plan, runs, costs) for plan in plans),
    )


def gruebler(mechanism: Mechanism) -> Gruebler:
    """The count of a mechanism, the ground among its links."""
    higher = len(mechanism.cam_contacts)
    return Gruebler(len(mechanism.bodies) + 1, len(mechanism.joints) - higher, higher, mechanism.mobility)


def _of_engine(plan: AblationPlan, runs: Measurements, costs: Measurements) -> EngineAblation:
    found = {(v.role, v.ingredient): _result(plan, v, runs, costs) for v in plan.variants}
    return EngineAblation(
        engine=plan.engine.name,
        version=plan.engine.version,
        steps_per_revolution=plan.steps_per_revolution,
        revolutions=REVOLUTIONS,
        machine=fingerprint(),
        ingredients=tuple(_judged(ingredient, found) for ingredient in plan.ingredients),
        variants=tuple(found.values()),
    )


def _result(plan: AblationPlan, variant: Variant, runs: Measurements, costs: Measurements) -> VariantResult:
    run = runs[plan.change_cell(variant).key]
    beside = run.beside or {}
    in_full = plan.cost_cell(variant, full=True) if variant.role is Role.TAKEN else None
    return VariantResult(
        role=variant.role.value,
        ingredient=variant.ingredient,
        outcome=run.outcome,
        reason=run.reason,
        errors=None if run.errors is None else {q: run.largest(q) or 0.0 for q in JUDGED},
        change=beside.get("change"),
        torque_error=beside.get("torque"),
        torque_change=beside.get("torque_change"),
        mobility=CompiledCount.of(beside.get("mobility")),
        cost=_timing(costs, plan.cost_cell(variant)),
        cost_in_full=None if in_full is None else _timing(costs, in_full),
        settings=variant.settings.as_dict(),
    )


def _timing(costs: Measurements, cell: CostCell) -> PairedTiming | None:
    # A process that died or took too long has no cost to tell; that its run completed is known from elsewhere.
    found = costs.get(cell.key)
    return None if found is None or found.beside is None else PairedTiming.of(found.beside["paired"])


def _judged(ingredient: Ingredient[Any], found: Mapping[tuple[Role, str], VariantResult]) -> IngredientResult:
    evidence = _evidence(ingredient.name, found)
    came_to, because = verdict(evidence)
    return IngredientResult(
        name=ingredient.name,
        title=ingredient.title,
        meaning=ingredient.meaning,
        minimal=ingredient.minimal,
        group=ingredient.group,
        needed_by=tuple(quantity.value for quantity in ingredient.needed_by),
        verdict=came_to.slug,
        because=because,
        torque=torque_verdict(evidence),
        evidence=evidence,
    )


def _evidence(name: str, found: Mapping[tuple[Role, str], VariantResult]) -> tuple[Evidence, ...]:
    """Pairs of models that differ by an ingredient: its change is kept with the one that is compared."""
    minimal, dressed = found[Role.MINIMAL, ""], found.get((Role.DRESSED, ""))
    added, reduced, taken = (found.get((role, name)) for role in (Role.ADDED, Role.REDUCED, Role.TAKEN))
    level = levels(minimal)
    pairs = []
    if added is not None:
        pairs.append(_pair(minimal, added, added, added.cost, level))
    if reduced is not None:
        pairs.append(_pair(reduced, minimal, reduced, _inverse(reduced.cost), level))
    if taken is not None and dressed is not None:
        pairs.append(_pair(taken, dressed, taken, _inverse(taken.cost_in_full), level, full=True))
    return tuple(pairs)


def _pair(
    without: VariantResult,
    with_it: VariantResult,
    compared: VariantResult,
    cost: PairedTiming | None,
    level: Mapping[str, float],
    full: bool = False,
) -> Evidence:
    effect, because = motion_effect(without, with_it, level)
    torque = torque_effect(without, with_it)
    return Evidence(
        full=full,
        cost=cost,
        change=compared.change,
        effect=effect.value,
        because=because,
        torque_change=compared.torque_change,
        torque_effect="" if torque is None else torque.value,
    )


def _inverse(cost: PairedTiming | None) -> PairedTiming | None:
    return None if cost is None else cost.inverse
