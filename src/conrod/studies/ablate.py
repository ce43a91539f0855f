"""Study of a model's ingredients: the models that are compared, their runs and timings, and what these come to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import Any

import numpy as np

from conrod.engines import Engine, engine_named
from conrod.engines.capabilities import ModelIngredients, require_capability
from conrod.engines.engine import default_steps
from conrod.engines.variants import Ingredient
from conrod.runs.plain_values import plain_values, restore
from conrod.runs.trajectory import Outcome, Settings
from conrod.scenes import Scene
from conrod.studies.ablate_findings import (
    JUDGED,
    AblationStudy,
    Effect,
    EngineAblation,
    IngredientResult,
    Role,
    VariantResult,
    evidence_of,
    levels,
    verdict,
)
from conrod.studies.frame.case import QUANTITIES, Measurement, Results, Study
from conrod.studies.frame.paired_timing import ROUNDS, PairedTiming, time_settings_pair
from conrod.studies.frame.reference_guard import ReferenceGuard
from conrod.studies.frame.run import RunCase, clamp_to_span
from conrod.studies.frame.timing import machine_fingerprint

COST_VERSION = 1  # raised when what is kept of the same timing means something else than before


@dataclass(frozen=True)
class CostCase(RunCase):
    """The cost of a revolution over that with other settings; see `conrod.studies.frame.paired_timing`.

    Attributes:
        against: the other settings.
        machine: fingerprint of the machine that it is timed on: figures of different machines do not mix.
        rounds: how often both are timed.
    """

    signed_angles: int = 0
    against: Settings = field(kw_only=True)
    machine: str = field(kw_only=True)
    rounds: int = field(kw_only=True, default=ROUNDS)

    def perform(self) -> Measurement:
        timing = time_settings_pair(
            engine_named(self.settings.engine), self.scene, self.settings, self.against, rounds=self.rounds
        )
        return Measurement(Outcome.COMPLETED.slug, payload={"paired": plain_values(timing)})

    def _check_readable(self, measurement: Measurement) -> None:
        if measurement.payload is not None:
            restore(PairedTiming, measurement.payload["paired"])

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        against = {key: value for key, value in self.against.as_dict().items() if key != "preset"}
        paired = {"cost": COST_VERSION, "machine": self.machine, "rounds": self.rounds}
        return super()._identity(parameters) | {"against": against} | paired


Found = Mapping[tuple[Role, str], VariantResult]
COMPARED = 100  # instants of the last turn, or of the one pass, at which two motions are compared


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
    models, cases = require_capability(engine, ModelIngredients), Cases(name, scene, rounds)
    minimal = models.minimal_settings(scene, steps or default_steps(scene))
    ingredients = models.ingredients(scene, minimal)
    variants = single_variants(minimal, ingredients)
    guard = ReferenceGuard()
    runs = yield [cases.run(one.settings) for one in variants]
    # Which ingredients a full model is to have is known when each has been seen alone.
    alone = _judged(ingredients, cases.results(variants, runs, {}))
    effects = {one.name: one.evidence[0].effect for one in alone}
    variants += full_variants(minimal, [one for one in ingredients if effects[one.name] is Effect.NONE])
    runs = yield [cases.run(one.settings) for one in variants]
    guard.check([cases.run(one.settings) for one in variants], runs)
    # After all runs: what runs beside a timing is in it.
    costs = yield cases.costs(variants, runs)
    found = cases.results(variants, runs, costs)
    return EngineAblation(
        engine=engine.name,
        version=engine.version,
        steps_per_revolution=minimal.steps_per_revolution,
        revolutions=clamp_to_span(cases.run(minimal)).revolutions,
        machine=machine_fingerprint(),
        ingredients=_judged(ingredients, found),
        variants=tuple(found.values()),
        distrust=guard.distrust,
    )


def ablation_study(
    name: str, scene: Scene, engines: Sequence[EngineAblation], unsupported: Mapping[str, str]
) -> AblationStudy:
    """Findings on a scene from those in its engines.

    Args:
        unsupported: engine -> why it has no ingredients to study.
    """
    found = tuple(engines), dict(unsupported), dict(scene.lengths)
    return AblationStudy(name, scene.kind, scene.title, dict(scene.parameters), *found)


# -- models ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Variant:
    """A model.

    Attributes:
        ingredient: name of the one that it differs by from what it is compared with; empty where it is none.
        settings: that it is run with.
        against: settings of what it is compared with: the full model for TAKEN, the minimal one for all others.
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


