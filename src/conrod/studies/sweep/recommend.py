"""The cheapest setting within given tolerances, confirmed on runs that the grid does not contain."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from conrod.engines.capabilities import MissingCapability, TimedStepping, capability
from conrod.engines.engine import round_settings
from conrod.errors import InvalidInput
from conrod.mechanism.units import check_number
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.case import Study
from conrod.studies.frame.reference_guard import ReferenceGuard
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing
from conrod.studies.sweep.prior import Swept, guesses
from conrod.studies.sweep.step_search import Choice, StepSearch, Tolerances, Tried, finer_than, follow
from conrod.studies.sweep.study import Clock, RulePlan, SweepPlan, paste_of

LARGEST_TOLERANCE = 1e6
SMALLEST_TOLERANCE = 1e-15
ROUNDS = 6
WAVE, WAVES = 6, 3  # rules tried at once, and how often, where some should do
FORLORN = 3  # and where none should
MOST_FINER = 3  # steps that one rule is tried at after a rejection
# Runs that the grid does not contain.
OTHER_START = math.radians(37.0)
MORE_REVOLUTIONS = 5.0
OTHER_SPEEDS = (0.9, 1.1)


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
class Recommendation:
    """The cheapest confirmed setting of one engine.

    Attributes:
        margin: least of allowed over found.
        pasted: the settings of the paste.
        paste: the setting as lines for a model or a program; the reason where the engine gives none.
        how: where the search began, and what else there is to try.
        distrust: see `ReferenceGuard`, of all runs that were made.
    """

    choice: Choice
    margin: float
    timing: Timing
    confirmations: tuple[Confirmation, ...]
    rejected: tuple[Rejected, ...]
    pasted: Settings
    paste: str
    how: str
    distrust: str = ""


@dataclass(frozen=True)
class Refusal:
    """No setting of one engine qualifies.

    Attributes:
        nearest: of those that were tried.
        rejected: settings that only confirming runs do not allow.
        how: as of a recommendation.
        why: in words where nothing completed, or could be timed.
        distrust: as of a recommendation; see `ReferenceGuard`, of all runs that were made.
    """

    engine: str
    nearest: Choice
    rejected: tuple[Rejected, ...]
    how: str
    why: str = ""
    distrust: str = ""


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


def recommend_for(plan: SweepPlan, allowed: Tolerances, time: Clock, prior: Mapping[str, Swept]) -> list[Study[Answer]]:
    """For each engine of the plan a study that finds its cheapest confirmed setting, or what is nearest.

    Args:
        plan: of the sweep of one scene.
        allowed: largest error by quantity.
        time: takes costs.
        prior: errors and costs of other sweeps, which say what is tried.
    """
    engines = dict.fromkeys(rule.engine.name for rule in plan.rules)
    of_engines = [[rule for rule in plan.rules if rule.engine.name == name] for name in engines]
    return [_guarded(_searched(rules, plan.scene, allowed, time, prior)) for rules in of_engines]


def _guarded(search: Study[Answer]) -> Study[Answer]:
    """Pursue the search of an engine, and have all its runs checked against the joints' equations."""
    guard = ReferenceGuard()
    answer = yield from guard.watch(search)
    return replace(answer, distrust=guard.distrust)


def _searched(
    rules: Sequence[RulePlan], scene: Scene, allowed: Tolerances, time: Clock, prior: Mapping[str, Swept]
) -> Study[Answer]:
    """Waves of the rules that are cheapest by the prior, until one of a wave qualifies."""
    ranked = guesses(rules, scene, allowed, prior)
    hopeful = [guess for guess in ranked if math.isfinite(guess.cost)][: WAVES * WAVE] or ranked[:FORLORN]
    machines = " and ".join(dict.fromkeys(guess.machine for guess in hopeful if guess.machine)) or "no machine like it"
    answer: Answer | None = None
    done = list[StepSearch]()
    for first in range(0, len(hopeful), WAVE):
        done += (wave := [StepSearch(g.rule, [], g.steps, g.order) for g in hopeful[first : first + WAVE]])
        yield from follow(wave, allowed, rounds=ROUNDS)
        tried = sum(len(search.tried) for search in done)
        how = f"from the shipped sweeps of {machines}, by {tried} run{'' if tried == 1 else 's'}"
        answer = yield from _answer(wave, allowed, time, how, answer)
        if isinstance(answer, Recommendation):
            return answer
    assert answer is not None
    return answer


