"""Error budget: the parts of an error that are the iteration's, the step's, and the model's own.

With h the step, s the softness and k the iterations, the signed error at each crank angle telescopes:

    x(h,s,k) - x* = [x(h,s,k) - x(h,s,inf)] + [x(h,s,inf) - x(0,s,inf)] + [x(0,s,inf) - x*]
                  =      iteration          +          step             +       model

The trajectories are those of the last of two turns, at a hundred angles: what the start alone disturbs is not in them.
Norms of the parts are printed and not added: the parts may point against each other. Of the model's part each knob of
the softness, regularisation and stabilisation, is varied alone: what changes is that knob's. They are not summands,
because the gap of a soft joint is a product of both.

'Infinitely many' iterations and 'no' step are finite; how far the result is known is printed beside each part, as the
change that the last doubling made. A part no larger than that is not distinguishable from zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from conrod.engines import engine_named
from conrod.engines.capabilities import variations_of
from conrod.engines.variations import Variations
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.run import RunCase

BUDGET_ANGLES = 100
FINENESS = 16  # the finest step is the given one over this, the one before it twice as long
TOTAL, ITERATION, STEP, MODEL = "total", "iteration", "step", "model"
REGULARISATION, STABILISATION = "regularisation", "stabilisation"
AS_IS, CONVERGED, TWICE, FINER, FINEST = "as is", "converged", "converged twice", "finer", "finest"
LEAST_ROUNDING = 1e-13  # of normalised errors

Signed = Mapping[str, Mapping[str, Array]]  # quantity -> point -> (K, 2)
Weights = Mapping[str, int]  # of runs, by role


# -- the runs ----------------------------------------------------------------------------------------------------------


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
        return RunCase(name, scene, variations.refined(scene, chosen, finer * steps), signed_angles=BUDGET_ANGLES)

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


# -- the parts ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Norm:
    """Size of a signed part over the angles; the worst observed point counts.

    Attributes:
        max, rms: normalised as errors are.
        known_to: largest change that the last doubling made, or what rounding may sum to if that is more; None where
            nothing was doubled.
    """

    max: float
    rms: float
    known_to: float | None

    @property
    def resolved(self) -> bool:
        """True if the part is larger than its own uncertainty."""
        return self.known_to is None or self.max > 2.0 * self.known_to


@dataclass(frozen=True)
class Part:
    """One part of the budget.

    Attributes:
        name: total, iteration, step or model; or the knob that was varied, and at which step.
        changes: settings that the knob changed: from and to.
        norms: by quantity; None where a run did not complete.
        missing: roles and outcomes of the runs that it lacks.
    """

    name: str
    changes: Mapping[str, tuple[Any, Any]]
    norms: Mapping[str, Norm] | None
    missing: Mapping[str, str]


@dataclass(frozen=True)
class ErrorBudget:
    """The budget of one setting.

    Attributes:
        whole_run: largest error by quantity over the whole run, the start among it; None unless it completed.
    """

    scene: str
    engine: str
    preset: str
    settings: Mapping[str, Any]
    whole_run: Mapping[str, float] | None
    parts: tuple[Part, ...]

    def part(self, name: str) -> Part:
        """The part of a name; KeyError if there is none."""
        return {part.name: part for part in self.parts}[name]


def budget_of(plan: BudgetPlan, measurements: Mapping[str, Measurement]) -> ErrorBudget:
    """The budget from the measurements of its cases, by their keys; KeyError where one has not been measured."""
    runs = {role: measurements[case.key] for role, case in plan.cases.items()}
    last_step: Weights = {FINER: 1, FINEST: -1}
    parts = [
        _part(plan, runs, TOTAL, {AS_IS: 1}),
        _part(plan, runs, ITERATION, {AS_IS: 1, CONVERGED: -1}, {CONVERGED: 1, TWICE: -1}),
        _part(plan, runs, STEP, {CONVERGED: 1, FINEST: -1}, last_step),
        _part(plan, runs, MODEL, {FINEST: 1}, last_step),
    ]
    for knob in plan.changes:
        fine, finer = f"{knob} finest", f"{knob} finer"
        unknown = {FINEST: 1, fine: -1, FINER: -1, finer: 1}
        for when, weights, known_to in (
            ("no step", {FINEST: 1, fine: -1}, unknown),
            ("this step", {CONVERGED: 1, knob: -1}, None),
        ):
            parts.append(_part(plan, runs, f"{knob}, {when}", weights, known_to, plan.changes[knob]))
    settings, whole = plan.cases[AS_IS].settings, runs[AS_IS]
    return ErrorBudget(
        scene=plan.name,
        engine=settings.engine,
        preset=settings.preset,
        settings=settings.as_dict(),
        whole_run={q: size for q in QUANTITIES if (size := whole.largest(q)) is not None} or None,
        parts=tuple(parts),
    )


def _part(
    plan: BudgetPlan,
    runs: Mapping[str, Measurement],
    name: str,
    weights: Weights,
    unknown: Weights | None = None,
    changes: Mapping[str, tuple[Any, Any]] | None = None,
) -> Part:
    """A sum of runs with weights, and another one for its uncertainty."""
    missing = {role: runs[role].outcome for role in {**weights, **(unknown or {})} if runs[role].signed is None}
    norms = None
    if not missing:
        summed, left = combined(plan, runs, weights), combined(plan, runs, unknown or {})
        steps = max((plan.cases[role].settings.steps_per_revolution for role in unknown or {}), default=0)
        known_to = {q: max(rounding_level(steps), _sizes(left[q])[0]) if unknown else None for q in QUANTITIES}
        norms = {q: Norm(*_sizes(summed[q]), known_to[q]) for q in QUANTITIES}
    return Part(name, changes or {}, norms, missing)


def combined(plan: BudgetPlan, runs: Mapping[str, Measurement], weights: Weights) -> Signed:
    """Signed errors of completed runs summed with weights, at each angle."""
    points, zero = plan.cases[AS_IS].scene.lengths, np.zeros((1, 2))
    return {
        q: {p: sum((w * runs[role].signed_of(p, q) for role, w in weights.items()), zero) for p in points}
        for q in QUANTITIES
    }


def _sizes(points: Mapping[str, Array]) -> tuple[float, float]:
    """Largest and root mean square length of the vectors (K, 2) of the worst point, each."""
    lengths = [np.linalg.norm(values, axis=1) for values in points.values()]
    return max(float(x.max()) for x in lengths), max(float(np.sqrt(np.mean(x**2))) for x in lengths)


def rounding_level(steps: int) -> float:
    """Normalised error that is rounding: two turns' steps may sum a last digit each."""
    return max(LEAST_ROUNDING, 2.0 * steps * float(np.finfo(float).eps))
