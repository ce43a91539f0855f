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

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from conrod.exact.motion import Array
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.sweep.budget_plan import (
    AS_IS,
    CONVERGED,
    FINER,
    FINEST,
    REGULARISATION,
    STABILISATION,
    TWICE,
    BudgetPlan,
)
from conrod.studies.validation.refinement import rounding_level

TOTAL, ITERATION, STEP, MODEL = "total", "iteration", "step", "model"
NAMED = 0.25  # a law names a cause where it gives the size this well
TELESCOPED = 16.0 * float(np.finfo(float).eps)

Signed = Mapping[str, Mapping[str, Array]]  # quantity -> point -> (K, 2)
Prediction = tuple[float, str]  # largest position error, normalised, and the law in words


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
        predicted: largest position error that the engine's documented law gives; None where there is no law.
        law: in words.
    """

    name: str
    changes: Mapping[str, tuple[Any, Any]]
    norms: Mapping[str, Norm] | None
    missing: Mapping[str, str]
    predicted: float | None = None
    law: str = ""

    @property
    def named(self) -> bool:
        """True if the law predicts the size, so that the cause may be named."""
        if self.norms is None or self.predicted is None:
            return False
        position = self.norms["position"].max
        return abs(self.predicted - position) <= NAMED * position


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


def budget_of(
    plan: BudgetPlan, measurements: Mapping[str, Measurement], predictions: Mapping[str, Prediction] | None = None
) -> ErrorBudget:
    """The budget from the measurements of its cases.

    Args:
        plan: of the runs.
        measurements: by the cases' keys.
        predictions: what the engine's law gives for the settings of a run, by role; see `roles_of_law`.

    Raises:
        KeyError: a case of the plan has not been measured.
        ArithmeticError: the parts do not sum to the whole.
    """
    runs = Runs(plan, {role: measurements[case.key] for role, case in plan.cases.items()})
    laws = predictions or {}
    _check_sum(runs)
    parts = [
        runs.part(TOTAL, {AS_IS: 1}),
        runs.part(ITERATION, {AS_IS: 1, CONVERGED: -1}, {CONVERGED: 1, TWICE: -1}),
        runs.part(STEP, {CONVERGED: 1, FINEST: -1}, {FINER: 1, FINEST: -1}),
        runs.part(MODEL, {FINEST: 1}, {FINER: 1, FINEST: -1}, prediction=laws.get(FINEST)),
    ]
    for knob in (k for k in (REGULARISATION, STABILISATION) if k in plan.changes):
        fine, finer = f"{knob} finest", f"{knob} finer"
        unknown = {FINEST: 1, fine: -1, FINER: -1, finer: 1}
        changes, none, this = plan.changes[knob], _change(laws, FINEST, fine), _change(laws, CONVERGED, knob)
        parts.append(runs.part(f"{knob}, no step", {FINEST: 1, fine: -1}, unknown, changes, none))
        parts.append(runs.part(f"{knob}, this step", {CONVERGED: 1, knob: -1}, None, changes, this))
    settings, whole = plan.cases[AS_IS].settings, runs.measured[AS_IS]
    return ErrorBudget(
        scene=plan.name,
        engine=settings.engine,
        preset=settings.preset,
        settings=settings.as_dict(),
        whole_run={q: size for q in QUANTITIES if (size := whole.largest(q)) is not None} or None,
        parts=tuple(parts),
    )


def roles_of_law(plan: BudgetPlan) -> tuple[str, ...]:
    """The runs whose sizes a law can give: converged ones, because laws are of softness, and at the finest step.

    A law with the step in it gives what is left of it at the finest; one without gives the same at both.
    """
    knobs = tuple(plan.changes)
    return (FINEST, *((CONVERGED,) if knobs else ()), *knobs, *(f"{knob} finest" for knob in knobs))


def _change(predictions: Mapping[str, Prediction], role: str, varied: str) -> Prediction | None:
    # Both knobs scale the gap and keep its shape, so what a knob changes is the difference of the sizes.
    if role not in predictions or varied not in predictions:
        return None
    return abs(predictions[role][0] - predictions[varied][0]), predictions[role][1]


@dataclass(frozen=True)
class Runs:
    """The measurements of a plan, by role."""

    plan: BudgetPlan
    measured: Mapping[str, Measurement]

    def part(
        self,
        name: str,
        sum_of: Mapping[str, int],
        unknown: Mapping[str, int] | None = None,
        changes: Mapping[str, tuple[Any, Any]] | None = None,
        prediction: Prediction | None = None,
    ) -> Part:
        """A sum of runs with weights, and another one for its uncertainty."""
        missing = {role: self.measured[role].outcome for role in self.failed({**sum_of, **(unknown or {})})}
        predicted, law = prediction or (None, "")
        norms = None if missing else self._norms(sum_of, unknown)
        return Part(name, changes or {}, norms, missing, predicted, law)

    def failed(self, roles: Iterable[str]) -> list[str]:
        """The roles whose runs have no errors."""
        return [role for role in roles if self.measured[role].signed is None]

    def combined(self, weights: Mapping[str, int]) -> Signed:
        """Signed errors of completed runs summed with weights, at each angle."""
        points = self.plan.cases[AS_IS].scene.lengths
        zero = np.zeros(1)
        return {
            q: {p: sum((w * self.measured[role].signed_of(p, q) for role, w in weights.items()), zero) for p in points}
            for q in QUANTITIES
        }

    def _norms(self, sum_of: Mapping[str, int], unknown: Mapping[str, int] | None) -> dict[str, Norm]:
        summed = self.combined(sum_of)
        if unknown is None:
            return {quantity: Norm(*sizes(summed[quantity]), None) for quantity in QUANTITIES}
        left = self.combined(unknown)
        rounding = rounding_level(max(self.plan.cases[role].settings.steps_per_revolution for role in unknown))
        return {q: Norm(*sizes(summed[q]), max(rounding, sizes(left[q])[0])) for q in QUANTITIES}


def sizes(points: Mapping[str, Array]) -> tuple[float, float]:
    """Largest and root mean square length of the vectors (K, 2) of the worst point, each."""
    lengths = [np.linalg.norm(values, axis=1) for values in points.values()]
    return max(float(x.max()) for x in lengths), max(float(np.sqrt(np.mean(x**2))) for x in lengths)


def _check_sum(runs: Runs) -> None:
    if runs.failed((AS_IS, CONVERGED, FINEST)):
        return
    iteration = runs.combined({AS_IS: 1, CONVERGED: -1})
    step, model = runs.combined({CONVERGED: 1, FINEST: -1}), runs.combined({FINEST: 1})
    for quantity, points in runs.combined({AS_IS: 1}).items():
        for name, total in points.items():
            terms = [part[quantity][name] for part in (iteration, step, model)]
            scale = max(float(np.abs(values).max()) for values in (total, *terms))
            if not float(np.abs(sum(terms) - total).max()) <= TELESCOPED * scale:
                raise ArithmeticError(f"{quantity} of {name}: iteration, step and model do not sum to the error")