def _answer(
    searches: Sequence[StepSearch], allowed: Tolerances, time: Clock, how: str, before: Answer | None
) -> Study[Answer]:
    """The cheapest of the searches that runs elsewhere confirm, or a refusal, with that of a wave before."""
    found = [(search, one) for search in searches for one in search.within(allowed)[:1]]
    waiting = {one.case.key: (search, one) for search, one in found}
    timings = dict(time([one.case for _, one in waiting.values()]))
    rejected: list[Rejected] = []
    # What cannot be timed cannot be called the cheapest.
    while timings and (waiting := {key: c for key, c in waiting.items() if key in timings}):
        search, candidate = waiting.pop(min(waiting, key=lambda key: timings[key].ratio))
        confirmations = yield from _confirmed(candidate)
        lost = tuple(one for one in confirmations if one.excess(allowed) > 1.0)
        if not lost:
            pasted = round_settings(candidate.case.scene, candidate.case.settings)
            return Recommendation(
                choice=candidate,
                margin=1.0 / max(candidate.excess(allowed), 1e-300),
                timing=timings[candidate.case.key],
                confirmations=confirmations,
                rejected=tuple(rejected),
                pasted=pasted,
                paste=paste_of(candidate.swept.engine, candidate.case.scene, pasted),
                how=how,
            )
        rejected.append(Rejected(candidate, lost))
        if sum(one.choice.swept is search.rule for one in rejected) <= MOST_FINER:
            finer = yield from finer_than(search, candidate, max(one.excess(allowed) for one in lost), allowed)
            if finer and finer.case.key not in waiting:
                waiting[finer.case.key] = search, finer
                timings |= time([finer.case])
    nearest, why = min((one for own in searches for one in own.tried), key=lambda one: one.excess(allowed)), ""
    if isinstance(before, Refusal):
        nearest = min(before.nearest, nearest, key=lambda one: one.excess(allowed))
        rejected = [*before.rejected, *rejected]
    if nearest.measurement.errors is None:
        why = ": ".join(filter(None, ("no run completed", nearest.measurement.reason)))
    elif found and not timings:
        clock = capability(searches[0].rule.engine, TimedStepping)
        why = clock.reason if isinstance(clock, MissingCapability) else "nothing within the tolerances could be timed"
    return Refusal(nearest.swept.engine.name, nearest, tuple(rejected), how, why)


# -- confirmation ----------------------------------------------------------------------------------------------------


def _confirmed(candidate: Choice) -> Study[tuple[Confirmation, ...]]:
    cases = dict(confirming_cases(candidate.swept, candidate.case))
    found = yield list(cases.values())
    return tuple(Confirmation(found[case.key], what) for what, case in cases.items())


def confirming_cases(swept: RulePlan, case: RunCase) -> Iterator[tuple[str, RunCase]]:
    """Runs that the grid does not contain: the settings as pasted, another start, more revolutions, other speeds.

    An input that makes one pass has one start and one length of a run: it makes the pass backwards instead.
    """
    yield "as pasted", replace(case, settings=round_settings(case.scene, case.settings))
    speeds = {f"speed {factor - 1.0:+.0%}": factor for factor in OTHER_SPEEDS}
    if case.scene.kinematics.mechanism.driver.span is None:
        yield "start at 37 deg", replace(case, start_angle=OTHER_START)
        yield "five revolutions", replace(case, revolutions=MORE_REVOLUTIONS)
    else:
        speeds = {"the pass backwards": -1.0, **speeds}
    for what, factor in speeds.items():
        scene = case.scene.with_parameters(speed=factor * case.scene.speed)
        yield what, RunCase(case.name, scene, swept.rule.settings(scene, case.settings.steps_per_revolution))
