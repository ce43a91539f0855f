"""Study of a model's ingredients: the runs of its variants, their timings, and what these come to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from conrod.engines.ingredients import Ingredient
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.plain import restore
from conrod.scenes import Scene
from conrod.studies.ablate.case import CostCase
from conrod.studies.ablate.findings import (
    AblationStudy,
    CompiledCount,
    Effect,
    EngineAblation,
    Evidence,
    Gruebler,
    IngredientResult,
    Role,
    VariantResult,
)
from conrod.studies.ablate.plan import OF_FULL, AblationPlan, Measurements, Variant, full_variants
from conrod.studies.ablate.verdict import JUDGED, Levels, evidence_of, torque_verdict, verdict
from conrod.studies.frame.paired_timing import PairedTiming
from conrod.studies.frame.run import as_run
from conrod.studies.frame.study import Study
from conrod.studies.frame.timing import fingerprint

Found = Mapping[tuple[Role, str], VariantResult]


def ablate_engine(plan: AblationPlan) -> Study[EngineAblation]:
    """The study of a scene's ingredients in one engine: runs twice, then timings, which are to be made alone."""
    # Which ingredients a full model is to have is known when each has been seen alone.
    first = yield plan.change_cases()
    whole = completed_plan(plan, first)
    runs = yield whole.change_cases()
    # After all runs: what runs beside a timing is in it.
    costs = yield whole.cost_cases(runs)
    return engine_findings(whole, runs, costs)


def completed_plan(plan: AblationPlan, runs: Measurements) -> AblationPlan:
    """The whole plan, when the minimal model and those that differ from it by one ingredient have been run.

    Args:
        runs: key -> measurement, of all cases of the plan.
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
    usable = [one for one in plan.ingredients if effects.get(one.name) is not Effect.UNDECIDED]
    harmful = {name for name, effect in effects.items() if effect is Effect.WORSE}
    return plan.with_variants(full_variants(plan.minimal, usable, harmful))


def ablation_study(
    name: str, scene: Scene, engines: Sequence[EngineAblation], unsupported: Mapping[str, str]
) -> AblationStudy:
    """Findings on a scene from those in its engines.

    Args:
        unsupported: engine -> why it has no ingredients to study.
    """
    count = gruebler(scene.kinematics.mechanism)
    parameters = dict(scene.parameters)
    return AblationStudy(name, scene.kind, scene.title, parameters, count, tuple(engines), dict(unsupported))


def gruebler(mechanism: Mechanism) -> Gruebler:
    """Gruebler's count of a mechanism, the ground among its links."""
    higher = len(mechanism.cam_contacts)
    return Gruebler(len(mechanism.bodies) + 1, len(mechanism.joints) - higher, higher, mechanism.mobility)


def engine_findings(plan: AblationPlan, runs: Measurements, costs: Measurements) -> EngineAblation:
    """Findings in one engine.

    Args:
        runs, costs: key -> measurement, of all cases of the whole plan.
    """
    found = _found(plan, runs, costs)
    level = Levels.of(found.values())
    return EngineAblation(
        engine=plan.engine.name,
        version=plan.engine.version,
        steps_per_revolution=plan.minimal.steps_per_revolution,
        revolutions=as_run(plan.change_case(plan.variants[0])).revolutions,
        machine=fingerprint(),
        ingredients=tuple(_judged(ingredient, found, level) for ingredient in plan.ingredients),
        variants=tuple(found.values()),
    )


# -- models ----------------------------------------------------------------------------------------------------------


def _found(plan: AblationPlan, runs: Measurements, costs: Measurements) -> Found:
    return {(v.role, v.ingredient): _result(plan, v, runs, costs) for v in plan.variants}


def _result(plan: AblationPlan, variant: Variant, runs: Measurements, costs: Measurements) -> VariantResult:
    run = runs[plan.change_case(variant).key]
    beside = run.beside or {}
    in_full = plan.cost_case(variant, in_full=True) if variant.role in OF_FULL else None
    return VariantResult(
        role=variant.role,
        ingredient=variant.ingredient,
        outcome=run.outcome,
        reason=run.reason,
        errors=None if run.errors is None else {q: run.largest(q) or 0.0 for q in JUDGED},
        change=beside.get("change"),
        torque_error=beside.get("torque"),
        torque_change=beside.get("torque_change"),
        mobility=restore(CompiledCount, beside["mobility"]) if beside.get("mobility") else None,
        cost=_timing(costs, plan.cost_case(variant)),
        cost_in_full=None if in_full is None else _timing(costs, in_full),
        settings=variant.settings.as_dict(),
    )


def _timing(costs: Measurements, case: CostCase) -> PairedTiming | None:
    # A process that died or took too long has no cost; that its run completed is known from elsewhere.
    found = costs.get(case.key)
    return None if found is None or found.beside is None else restore(PairedTiming, found.beside["paired"])


# -- ingredients -----------------------------------------------------------------------------------------------------


def _judged(ingredient: Ingredient[Any], found: Found, level: Levels) -> IngredientResult:
    evidence = _evidence(ingredient.name, found, level)
    judgement, because = verdict(evidence)
    return IngredientResult(
        name=ingredient.name,
        title=ingredient.title,
        meaning=ingredient.meaning,
        minimal=ingredient.minimal,
        group=ingredient.group,
        needed_by=tuple(quantity.value for quantity in ingredient.needed_by),
        verdict=judgement,
        because=because,
        torque=torque_verdict(evidence),
        evidence=evidence,
    )


def _evidence(name: str, found: Found, level: Levels) -> tuple[Evidence, ...]:
    """Pairs of models that differ by an ingredient: its change is kept with the one that is compared."""
    minimal, full = found[Role.MINIMAL, ""], found.get((Role.FULL, ""))
    pairs = []
    if (added := found.get((Role.ADDED, name))) is not None:
        pairs.append(evidence_of(minimal, added, added, added.cost, level))
    if (reduced := found.get((Role.REDUCED, name))) is not None:
        pairs.append(evidence_of(reduced, minimal, reduced, _inverse(reduced.cost), level))
    if full is not None:
        if (taken := found.get((Role.TAKEN, name))) is not None:
            pairs.append(evidence_of(taken, full, taken, _inverse(taken.cost_in_full), level, full=True))
        if (harmed := found.get((Role.HARMED, name))) is not None:
            pairs.append(evidence_of(full, harmed, harmed, harmed.cost_in_full, level, full=True))
    return tuple(pairs)


def _inverse(cost: PairedTiming | None) -> PairedTiming | None:
    return None if cost is None else cost.inverse
