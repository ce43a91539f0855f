"""The cheapest setting within given tolerances, confirmed on runs that the grid does not contain."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from conrod.engines.capabilities import Lacking, Pasted, Timed, capability
from conrod.engines.engine import STOCK
from conrod.errors import InvalidInput
from conrod.mechanism.units import check_number
from conrod.studies.frame.case import Results, Study
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing
from conrod.studies.sweep.study import Clock, RulePlan, SweepPlan

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


@dataclass(frozen=True)
class Tried:
    """A run that a choice rests on."""

    measurement: Measurement

    def errors(self, allowed: Tolerances) -> dict[str, float]:
        """Largest error of each quantity that a tolerance was given for; none unless the run completed."""
        return {q: error for q in allowed if (error := self.measurement.largest(q)) is not None}

    def excess(self, allowed: Tolerances) -> float:
        """Largest error over what is allowed; infinite unless the run completed."""
        return max((error / allowed[q] for q, error in self.errors(allowed).items()), default=math.inf)


@dataclass(frozen=True)
class Choice(Tried):
    """A setting of an engine's grid, or between two of its steps."""

    swept: RulePlan
    case: RunCase

    @property
    def steps(self) -> int:
        """Steps per revolution."""
        return self.case.settings.steps_per_revolution


@dataclass(frozen=True)
class Confirmation(Tried):
    """A run that the grid does not contain, and what is other about it."""

    what: str


@dataclass(frozen=True)
class Rejected:
    """A cheaper setting that the grid's runs allow and a confirming run does not."""

    choice: Choice
    why: tuple[Confirmation, ...]


@dataclass(frozen=True)
class Savings:
    """A setting beside the stock ones at all steps of the grid, by quantity where it is a mapping.

    Attributes:
        digits: decimal digits gained at equal cost; None where no stock run is as cheap as this.
        best: least error that any stock run reaches; empty where none completed.
        cost_factor: cost of the cheapest stock run within all tolerances over this one's; None where there is none.
    """

    digits: Mapping[str, float | None]
    best: Mapping[str, float]
    cost_factor: float | None


@dataclass(frozen=True)
class Recommendation:
    """The cheapest confirmed setting of one engine.

    Attributes:
        margin: least of allowed over found.
        paste: the setting as lines for a model or a program; the reason where the engine gives none.
    """

    choice: Choice
    margin: float
    timing: Timing
    confirmations: tuple[Confirmation, ...]
    rejected: tuple[Rejected, ...]
    savings: Savings
    paste: str


@dataclass(frozen=True)
class Refusal:
    """No setting of one engine qualifies.

    Attributes:
        nearest: of the grid.
        rejected: settings that the grid allows.
        why: in words where nothing completed, or could be timed.
    """

    engine: str
    nearest: Choice
    rejected: tuple[Rejected, ...]
    why: str = ""


Answer = Recommendation | Refusal


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


def _for_engine(rules: Sequence[RulePlan], measured: Results, allowed: Tolerances, time: Clock) -> Study[Answer]:
    grid = [[Choice(measured[case.key], rule, case) for case in rule.cases] for rule in rules]
    found = yield from _candidates(grid, allowed)
    waiting = {candidate.case.key: candidate for candidate in found}
    timings = dict(time([candidate.case for candidate in waiting.values()]))
    rejected: list[Rejected] = []
    # What cannot be timed cannot be called the cheapest.
    while timings and (waiting := {key: c for key, c in waiting.items() if key in timings}):
        candidate = waiting.pop(min(waiting, key=lambda key: timings[key].ratio))
        confirmations = yield from _confirmed(candidate)
        lost = tuple(one for one in confirmations if one.excess(allowed) > 1.0)
        if not lost:
            return _recommendation(candidate, grid, allowed, time, confirmations, tuple(rejected))
        rejected.append(Rejected(candidate, lost))
        # The next finer step of the same rule that the grid has within tolerance.
        own = next(choices for choices in grid if choices[0].swept is candidate.swept)
        finer = [one for one in own if one.steps > candidate.steps and one.excess(allowed) <= 1.0]
        if finer and finer[0].case.key not in waiting:
            waiting[finer[0].case.key] = finer[0]
            timings |= time([finer[0].case])
    nearest, why = min((one for own in grid for one in own), key=lambda one: one.excess(allowed)), ""
    if nearest.measurement.errors is None:
        why = "no run of the grid completed"
    elif found and not timings:
        clock = capability(rules[0].engine, Timed)
        why = clock.reason if isinstance(clock, Lacking) else "nothing within the tolerances could be timed"
    return Refusal(rules[0].engine.name, nearest, tuple(rejected), why)


# -- candidates ------------------------------------------------------------------------------------------------------


