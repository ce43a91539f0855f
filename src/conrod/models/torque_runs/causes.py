"""Likely causes of a run's differences from the exact motion: each is fitted, and named only where it explains them.

A cause changes the machine, the torque, the start or the stamps by one number p. Its effect is the difference of two
motions of the reduced machine, with p and without, integrated in coarse steps: errors of these steps cancel. p is
fitted by least squares (Gauss and Newton, with the secant for the derivative) over the first turns of the run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from conrod.errors import InvalidInput
from conrod.models.tables.causes import MAX_REMAINING_SHARE, Cause
from conrod.models.torque_runs.coarse_step import coarse_step_cause
from conrod.models.torque_runs.comparison import RunComparison
from conrod.models.torque_runs.exact import Values
from conrod.models.torque_runs.hypotheses import Hypothesis, run_hypotheses
from conrod.models.torque_runs.question import MIN_FIT_ROWS, RunQuestion

MAX_FIT_STEPS = 6
FIT_PRECISION = 5e-5  # share of an error that the coarse integration leaves where the cause is the right one
# A cause replaces another where it leaves less than this share of what that leaves.
FAR_BETTER_FACTOR = 0.1


def likely_run_causes(question: RunQuestion, wrong: Sequence[str]) -> tuple[Cause, ...]:
    """Find the causes that reproduce a run's errors, the most comprehensive first; a coarse step where none does."""
    first = question.first_turns
    before = {name: size for name in wrong if (size := first.run.largest(name))}
    found = dict[str, Cause]()
    if len(first.run.times) >= MIN_FIT_ROWS:
        base = first.predict()
        for hypothesis in run_hypotheses(first):
            cause = _try_cause(first, base, hypothesis, before)
            if cause and (cause.kind not in found or _share(cause) < FAR_BETTER_FACTOR * _share(found[cause.kind])):
                found[cause.kind] = cause
    ranked = sorted(found.values(), key=lambda one: -len(one.explains))
    kept = [one for one in ranked if not any(_beats(other, one) for other in ranked if other is not one)]
    whole = [one for one in kept if set(before) <= set(one.explains)]
    coarse = coarse_step_cause(question.run, question.scene, wrong)
    return (*whole, *([coarse] if coarse else []), *([] if whole else kept))


def _beats(one: Cause, other: Cause) -> bool:
    """True if a cause explains all that another explains, and leaves far less of it."""
    return set(other.explains) <= set(one.explains) and _share(one) < FAR_BETTER_FACTOR * _share(other)


def _share(cause: Cause) -> float:
    """Largest share of an explained error that remains; below `FIT_PRECISION` it is the coarse integration's."""
    return max(FIT_PRECISION, *(after / before for before, after in cause.explains.values()))


# -- a cause is tried --------------------------------------------------------------------------------------------------


def _try_cause(
    question: RunQuestion, base: Values, hypothesis: Hypothesis, before: Mapping[str, float]
) -> Cause | None:
    """Fit the size of a cause, and return the cause if it explains an error; None otherwise."""
    kind, words, predict, probe = hypothesis
    run = question.run

    def compare_without_cause(size: float) -> RunComparison:
        changed = predict(size)
        return replace(run, exact={name: own + (changed[name] - base[name]) for name, own in run.exact.items()})

    try:
        size, undone = (0.0, compare_without_cause(0.0)) if probe is None else _fit(run, compare_without_cause, probe)
    except (InvalidInput, ArithmeticError):
        return None  # the machine does not move so
    explains = {
        name: (large, after) for name, large in before.items()
        if (after := undone.largest(name)) is not None and after <= MAX_REMAINING_SHARE * min(large, 1.0)
    }  # fmt: skip
    return Cause(kind, words(size), explains) if explains else None


def _fit(
    run: RunComparison, compare_without_cause: Callable[[float], RunComparison], probe: float
) -> tuple[float, RunComparison]:
    """Fit the size of a cause by least squares of all differences; return it, and the comparison without the cause."""
    sizes, residuals, found = [0.0], [run.normalised_differences()], [run]
    step = probe
    for _ in range(MAX_FIT_STEPS):
        tried = compare_without_cause(sizes[-1] + step)
        sizes.append(sizes[-1] + step)
        residuals.append(tried.normalised_differences())
        found.append(tried)
        slope = (residuals[-1] - residuals[-2]) / (sizes[-1] - sizes[-2])
        squares = float(slope @ slope)
        if squares == 0.0 or not math.isfinite(squares):
            break
        step = -float(slope @ residuals[-1]) / squares
        if abs(step) <= 1e-4 * abs(sizes[-1]) or step == 0.0:
            break
    best = min(range(len(sizes)), key=lambda k: float(residuals[k] @ residuals[k]))
    return sizes[best], found[best]
