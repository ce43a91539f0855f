"""The cheapest setting within given tolerances, confirmed on runs outside the grid."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from conrod.comparison.trajectory import Settings
from conrod.engines.capabilities import MissingCapability, TimedStepping, capability
from conrod.engines.engine import round_settings
from conrod.errors import InvalidInput
from conrod.exact.motion import QUANTITIES
from conrod.execution.case import Study
from conrod.execution.reference_guard import ReferenceGuard
from conrod.execution.run import RunCase
from conrod.execution.timing import Timing
from conrod.execution.tolerances import Limit, UnscaledLimit, check_tolerance, scale_tolerance, scene_scales
from conrod.mechanism.units import check_number
from conrod.scenes import Scene
from conrod.studies.sweep.prior import PriorSweep, ranked_guesses
from conrod.studies.sweep.step_search import (
    Candidate,
    StepSearch,
    Tolerances,
    TriedRun,
    Weights,
    find_finer_candidate,
    refine_searches,
)
from conrod.studies.sweep.study import Clock, RulePlan, SweepPlan, paste_text

MIN_TOLERANCE, MAX_TOLERANCE = 1e-15, 1e6  # of a normalised error
MAX_RUNS_PER_RULE = 6  # rounds of a search before its rules are compared
RULES_PER_WAVE, MAX_WAVES = 6, 3  # rules that are searched side by side, and how many times, if some should suffice
RULES_IF_NONE_SUFFICES = 3  # rules that are searched if none should
MAX_FINER_RUNS = 3  # rejected candidates of a rule after which no finer step of it is tried
# Runs that the grid does not contain.
OTHER_START_ANGLE = math.radians(37.0)  # [rad]
CONFIRMING_REVOLUTIONS = 5.0
CONFIRMING_SPEED_FACTORS = (0.9, 1.1)


@dataclass(frozen=True)
class Confirmation(TriedRun):
    """A run of a candidate outside the grid; `change` says how it differs from the grid's run."""

    change: str


@dataclass(frozen=True)
class RejectedCandidate:
    """A cheaper setting that meets the tolerances, but not in some confirming runs."""

    candidate: Candidate
    failed_confirmations: tuple[Confirmation, ...]


@dataclass(frozen=True)
class Recommendation:
    """The cheapest confirmed setting of one engine.

    Attributes:
        candidate: the setting and its run.
        margin: least ratio of a tolerance to its error.
        timing: cost of the candidate.
        confirmations: runs outside the grid, all within tolerance.
        rejected: cheaper settings that were not confirmed.
        rounded_settings: the settings with the numbers that are pasted.
        paste: the setting as lines for a model or a program; the reason if the engine gives none.
        search_words: sweeps from which the search began, and the number of runs.
        distrust: see `ReferenceGuard`, of all runs that were made.
    """

    candidate: Candidate
    margin: float
    timing: Timing
    confirmations: tuple[Confirmation, ...]
    rejected: tuple[RejectedCandidate, ...]
    rounded_settings: Settings
    paste: str
    search_words: str
    distrust: str = ""


@dataclass(frozen=True)
class NoRecommendation:
    """Answer that no setting of one engine meets the tolerances.

    Attributes:
        nearest: the candidate with the least excess.
        rejected: settings that only confirming runs reject.
        search_words: sweeps from which the search began, and the number of runs.
        reason: why nothing qualifies, if no run completed or none could be timed; else empty.
        distrust: see `ReferenceGuard`, of all runs that were made.
    """

    engine: str
    nearest: Candidate
    rejected: tuple[RejectedCandidate, ...]
    search_words: str
    reason: str = ""
    distrust: str = ""


Answer = Recommendation | NoRecommendation  # of one engine


def check_tolerances(tolerances: Mapping[str, float | str | None]) -> dict[str, Limit]:
    """Return the tolerances that were given, by quantity.

    Raises:
        InvalidInput: no tolerance is given, or one is out of range.
    """
    given = {quantity: value for quantity, value in tolerances.items() if value is not None}
    if not given:
        raise InvalidInput(
            "no tolerance: give at least one of --position, --velocity, --acceleration, e.g. --position 1e-6"
        )
    for quantity, limit in (found := check_tolerance(given, QUANTITIES, "--")).items():
        if not isinstance(limit, UnscaledLimit):
            check_number(f"--{quantity}", limit, MIN_TOLERANCE, MAX_TOLERANCE)
    return found


def recommendation_studies(
    plan: SweepPlan, asked: Mapping[str, Limit], time: Clock, prior: Mapping[str, PriorSweep]
) -> list[Study[Answer]]:
    """Return a study for each engine that finds its cheapest confirmed setting.

    Args:
        plan: the sweep of one scene.
        asked: largest error by quantity.
        time: measures the costs of runs.
        prior: errors and costs of other sweeps, which determine what is tried first.
    """
    engines = dict.fromkeys(rule.engine.name for rule in plan.rules)
    of_engines = [[rule for rule in plan.rules if rule.engine.name == name] for name in engines]
    allowed, weights = scale_tolerance(asked, scene_scales(plan.scene))
    return [_search_with_guard(rules, plan.scene, allowed, weights, time, prior) for rules in of_engines]


def _search_with_guard(
    rules: Sequence[RulePlan],
    scene: Scene,
    allowed: Tolerances,
    weights: Weights,
    time: Clock,
    prior: Mapping[str, PriorSweep],
) -> Study[Answer]:
    """Search an engine's rules, and check all runs against the joints' equations."""
    guard = ReferenceGuard()
    answer = yield from guard.watch(_search_in_waves(rules, scene, allowed, weights, time, prior))
    return replace(answer, distrust=guard.distrust)


