"""The cheapest setting within given tolerances, confirmed on runs that the grid does not contain."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from conrod.engines import Engine
from conrod.engines.capabilities import Lacking, Pasted, Timed, capability
from conrod.engines.engine import CUSTOM, STOCK
from conrod.errors import InvalidInput
from conrod.mechanism.units import check_number
from conrod.scenes import Scene
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.study import Study
from conrod.studies.recommend.recommendation import (
    Confirmation,
    Recommendation,
    Refusal,
    Rejected,
    groups_of,
    savings_of,
)
from conrod.studies.sweep.plan import RulePlan, SweepPlan
from conrod.studies.sweep.study import Clock

LARGEST_TOLERANCE = 1e6
SMALLEST_TOLERANCE = 1e-15
# Between two steps of the grid, one is tried at which the error should be this much below what is allowed.
AIMED_MARGIN = 1.25
STEP_UNIT = 4  # steps per revolution are multiples of this
# Runs that the grid does not contain.
OTHER_START = math.radians(37.0)
MORE_REVOLUTIONS = 5.0
OTHER_SPEEDS = (0.9, 1.1)

Tolerances = Mapping[str, float]  # largest normalised error by quantity
Answer = Recommendation | Refusal


@dataclass(frozen=True)
class Candidate:
    """A setting within the tolerances."""

    swept: RulePlan
    case: RunCase
    measurement: Measurement

    @property
    def steps(self) -> int:
        """Steps per revolution."""
        return self.case.settings.steps_per_revolution


def check_tolerances(tolerances: Mapping[str, float | None]) -> dict[str, float]:
    """The tolerances that were given, of normalised errors.

    Raises:
        InvalidInput: none is, or one that no run can meet, or that means nothing.
    """
    given = {quantity: value for quantity, value in tolerances.items() if value is not None}
    if not given:
        raise InvalidInput(
            "no tolerance: give at least one of --position, --velocity, --acceleration, e.g. --position 1e-6"
        )
    for quantity, value in given.items():
        check_number(f"--{quantity}", value, SMALLEST_TOLERANCE, LARGEST_TOLERANCE)
    return given


def recommend_for(plan: SweepPlan, allowed: Tolerances, time: Clock) -> Study[list[Answer]]:
    """For each engine of the plan its cheapest confirmed setting, or what is nearest.

    Args:
        plan: of the sweep of one scene.
        allowed: largest error by quantity.
        time: takes costs.
    """
    measured = dict((yield plan.grid_cases))
    answers = list[Answer]()
    for engine in dict.fromkeys(rule.engine.name for rule in plan.rules):
        rules = [rule for rule in plan.rules if rule.engine.name == engine]
        answers.append((yield from _for_engine(rules, measured, allowed, time)))
    return answers


def _for_engine(
    rules: Sequence[RulePlan], measured: Mapping[str, Measurement], allowed: Tolerances, time: Clock
) -> Study[Answer]:
    found = yield from _candidates(rules, measured, allowed)
    waiting = {candidate.case.key: candidate for candidate in found}
    timings = dict(time([candidate.case for candidate in waiting.values()]))
    if found and not timings:
        clock = capability(rules[0].engine, Timed)
        why = clock.reason if isinstance(clock, Lacking) else "nothing within the tolerances could be timed"
        return Refusal(rules[0].engine.name, "", 0, {}, {}, (), why)
    rejected: list[Rejected] = []
    # What cannot be timed cannot be called the cheapest.
    while waiting := {key: c for key, c in waiting.items() if key in timings}:
        candidate = waiting.pop(min(waiting, key=lambda key: timings[key].ratio))
        confirmations = yield from _confirmed(candidate, allowed)
        lost = tuple(one for one in confirmations if not one.held)
        if not lost:
            return _recommendation(candidate, rules, measured, allowed, time, confirmations, tuple(rejected))
        rejected.append(Rejected(candidate.swept.rule.name, candidate.steps, lost))
        finer = _next_finer(candidate, measured, allowed)
        if finer is not None and finer.case.key not in waiting:
            waiting[finer.case.key] = finer
            timings |= time([finer.case])
    return _refusal(rules, measured, allowed, tuple(rejected))


# -- candidates ------------------------------------------------------------------------------------------------------


def excess(measurement: Measurement, allowed: Tolerances) -> float:
    """Largest error over what is allowed; infinite unless the run completed."""
    found = [(measurement.largest(quantity), limit) for quantity, limit in allowed.items()]
    return max(math.inf if error is None else error / limit for error, limit in found)


def _candidates(
    rules: Sequence[RulePlan], measured: Mapping[str, Measurement], allowed: Tolerances
) -> Study[list[Candidate]]:
    """The coarsest step of each rule that is within tolerance: of the grid, or better between two of the grid."""
    of_grid, between = list[Candidate](), dict[str, tuple[RulePlan, RunCase]]()
    for swept in rules:
        excesses = [excess(measured[case.key], allowed) for case in swept.cases]
        k = next((k for k, e in enumerate(excesses) if e <= 1.0), None)
        if k is None:
            continue
        of_grid.append(Candidate(swept, swept.cases[k], measured[swept.cases[k].key]))
        if k > 0 and (case := _between(swept, k, excesses)) is not None:
            between[case.key] = (swept, case)
    found = (yield [case for _, case in between.values()]) if between else {}
    tried = [Candidate(swept, case, found[key]) for key, (swept, case) in between.items()]
    return [*of_grid, *(one for one in tried if excess(one.measurement, allowed) <= 1.0)]


def _between(swept: RulePlan, k: int, excesses: Sequence[float]) -> RunCase | None:
    """The step between the last one that is out and the first one within, at which the error should just do."""
    out, within = excesses[k - 1 : k + 1]
    low, high = (case.settings.steps_per_revolution for case in swept.cases[k - 1 : k + 1])
    if not math.isfinite(out) or within <= 0.0:
        return None
    share = math.log(out * AIMED_MARGIN) / math.log(out / within)
    steps = STEP_UNIT * math.ceil(low * (high / low) ** share / STEP_UNIT)
    if not low < steps < high:
        return None
    case = swept.cases[k]
    return RunCase(case.name, case.scene, swept.rule.settings(case.scene, steps))


def _next_finer(candidate: Candidate, measured: Mapping[str, Measurement], allowed: Tolerances) -> Candidate | None:
    """The next finer step of the same rule that the grid has within tolerance."""
    for case in candidate.swept.cases:
        if case.settings.steps_per_revolution > candidate.steps and excess(measured[case.key], allowed) <= 1.0:
            return Candidate(candidate.swept, case, measured[case.key])
    return None


# -- confirmation ----------------------------------------------------------------------------------------------------


def _confirmed(candidate: Candidate, allowed: Tolerances) -> Study[tuple[Confirmation, ...]]:
    cases = dict(confirming_cases(candidate.swept, candidate.case))
    found = yield list(cases.values())
    return tuple(_confirmation(what, found[case.key], allowed) for what, case in cases.items())


def confirming_cases(swept: RulePlan, case: RunCase) -> Iterator[tuple[str, RunCase]]:
    """Runs that the grid does not contain: another start, more revolutions, other speeds.

    An input that makes one pass has one start and one length of a run: it makes the pass backwards instead.
    """
    steps = case.settings.steps_per_revolution
    backwards = []
    if case.scene.kinematics.mechanism.driver.span is None:
        yield "start at 37 deg", RunCase(case.name, case.scene, case.settings, start_angle=OTHER_START)
        yield "five revolutions", RunCase(case.name, case.scene, case.settings, revolutions=MORE_REVOLUTIONS)
    else:
        backwards = [("the pass backwards", -1.0)]
    for what, factor in [*backwards, *((f"speed {factor - 1.0:+.0%}", factor) for factor in OTHER_SPEEDS)]:
        scene: Scene = case.scene.with_parameters(speed=factor * case.scene.speed)
        yield what, RunCase(case.name, scene, swept.rule.settings(scene, steps))


def _confirmation(what: str, measurement: Measurement, allowed: Tolerances) -> Confirmation:
    errors = {q: e for q in allowed if (e := measurement.largest(q)) is not None}
    return Confirmation(what, measurement.outcome, errors or None, excess(measurement, allowed) <= 1.0)


# -- results ---------------------------------------------------------------------------------------------------------


def _recommendation(
    candidate: Candidate,
    rules: Sequence[RulePlan],
    measured: Mapping[str, Measurement],
    allowed: Tolerances,
    time: Clock,
    confirmations: tuple[Confirmation, ...],
    rejected: tuple[Rejected, ...],
) -> Recommendation:
    swept, case = candidate.swept, candidate.case
    stock = [c for rule in rules for c in rule.cases if c.settings.preset == STOCK]
    completed = [c for c in stock if measured[c.key].errors is not None]
    timings = time([*completed, case])
    return Recommendation(
        engine=swept.engine.name,
        rule=swept.rule.name,
        preset=None if case.settings.preset == CUSTOM else case.settings.preset,
        case=case,
        errors={q: candidate.measurement.largest(q) or 0.0 for q in allowed},
        margin=1.0 / max(excess(candidate.measurement, allowed), 1e-300),
        timing=timings[case.key],
        confirmations=confirmations,
        rejected=rejected,
        savings=savings_of(candidate.measurement, timings[case.key], completed, measured, timings, allowed),
        groups=groups_of(case.scene, case.settings),
        paste=_paste(swept.engine, case),
    )


def _paste(engine: Engine[Any], case: RunCase) -> str:
    """The settings as lines for the user; the reason where the engine gives none."""
    pasted = capability(engine, Pasted)
    return f"# {pasted.reason}" if isinstance(pasted, Lacking) else pasted.paste(case.scene, case.settings)


def _refusal(
    rules: Sequence[RulePlan],
    measured: Mapping[str, Measurement],
    allowed: Tolerances,
    rejected: tuple[Rejected, ...],
) -> Refusal:
    cases = [(rule, case) for rule in rules for case in rule.cases]
    rule, case = min(cases, key=lambda pair: excess(measured[pair[1].key], allowed))
    nearest, engine = measured[case.key], rules[0].engine.name
    if nearest.errors is None:
        return Refusal(engine, "", 0, {}, {}, rejected, "no run of the grid completed")
    errors = {q: nearest.largest(q) or 0.0 for q in allowed}
    over = {q: errors[q] / limit for q, limit in allowed.items() if errors[q] > limit}
    return Refusal(engine, rule.rule.name, case.settings.steps_per_revolution, errors, over, rejected)
