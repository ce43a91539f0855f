"""What the runs and timings of a study of ingredients come to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from conrod.engines.ingredients import Ingredient
from conrod.mechanism.mechanism import Mechanism
from conrod.studies.ablate.cell import CostCell
from conrod.studies.ablate.plan import BESIDE_DRESSED, AblationPlan, Measurements, Role, Variant, full_variants
from conrod.studies.ablate.results import (
    AblationStudy,
    CompiledCount,
    EngineAblation,
    Evidence,
    Gruebler,
    IngredientResult,
    VariantResult,
)
from conrod.studies.ablate.verdict import JUDGED, Effect, Levels, evidence_of, torque_verdict, verdict
from conrod.studies.frame.paired_timing import PairedTiming
from conrod.studies.frame.run import as_run
from conrod.studies.frame.timing import fingerprint

Found = Mapping[tuple[Role, str], VariantResult]


def completed_plan(plan: AblationPlan, runs: Measurements) -> AblationPlan:
    """The whole plan, when the minimal model and those that differ from it by one ingredient have been run.

    Args:
        runs: key -> measurement, of all cells of the plan.
    """
    found = _found(plan, runs, {})
    level = Levels.of(found.values())
    minimal = found[Role.MINIMAL, ""]
    effects = {
        name: evidence_of(minimal, one, one, one.cost, level).effect
        for (role, name), one in found.items()
        if role is Role.ADDED
    }
    # What the engine cannot do here, no model can have.
    usable = [one for one in plan.ingredients if effects.get(one.name) != Effect.UNTOLD.value]
    harmful = {name for name, effect in effects.items() if effect == Effect.WORSE.value}
    return plan.with_variants(full_variants(plan.minimal, usable, harmful))


def ablation_study(plans: Sequence[AblationPlan], runs: Measurements, costs: Measurements) -> AblationStudy:
    """What the plans of one scene found.

    Args:
        runs, costs: key -> measurement, of all cells.
    """
    name, scene = plans[0].name, plans[0].scene
    return AblationStudy(
        name,
        scene.kind,
        scene.title,
        dict(scene.parameters),
        gruebler(scene.kinematics.mechanism),
        tuple(_of_engine(plan, runs, costs) for plan in plans),
    )


def gruebler(mechanism: Mechanism) -> Gruebler:
    """The count of a mechanism, the ground among its links."""
    higher = len(mechanism.cam_contacts)
    return Gruebler(len(mechanism.bodies) + 1, len(mechanism.joints) - higher, higher, mechanism.mobility)


def _of_engine(plan: AblationPlan, runs: Measurements, costs: Measurements) -> EngineAblation:
    found = _found(plan, runs, costs)
    level = Levels.of(found.values())
    return EngineAblation(
        engine=plan.engine.name,
        version=plan.engine.version,
        steps_per_revolution=plan.minimal.steps_per_revolution,
        revolutions=as_run(plan.change_cell(plan.variants[0])).revolutions,
        machine=fingerprint(),
        ingredients=tuple(_judged(ingredient, found, level) for ingredient in plan.ingredients),
        variants=tuple(found.values()),
    )


# -- models ----------------------------------------------------------------------------------------------------------


def _found(plan: AblationPlan, runs: Measurements, costs: Measurements) -> Found:
    return {(v.role, v.ingredient): _result(plan, v, runs, costs) for v in plan.variants}


def _result(plan: AblationPlan, variant: Variant, runs: Measurements, costs: Measurements) -> VariantResult:
    run = runs[plan.change_cell(variant).key]
    beside = run.beside or {}
    in_full = plan.cost_cell(variant, in_full=True) if variant.role in BESIDE_DRESSED else None
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


# -- ingredients -----------------------------------------------------------------------------------------------------


def _judged(ingredient: Ingredient[Any], found: Found, level: Levels) -> IngredientResult:
    evidence = _evidence(ingredient.name, found, level)
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


def _evidence(name: str, found: Found, level: Levels) -> tuple[Evidence, ...]:
    """Pairs of models that differ by an ingredient: its change is kept with the one that is compared."""
    minimal, dressed = found[Role.MINIMAL, ""], found.get((Role.DRESSED, ""))
    pairs = []
    if (added := found.get((Role.ADDED, name))) is not None:
        pairs.append(evidence_of(minimal, added, added, added.cost, level))
    if (reduced := found.get((Role.REDUCED, name))) is not None:
        pairs.append(evidence_of(reduced, minimal, reduced, _inverse(reduced.cost), level))
    if dressed is not None:
        if (taken := found.get((Role.TAKEN, name))) is not None:
            pairs.append(evidence_of(taken, dressed, taken, _inverse(taken.cost_in_full), level, full=True))
        if (harmed := found.get((Role.HARMED, name))) is not None:
            pairs.append(evidence_of(dressed, harmed, harmed, harmed.cost_in_full, level, full=True))
    return tuple(pairs)


def _inverse(cost: PairedTiming | None) -> PairedTiming | None:
    return None if cost is None else cost.inverse
