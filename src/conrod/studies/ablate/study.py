"""Study of a model's ingredients: the compared models, their runs, timings and findings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import Any, ClassVar

import numpy as np

from conrod.comparison.trajectory import Outcome, Settings
from conrod.engines import Engine, engine_named
from conrod.engines.capabilities import ModelIngredients, require_capability
from conrod.engines.engine import default_steps
from conrod.engines.variants import Ingredient
from conrod.exact.motion import QUANTITIES
from conrod.execution.case import Results, Study
from conrod.execution.paired_timing import ROUNDS, PairedTiming, time_settings_pair
from conrod.execution.reference_guard import ReferenceGuard
from conrod.execution.run import RunCase, RunResult, clamp_to_span
from conrod.execution.timing import machine_fingerprint
from conrod.scenes import Scene
from conrod.studies.ablate.findings import (
    JUDGED_ERRORS,
    AblationStudy,
    Effect,
    EngineAblation,
    IngredientResult,
    Role,
    VariantResult,
    evidence_of,
    ingredient_verdict,
    reference_errors,
)


@dataclass(frozen=True)
class CostResult(RunResult):
    """Result of a paired timing.

    Attributes:
        timing: ratio of the costs of a revolution with two settings; None if the process ended before it was known.
    """

    timing: PairedTiming | None = None


@dataclass(frozen=True)
class CostCase(RunCase):
    """Timing of a revolution with two settings, as the ratio of costs; see `PairedTiming`.

    Attributes:
        against: settings to compare with.
        machine: fingerprint of the machine that runs the timing; timings of several machines are kept apart.
        rounds: number of times that both are timed.
    """

    study: ClassVar[str] = "ablate"
    result_type: ClassVar[type[Any]] = CostResult

    signed_angles: int = 0
    against: Settings = field(kw_only=True)
    machine: str = field(kw_only=True)
    rounds: int = field(kw_only=True, default=ROUNDS)

    def perform(self) -> CostResult:
        timing = time_settings_pair(
            engine_named(self.settings.engine), self.scene, self.settings, self.against, rounds=self.rounds
        )
        return CostResult(timing=timing)

    def key_fields(self) -> dict[str, Any]:
        against = {key: value for key, value in self.against.as_dict().items() if key != "preset"}
        return super().key_fields() | {"against": against, "machine": self.machine, "rounds": self.rounds}


ResultsByVariant = Mapping[tuple[Role, str], VariantResult]  # by role and ingredient
COMPARED_ANGLES = 100  # crank angles of the last turn, or of the one pass, at which two motions are compared


def ablate_engine(
    name: str, scene: Scene, engine: Engine[Any], steps: int | None, rounds: int
) -> Study[EngineAblation]:
    """Run and time the models of a scene in one engine, and judge each ingredient.

    Yields two batches of runs, then the timings, which have to be made without other runs.

    Args:
        name: name of the scene.
        scene: the scene.
        engine: the engine.
        steps: steps per revolution; None for the usual number.
        rounds: rounds of each timing.

    Raises:
        InvalidInput: the engine has no ingredients.
    """
    models, cases = require_capability(engine, ModelIngredients), AblationCases(name, scene, rounds)
    minimal = models.minimal_settings(scene, steps or default_steps(scene))
    offered = models.ingredients(scene, minimal)
    ingredients = [one for one in offered if not one.refusal]
    variants = minimal_variants(minimal, ingredients)
    guard = ReferenceGuard()
    runs = yield [cases.run_case(one.settings) for one in variants]
    # The full model has the ingredients that alone have no effect, so they are run alone first.
    alone = _ingredient_results(ingredients, cases.variant_results(variants, runs, {}))
    effects = {one.name: one.evidence[0].effect for one in alone}
    variants += full_variants(minimal, [one for one in ingredients if effects[one.name] is Effect.NONE])
    runs = yield [cases.run_case(one.settings) for one in variants]
    guard.check([cases.run_case(one.settings) for one in variants], runs)
    # After all runs, because runs at the same time would slow the timed ones.
    costs = yield cases.cost_cases(variants, runs)
    found = cases.variant_results(variants, runs, costs)
    return EngineAblation(
        engine=engine.name,
        version=engine.version,
        steps_per_revolution=minimal.steps_per_revolution,
        revolutions=clamp_to_span(cases.run_case(minimal)).revolutions,
        machine=machine_fingerprint(),
        ingredients=_ingredient_results(ingredients, found),
        variants=tuple(found.values()),
        distrust=guard.distrust,
        absent={one.name: one.refusal for one in offered if one.refusal},
    )


def ablation_study(
    name: str, scene: Scene, engines: Sequence[EngineAblation], unsupported: Mapping[str, str]
) -> AblationStudy:
    """Collect the findings of all engines on a scene.

    Args:
        name, scene: the scene.
        engines: findings in each engine.
        unsupported: reasons why engines have no ingredients to study, by engine name.
    """
    found = tuple(engines), dict(unsupported), dict(scene.lengths)
    return AblationStudy(name, scene.kind, scene.title, dict(scene.parameters), *found)


# -- models ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Variant:
    """A model that is run, and the model that it is compared with.

    Attributes:
        role: place in the study.
        ingredient: ingredient by which the two models differ; empty for the minimal and the full model.
        settings: settings of the model.
        against: settings of the other model: the full one for REMOVED_FROM_FULL, else the minimal one.
    """

    role: Role
    ingredient: str
    settings: Settings
    against: Settings


def minimal_variants(minimal: Settings, ingredients: Sequence[Ingredient[Any]]) -> tuple[Variant, ...]:
    """Return the minimal model, and each model that differs from it by one ingredient."""
    parts, extras = [one for one in ingredients if one.minimal], [one for one in ingredients if not one.minimal]
    return (
        Variant(Role.MINIMAL, "", minimal, minimal),
        *(Variant(Role.ADDED_TO_MINIMAL, one.name, one.added(minimal), minimal) for one in extras),
        *(Variant(Role.REMOVED_FROM_MINIMAL, one.name, one.removed(minimal), minimal) for one in parts),
    )


def full_variants(minimal: Settings, idle: Sequence[Ingredient[Any]]) -> tuple[Variant, ...]:
    """Return the full model, and each model that differs from it by one ingredient.

    Args:
        minimal: settings of the minimal model.
        idle: ingredients without effect on the minimal model. A harmful one would hide the effects of others, and a
            required one is required in every model.
    """
    chosen = [one for one in idle if not one.minimal]
    if not chosen:
        return ()
    full: Settings = reduce(lambda settings, one: one.added(settings), chosen, minimal)
    return (
        Variant(Role.FULL, "", full, minimal),
        *(Variant(Role.REMOVED_FROM_FULL, one.name, one.removed(full), full) for one in idle),
    )


@dataclass(frozen=True)
class AblationCases:
    """Cases of a scene's models, their runs and timings, and the results of models from them.

    Attributes:
        name, scene: the scene.
        rounds: rounds of each timing.
    """

    name: str
    scene: Scene
    rounds: int

    def run_case(self, settings: Settings) -> RunCase:
        """Return the run of a model."""
        return RunCase(self.name, self.scene, settings, signed_angles=COMPARED_ANGLES)

    def cost_case(self, variant: Variant, against: Settings) -> CostCase:
        """Return the paired timing of a model and other settings."""
        return CostCase(
            self.name, self.scene, variant.settings, against=against, machine=machine_fingerprint(), rounds=self.rounds
        )

    def cost_cases(self, variants: Sequence[Variant], runs: Results) -> list[CostCase]:
        """Return the timings of completed models over the minimal and the full model.

        The minimal model is also timed over itself, as a control.
        """
        minimal = variants[0]
        completed = [one for one in variants if runs[self.run_case(one.settings).key].outcome == Outcome.COMPLETED.slug]
        roles = {one.role for one in completed}
        if Role.MINIMAL not in roles:
            return []
        reduced = [one for one in completed if one.role is Role.REMOVED_FROM_FULL and Role.FULL in roles]
        over_minimal = [self.cost_case(one, minimal.settings) for one in completed]
        return over_minimal + [self.cost_case(one, one.against) for one in reduced]

    def variant_results(self, variants: Sequence[Variant], runs: Results, costs: Results) -> ResultsByVariant:
        """Return the result of each model from its run and timings."""
        return {(one.role, one.ingredient): self._result(one, variants[0], runs, costs) for one in variants}

    def _result(self, variant: Variant, minimal: Variant, runs: Results, costs: Results) -> VariantResult:
        """Return the result of one model."""
        run, other = (runs[self.run_case(settings).key] for settings in (variant.settings, variant.against))
        in_full = variant.role is Role.REMOVED_FROM_FULL
        return VariantResult(
            role=variant.role,
            ingredient=variant.ingredient,
            outcome=run.outcome,
            reason=run.reason,
            errors=None if run.errors is None else {q: run.largest(q) or 0.0 for q in JUDGED_ERRORS},
            change=motion_change(run, other),
            cost=self._timing(variant, minimal.settings, costs),
            cost_in_full=self._timing(variant, variant.against, costs) if in_full else None,
            settings=variant.settings.as_dict(),
        )

    def _timing(self, variant: Variant, against: Settings, costs: Results) -> PairedTiming | None:
        """Return the timing of a model and other settings; None if it is missing or its process failed."""
        cost: CostResult | None = costs.get(self.cost_case(variant, against).key)
        return None if cost is None else cost.timing


def motion_change(run: RunResult, other: RunResult) -> dict[str, float] | None:
    """Largest normalised difference of two motions by quantity; None unless both completed.

    The signed errors of both at the same crank angles are subtracted, not the motions: if samples lie at other
    instants, an error is interpolated, which costs only a small share of the error.
    """
    if run.signed is None or other.signed is None:
        return None
    off = {q: [run.signed_errors(point, q) - other.signed_errors(point, q) for point in run.signed] for q in QUANTITIES}
    return {q: float(np.linalg.norm(np.concatenate(parts), axis=1).max()) for q, parts in off.items()}


# Role of the model from which a model of a role is made.
BASES = {
    Role.ADDED_TO_MINIMAL: Role.MINIMAL,
    Role.REMOVED_FROM_MINIMAL: Role.MINIMAL,
    Role.REMOVED_FROM_FULL: Role.FULL,
}


def _ingredient_results(
    ingredients: Sequence[Ingredient[Any]], found: ResultsByVariant
) -> tuple[IngredientResult, ...]:
    """Judge each ingredient from the pairs of models that differ by it alone."""
    level, judged = reference_errors(found[Role.MINIMAL, ""]), list[IngredientResult]()
    for one in ingredients:
        evidence = tuple(
            evidence_of(found[role, one.name], found[base, ""], level)
            for role, base in BASES.items()
            if (role, one.name) in found
        )
        judgement, because = ingredient_verdict(evidence)
        needed_by = tuple(quantity.value for quantity in one.needed_by)
        judged.append(IngredientResult(one.name, one.meaning, one.minimal, needed_by, judgement, because, evidence))
    return tuple(judged)
