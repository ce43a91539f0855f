"""Study of a model's ingredients: the models that are compared, their runs and timings, and what these come to."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

from conrod.engines import Engine
from conrod.engines.capabilities import HasIngredients, required
from conrod.engines.engine import default_steps
from conrod.engines.mobility import MobilityCount
from conrod.engines.variants import Ingredient
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.plain import restore
from conrod.runs.trajectory import Outcome, Settings
from conrod.scenes import Scene
from conrod.studies.ablate.case import ChangeCase, CostCase
from conrod.studies.ablate.findings import (
    OF_FULL,
    AblationStudy,
    Effect,
    EngineAblation,
    Gruebler,
    IngredientResult,
    Role,
    VariantResult,
)
from conrod.studies.ablate.verdict import JUDGED, Levels, evidence_of, torque_verdict, verdict
from conrod.studies.frame.case import Results, Study
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.paired_timing import PairedTiming
from conrod.studies.frame.run import as_run
from conrod.studies.frame.timing import fingerprint

Found = Mapping[tuple[Role, str], VariantResult]


def ablate_engine(
    name: str, scene: Scene, engine: Engine[Any], steps: int | None, rounds: int
) -> Study[EngineAblation]:
    """The study of a scene's ingredients in one engine: runs twice, then timings, which are to be made alone.

    Args:
        name: of the scene.
        steps: a revolution; None for the usual number.
        rounds: of each timing.

    Raises:
        InvalidInput: the engine has no ingredients.
    """
    models, cases = required(engine, HasIngredients), Cases(name, scene, rounds)
    minimal = models.minimal(scene, steps or default_steps(scene))
    ingredients = models.ingredients(scene, minimal)
    variants = single_variants(minimal, ingredients)
    runs = yield [cases.change(one) for one in variants]
    # Which ingredients a full model is to have is known when each has been seen alone.
    alone = _judged(ingredients, cases.results(variants, runs, {}))
    effects = {one.name: one.evidence[0].effect for one in alone if not one.minimal}
    # What the engine cannot do here, no model can have.
    usable = [one for one in ingredients if effects.get(one.name) is not Effect.UNDECIDED]
    variants += full_variants(minimal, usable, {name for name, effect in effects.items() if effect is Effect.WORSE})
    runs = yield [cases.change(one) for one in variants]
    # After all runs: what runs beside a timing is in it.
    costs = yield cases.costs(variants, runs)
    found = cases.results(variants, runs, costs)
    return EngineAblation(
        engine=engine.name,
        version=engine.version,
        steps_per_revolution=minimal.steps_per_revolution,
        revolutions=as_run(cases.change(variants[0])).revolutions,
        machine=fingerprint(),
        ingredients=_judged(ingredients, found),
        variants=tuple(found.values()),
    )


def ablation_study(
    name: str, scene: Scene, engines: Sequence[EngineAblation], unsupported: Mapping[str, str]
) -> AblationStudy:
    """Findings on a scene from those in its engines.

    Args:
        unsupported: engine -> why it has no ingredients to study.
    """
    count, parameters = gruebler(scene.kinematics.mechanism), dict(scene.parameters)
    found = tuple(engines), dict(unsupported), dict(scene.lengths)
    return AblationStudy(name, scene.kind, scene.title, parameters, count, *found)


def gruebler(mechanism: Mechanism) -> Gruebler:
    """Gruebler's count of a mechanism, the ground among its links."""
    higher = len(mechanism.cam_contacts)
    return Gruebler(len(mechanism.bodies) + 1, len(mechanism.joints) - higher, higher, mechanism.mobility)


# -- models ----------------------------------------------------------------------------------------------------------


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
    full: Settings = reduce(lambda settings, one: one.added(settings), chosen, minimal)
    spoilt: Settings = reduce(lambda settings, one: one.added(settings), every, minimal)
    spoiling = [one for one in every if one.name in harmful]
    removable = [*chosen, *(one for one in ingredients if one.minimal)]
    return (
        Variant(Role.FULL, "", full, minimal),
        *(Variant(Role.TAKEN, one.name, one.removed(full), full) for one in removable),
        *(Variant(Role.HARMED, one.name, one.added(full), full) for one in spoiling),
        *([Variant(Role.ALL, "", spoilt, minimal)] if spoiling else []),
    )