def _search_in_waves(
    rules: Sequence[RulePlan],
    scene: Scene,
    allowed: Tolerances,
    weights: Weights,
    time: Clock,
    prior: Mapping[str, PriorSweep],
) -> Study[Answer]:
    """Search the rules in waves, the cheapest expected first, until a setting is confirmed."""
    ranked = ranked_guesses(rules, scene, allowed, prior)
    sufficient = [guess for guess in ranked if math.isfinite(guess.cost)]
    guesses = sufficient[: MAX_WAVES * RULES_PER_WAVE] or ranked[:RULES_IF_NONE_SUFFICES]
    machines = " and ".join(dict.fromkeys(guess.machine for guess in guesses if guess.machine)) or "no machine like it"
    answer: Answer | None = None
    searches = list[StepSearch]()
    for first in range(0, len(guesses), RULES_PER_WAVE):
        wave = [StepSearch(g.rule, [], g.steps, g.order, weights) for g in guesses[first : first + RULES_PER_WAVE]]
        searches += wave
        yield from refine_searches(wave, allowed, rounds=MAX_RUNS_PER_RULE)
        count = sum(len(search.candidates) for search in searches)
        search_words = f"from the shipped sweeps of {machines}, by {count} run{'' if count == 1 else 's'}"
        answer = yield from _cheapest_confirmed(wave, allowed, time, search_words, answer)
        if isinstance(answer, Recommendation):
            return answer
    assert answer is not None
    return answer


def _cheapest_confirmed(
    searches: Sequence[StepSearch], allowed: Tolerances, time: Clock, search_words: str, previous: Answer | None
) -> Study[Answer]:
    """Return the cheapest confirmed candidate of a wave, or the reasons why no candidate is confirmed.

    These include the reasons of the previous wave.
    """
    found = [(search, one) for search in searches for one in search.candidates_within(allowed)[:1]]
    waiting = {one.case.key: (search, one) for search, one in found}
    timings = dict(time([one.case for _, one in waiting.values()]))
    rejected: list[RejectedCandidate] = []
    # A candidate without a timing cannot be called the cheapest.
    while timings and (waiting := {key: c for key, c in waiting.items() if key in timings}):
        search, candidate = waiting.pop(min(waiting, key=lambda key: timings[key].ratio))
        confirmations = yield from _run_confirmations(candidate)
        failed = tuple(one for one in confirmations if one.excess(allowed) > 1.0)
        if not failed:
            rounded = round_settings(candidate.case.scene, candidate.case.settings)
            return Recommendation(
                candidate=candidate,
                margin=1.0 / max(candidate.excess(allowed), 1e-300),
                timing=timings[candidate.case.key],
                confirmations=confirmations,
                rejected=tuple(rejected),
                rounded_settings=rounded,
                paste=paste_text(candidate.rule_plan.engine, candidate.case.scene, rounded),
                search_words=search_words,
            )
        rejected.append(RejectedCandidate(candidate, failed))
        if sum(one.candidate.rule_plan is search.rule for one in rejected) <= MAX_FINER_RUNS:
            excess = max(one.excess(allowed) for one in failed)
            finer = yield from find_finer_candidate(search, candidate, excess, allowed)
            if finer and finer.case.key not in waiting:
                waiting[finer.case.key] = search, finer
                timings |= time([finer.case])
    nearest = min((one for search in searches for one in search.candidates), key=lambda one: one.excess(allowed))
    if isinstance(previous, NoRecommendation):
        nearest = min(previous.nearest, nearest, key=lambda one: one.excess(allowed))
        rejected = [*previous.rejected, *rejected]
    reason = ""
    if nearest.result.errors is None:
        reason = ": ".join(filter(None, ("no run completed", nearest.result.reason)))
    elif found and not timings:
        clock = capability(searches[0].rule.engine, TimedStepping)
        untimed = "nothing within the tolerances could be timed"
        reason = clock.reason if isinstance(clock, MissingCapability) else untimed
    return NoRecommendation(nearest.rule_plan.engine.name, nearest, tuple(rejected), search_words, reason)


# -- confirmation ----------------------------------------------------------------------------------------------------


def _run_confirmations(candidate: Candidate) -> Study[tuple[Confirmation, ...]]:
    """Run the confirming cases of a candidate."""
    cases = dict(confirming_cases(candidate.rule_plan, candidate.case))
    found = yield list(cases.values())
    return tuple(Confirmation(found[case.key], change, weights=candidate.weights) for change, case in cases.items())


def confirming_cases(rule_plan: RulePlan, case: RunCase) -> Iterator[tuple[str, RunCase]]:
    """Yield runs outside the grid, each with its difference from the grid's run in words.

    These are: the settings as pasted, another start angle, more revolutions, other speeds. An input that makes one pass
    has only one start angle and length; it makes the pass backwards instead.
    """
    yield "as pasted", replace(case, settings=round_settings(case.scene, case.settings))
    speeds = {f"speed {factor - 1.0:+.0%}": factor for factor in CONFIRMING_SPEED_FACTORS}
    if case.scene.kinematics.mechanism.driver.span is None:
        yield "start at 37 deg", replace(case, start_angle=OTHER_START_ANGLE)
        yield "five revolutions", replace(case, revolutions=CONFIRMING_REVOLUTIONS)
    else:
        speeds = {"the pass backwards": -1.0, **speeds}
    for change, factor in speeds.items():
        scene = case.scene.with_parameters(speed=factor * case.scene.speed)
        yield change, RunCase(case.name, scene, rule_plan.rule.settings(scene, case.settings.steps_per_revolution))