def full_variants(minimal: Settings, idle: Sequence[Ingredient[Any]]) -> tuple[Variant, ...]:
    """The full model, and those that differ from it by one ingredient.

    Args:
        idle: ingredients that do the minimal model neither harm nor good: what others do could not be seen beside one
            that does harm, and what the minimal model needs every model needs.
    """
    chosen = [one for one in idle if not one.minimal]
    if not chosen:
        return ()
    full: Settings = reduce(lambda settings, one: one.added(settings), chosen, minimal)
    return (
        Variant(Role.FULL, "", full, minimal),
        *(Variant(Role.TAKEN, one.name, one.removed(full), full) for one in idle),
    )


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

    def run(self, settings: Settings) -> RunCase:
        """The run of a model."""
        return RunCase(self.name, self.scene, settings, signed_angles=COMPARED)

    def cost(self, variant: Variant, against: Settings) -> CostCase:
        """The timing of a model over another one."""
        return CostCase(
            self.name, self.scene, variant.settings, against=against, machine=machine_fingerprint(), rounds=self.rounds
        )

    def costs(self, variants: Sequence[Variant], runs: Results) -> list[CostCase]:
        """Timings of all models that ran to their end. The minimal model is timed against itself: a control."""
        minimal = variants[0]
        ended = [one for one in variants if runs[self.run(one.settings).key].outcome == Outcome.COMPLETED.slug]
        roles = {one.role for one in ended}
        if Role.MINIMAL not in roles:
            return []
        taken = [one for one in ended if one.role is Role.TAKEN and Role.FULL in roles]
        return [self.cost(one, minimal.settings) for one in ended] + [self.cost(one, one.against) for one in taken]

    def results(self, variants: Sequence[Variant], runs: Results, costs: Results) -> Found:
        """Measurements of each model."""
        return {(one.role, one.ingredient): self._result(one, variants[0], runs, costs) for one in variants}

    def _result(self, variant: Variant, minimal: Variant, runs: Results, costs: Results) -> VariantResult:
        run, other = (runs[self.run(settings).key] for settings in (variant.settings, variant.against))
        in_full = self.cost(variant, variant.against).key if variant.role is Role.TAKEN else ""
        return VariantResult(
            role=variant.role,
            ingredient=variant.ingredient,
            outcome=run.outcome,
            reason=run.reason,
            errors=None if run.errors is None else {q: run.largest(q) or 0.0 for q in JUDGED},
            change=change(run, other),
            cost=_timing(costs.get(self.cost(variant, minimal.settings).key)),
            cost_in_full=_timing(costs.get(in_full)),
            settings=variant.settings.as_dict(),
        )


def change(run: Measurement, other: Measurement) -> dict[str, float] | None:
    """Largest difference of the observed points by quantity, normalised; None unless both runs completed.

    Deviations from the exact motion at the crank angle reached are subtracted, not motions: where samples lie at other
    instants, a deviation can be interpolated at the cost of a small share of itself.
    """
    if run.signed is None or other.signed is None:
        return None
    off = {q: [run.signed_errors(point, q) - other.signed_errors(point, q) for point in run.signed] for q in QUANTITIES}
    return {q: float(np.linalg.norm(np.concatenate(parts), axis=1).max()) for q, parts in off.items()}


def _timing(cost: Measurement | None) -> PairedTiming | None:
    # A process that died or took too long has no cost; that its run completed is known from elsewhere.
    return None if cost is None or cost.payload is None else restore(PairedTiming, cost.payload["paired"])


def _judged(ingredients: Sequence[Ingredient[Any]], found: Found) -> tuple[IngredientResult, ...]:
    """Finding for each ingredient from the models that differ by it alone from those they are made from."""
    level, judged = levels(found[Role.MINIMAL, ""]), list[IngredientResult]()
    for one in ingredients:
        evidence = tuple(
            evidence_of(found[role, one.name], found[Role.FULL if role is Role.TAKEN else Role.MINIMAL, ""], level)
            for role in (Role.ADDED, Role.REDUCED, Role.TAKEN)
            if (role, one.name) in found
        )
        judgement, because = verdict(evidence)
        needed_by = tuple(quantity.value for quantity in one.needed_by)
        judged.append(IngredientResult(one.name, one.meaning, one.minimal, needed_by, judgement, because, evidence))
    return tuple(judged)