def last_of_groups(ingredients: Sequence[Ingredient[Any]]) -> list[Ingredient[Any]]:
    """Ingredients that a model can have together: of each group the last one."""
    last = {one.group: one.name for one in ingredients if one.group}
    return [one for one in ingredients if not one.group or last[one.group] == one.name]


@dataclass(frozen=True)
class Cases:
    """Runs and timings of the models of a scene, and what they come to.

    Attributes:
        name: of the scene.
        rounds: of each timing.
    """

    name: str
    scene: Scene
    rounds: int

    def change(self, variant: Variant) -> ChangeCase:
        """The run of a model."""
        return ChangeCase(self.name, self.scene, variant.settings, against=variant.against)

    def cost(self, variant: Variant, against: Settings) -> CostCase:
        """The timing of a model over another one."""
        return CostCase(
            self.name, self.scene, variant.settings, against=against, machine=fingerprint(), rounds=self.rounds
        )

    def costs(self, variants: Sequence[Variant], runs: Results) -> list[CostCase]:
        """Timings of all models that ran to their end. The minimal model is timed against itself: a control."""
        minimal = variants[0]
        ended = [one for one in variants if runs[self.change(one).key].outcome == Outcome.COMPLETED.slug]
        roles = {one.role for one in ended}
        if Role.MINIMAL not in roles:
            return []
        of_full = [one for one in ended if Role.FULL in roles and one.role in OF_FULL]
        over_minimal = [self.cost(one, minimal.settings) for one in ended]
        return over_minimal + [self.cost(one, one.against) for one in of_full]

    def results(self, variants: Sequence[Variant], runs: Results, costs: Results) -> Found:
        """What was measured of each model."""
        return {(one.role, one.ingredient): self._result(one, variants[0], runs, costs) for one in variants}

    def _result(self, variant: Variant, minimal: Variant, runs: Results, costs: Results) -> VariantResult:
        run = runs[self.change(variant).key]
        beside = run.beside or {}
        of_full = variant.role in OF_FULL
        return VariantResult(
            role=variant.role,
            ingredient=variant.ingredient,
            outcome=run.outcome,
            reason=run.reason,
            errors=None if run.errors is None else {q: run.largest(q) or 0.0 for q in JUDGED},
            change=beside.get("change"),
            torque_error=beside.get("torque"),
            torque_change=beside.get("torque_change"),
            mobility=restore(MobilityCount, beside["mobility"]) if beside.get("mobility") else None,
            cost=_timing(costs.get(self.cost(variant, minimal.settings).key)),
            cost_in_full=_timing(costs.get(self.cost(variant, variant.against).key)) if of_full else None,
            settings=variant.settings.as_dict(),
        )


def _timing(cost: Measurement | None) -> PairedTiming | None:
    # A process that died or took too long has no cost; that its run completed is known from elsewhere.
    return None if cost is None or cost.beside is None else restore(PairedTiming, cost.beside["paired"])


def _judged(ingredients: Sequence[Ingredient[Any]], found: Found) -> tuple[IngredientResult, ...]:
    """What follows for each ingredient from the models that differ by it alone from those they are made from."""
    level, judged = Levels.of(found.values()), list[IngredientResult]()
    for one in ingredients:
        evidence = tuple(
            evidence_of(found[role, one.name], found[Role.FULL if role in OF_FULL else Role.MINIMAL, ""], level)
            for role in (Role.ADDED, Role.REDUCED, *OF_FULL)
            if (role, one.name) in found
        )
        judgement, because = verdict(evidence)
        judged.append(
            IngredientResult(
                name=one.name,
                title=one.title,
                meaning=one.meaning,
                minimal=one.minimal,
                group=one.group,
                needed_by=tuple(quantity.value for quantity in one.needed_by),
                verdict=judgement,
                because=because,
                torque=torque_verdict(evidence),
                evidence=evidence,
            )
        )
    return tuple(judged)
