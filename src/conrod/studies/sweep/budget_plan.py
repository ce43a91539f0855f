"""Runs that separate iteration, step and softness: each varied alone from one setting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from conrod.engines import engine_named
from conrod.engines.capabilities import variations_of
from conrod.engines.variations import Variations
from conrod.errors import InvalidInput
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.run import RunCase
from conrod.studies.validation.refinement import refined

BUDGET_ANGLES = 100
FINENESS = 16  # the finest step is the given one over this, the one before it twice as long

REGULARISATION, STABILISATION = "regularisation", "stabilisation"
AS_IS, CONVERGED, TWICE, FINER, FINEST = "as is", "converged", "converged twice", "finer", "finest"


@dataclass(frozen=True)
class BudgetPlan:
    """The runs of an error budget.

    Attributes:
        cases: by role. `as is`; `converged` and `converged twice`: with infinitely many iterations and with twice
            that; `finer` and `finest`: converged, at half the fineness and at all of it, softness fixed in seconds.
            `<knob>`, `<knob> finer` and `<knob> finest`: converged, with the softness of one knob varied.
        changes: by knob, the settings that it changes: from and to.
    """

    name: str
    cases: Mapping[str, RunCase]
    changes: Mapping[str, Mapping[str, tuple[Any, Any]]]


def budget_plan_of(name: str, scene: Scene, settings: Settings, fineness: int = FINENESS) -> BudgetPlan:
    """The runs that an error budget of one setting needs.

    Args:
        name: of the scene.
        settings: with a number of steps per revolution that is a multiple of 100, the angles that are compared.
        fineness: an even number; how much finer the step is that stands for none.

    Raises:
        InvalidInput: steps that miss the angles, or a fineness that is odd.
    """
    steps = settings.steps_per_revolution
    if steps % BUDGET_ANGLES:
        raise InvalidInput(f"steps_per_revolution = {steps} must be a multiple of {BUDGET_ANGLES} for an error budget")
    if fineness < 2 or fineness % 2:
        raise InvalidInput(f"fineness = {fineness} must be an even number")

    def case(chosen: Settings, finer: int = 1) -> RunCase:
        return RunCase(name, scene, refined(scene, chosen, finer * steps), signed_angles=BUDGET_ANGLES)

    variations: Variations[Any] = variations_of(engine_named(settings.engine))
    solved = variations.converged(scene, settings)
    cases = {
        AS_IS: RunCase(name, scene, settings, signed_angles=BUDGET_ANGLES),
        CONVERGED: case(solved),
        TWICE: case(variations.converged(scene, settings, 2)),
        FINER: case(solved, fineness // 2),
        FINEST: case(solved, fineness),
    }
    changes = {}
    for knob, varied in (
        (REGULARISATION, variations.less_regularised(scene, solved)),
        (STABILISATION, variations.restabilised(scene, solved)),
    ):
        if varied is not None:
            cases |= {knob: case(varied), f"{knob} finer": case(varied, fineness // 2)}
            cases[f"{knob} finest"] = case(varied, fineness)
            changes[knob] = _changes(solved, varied)
    return BudgetPlan(name, cases, changes)


def _changes(before: Settings, after: Settings) -> dict[str, tuple[Any, Any]]:
    old, new = before.as_dict(), after.as_dict()
    return {key: (old[key], new[key]) for key in old if old[key] != new[key]}