def _candidates(grid: Sequence[Sequence[Choice]], allowed: Tolerances) -> Study[list[Choice]]:
    """The coarsest step of each rule that is within tolerance: of the grid, or better between two of the grid."""
    of_grid, between = list[Choice](), dict[str, tuple[RulePlan, RunCase]]()
    for own in grid:
        k = next((k for k, one in enumerate(own) if one.excess(allowed) <= 1.0), None)
        if k is None:
            continue
        of_grid.append(own[k])
        if k > 0 and (case := _between(own[k - 1], own[k], allowed)) is not None:
            between[case.key] = (own[k].swept, case)
    found = (yield [case for _, case in between.values()]) if between else {}
    tried = [Choice(found[key], swept, case) for key, (swept, case) in between.items()]
    return [*of_grid, *(one for one in tried if one.excess(allowed) <= 1.0)]


def _between(coarse: Choice, fine: Choice, allowed: Tolerances) -> RunCase | None:
    """The step between the last one that is out and the first one within, at which the error should just do."""
    out, within = (one.excess(allowed) for one in (coarse, fine))
    if not math.isfinite(out) or within <= 0.0:
        return None
    share = math.log(out * AIMED_MARGIN) / math.log(out / within)
    steps = STEP_UNIT * math.ceil(coarse.steps * (fine.steps / coarse.steps) ** share / STEP_UNIT)
    if not coarse.steps < steps < fine.steps:
        return None
    return replace(fine.case, settings=fine.swept.rule.settings(fine.case.scene, steps))


# -- confirmation ----------------------------------------------------------------------------------------------------


def _confirmed(candidate: Choice) -> Study[tuple[Confirmation, ...]]:
    cases = dict(confirming_cases(candidate.swept, candidate.case))
    found = yield list(cases.values())
    return tuple(Confirmation(found[case.key], what) for what, case in cases.items())


def confirming_cases(swept: RulePlan, case: RunCase) -> Iterator[tuple[str, RunCase]]:
    """Runs that the grid does not contain: another start, more revolutions, other speeds.

    An input that makes one pass has one start and one length of a run: it makes the pass backwards instead.
    """
    speeds = {f"speed {factor - 1.0:+.0%}": factor for factor in OTHER_SPEEDS}
    if case.scene.kinematics.mechanism.driver.span is None:
        yield "start at 37 deg", replace(case, start_angle=OTHER_START)
        yield "five revolutions", replace(case, revolutions=MORE_REVOLUTIONS)
    else:
        speeds = {"the pass backwards": -1.0, **speeds}
    for what, factor in speeds.items():
        scene = case.scene.with_parameters(speed=factor * case.scene.speed)
        yield what, RunCase(case.name, scene, swept.rule.settings(scene, case.settings.steps_per_revolution))


# -- results ---------------------------------------------------------------------------------------------------------


def _recommendation(
    choice: Choice,
    grid: Sequence[Sequence[Choice]],
    allowed: Tolerances,
    time: Clock,
    confirmations: tuple[Confirmation, ...],
    rejected: tuple[Rejected, ...],
) -> Recommendation:
    stock = [one for own in grid for one in own if one.case.settings.preset == STOCK and one.measurement.errors]
    timings = time([*(one.case for one in stock), choice.case])
    pasted = capability(choice.swept.engine, Pasted)
    return Recommendation(
        choice=choice,
        margin=1.0 / max(choice.excess(allowed), 1e-300),
        timing=timings[choice.case.key],
        confirmations=confirmations,
        rejected=rejected,
        savings=savings_of(choice, stock, timings, allowed),
        paste=f"# {pasted.reason}"
        if isinstance(pasted, Lacking)
        else pasted.paste(choice.case.scene, choice.case.settings),
    )


def savings_of(choice: Choice, stock: Sequence[Choice], timings: Mapping[str, Timing], allowed: Tolerances) -> Savings:
    """A timed setting beside completed stock runs; those without a timing do not count."""
    cost, own = timings[choice.case.key].seconds_per_revolution, choice.errors(allowed)
    timed = [(timings[one.case.key].seconds_per_revolution, one) for one in stock if one.case.key in timings]
    within = [c for c, one in timed if one.excess(allowed) <= 1.0]
    errors = {q: sorted((c, one.errors(allowed)[q]) for c, one in timed) for q in allowed}
    return Savings(
        digits={q: _digits(errors[q], cost, own[q]) for q in allowed},
        best={q: min(error for _, error in errors[q]) for q in allowed if timed},
        cost_factor=min(within) / cost if within else None,
    )


def _digits(stock: Sequence[tuple[float, float]], cost: float, error: float) -> float | None:
    """Decimal digits between the stock error at a cost, interpolated between (cost, error), and an error."""
    if not stock or cost < stock[0][0] or error <= 0.0:
        return None
    costs, errors = (np.log([max(p[k], 1e-300) for p in stock]) for k in (0, 1))
    return float(np.interp(math.log(cost), costs, errors) - math.log(error)) / math.log(10.0)
