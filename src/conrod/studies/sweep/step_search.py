"""Search for the coarsest step at which the error of a rule is within given tolerances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from conrod.execution.case import Study
from conrod.execution.run import RunCase, RunResult
from conrod.studies.sweep.prior import DEFAULT_ORDER
from conrod.studies.sweep.study import RulePlan

# Steps are chosen so that the error should be this many times below what is allowed, so that other runs confirm it.
TARGET_MARGIN = 1.25
STEPS_MULTIPLE = 4  # steps per revolution are multiples of this
MAX_STEPS_RATIO = 0.92  # a run with fewer steps is made if these are at most this share of the fewest that suffice
MAX_STEPS_FACTOR = 4.0  # from one number of steps to the next that is tried
# Over the most steps of the grid: tried after a setting that met the tolerances there and in a confirming run did not.
MAX_STEPS_OVER_GRID = 2.5
STAGNANT_ORDER = 0.3  # an error of a lower order between the two finest runs does not fall
MAX_FAILED_RUNS = 2  # a rule is given up after as many runs that did not complete

Tolerances = Mapping[str, float]  # largest normalised error by quantity
Weights = Mapping[str, Mapping[str, float]]  # of errors, by quantity and point


@dataclass(frozen=True)
class TriedRun:
    """A measured run that is compared with tolerances.

    Attributes:
        weights: for tolerances given in units, the weight of each point's error (`scale_tolerance`).
    """

    result: RunResult
    weights: Weights = field(default_factory=dict, kw_only=True)

    def errors(self, allowed: Tolerances) -> dict[str, float]:
        """Largest error of each quantity with a tolerance; empty unless the run completed."""
        return {q: error for q in allowed if (error := self._largest(q)) is not None}

    def _largest(self, quantity: str) -> float | None:
        if quantity not in self.weights:
            return self.result.largest(quantity)
        found = list(self.point_errors(quantity).values())
        return float(np.max(found)) if found else None

    def point_errors(self, quantity: str) -> dict[str, float]:
        """Largest error of a quantity by point, times its weight; empty unless the run completed."""
        weights = self.weights.get(quantity, {})
        sizes = ((point, errors[quantity]) for point, errors in (self.result.errors or {}).items())
        return {point: size["max"] * weights.get(point, 1.0) for point, size in sizes if size is not None}

    def excess(self, allowed: Tolerances) -> float:
        """Largest ratio of an error to its tolerance; infinite unless all errors are known."""
        over = [error / allowed[q] for q, error in self.errors(allowed).items()]
        return max(over) if over and not any(map(math.isnan, over)) else math.inf


@dataclass(frozen=True)
class Candidate(TriedRun):
    """A rule of an engine's grid at a number of steps per revolution, and its run."""

    rule_plan: RulePlan
    case: RunCase

    @property
    def steps(self) -> int:
        """Steps per revolution."""
        return self.case.settings.steps_per_revolution


@dataclass
class StepSearch:
    """Search for the fewest steps per revolution at which a rule meets tolerances.

    Attributes:
        rule: the rule that is searched.
        candidates: runs so far, by increasing steps.
        start: steps per revolution to try first.
        order: expected order of the error in the step.
        weights: as in `TriedRun`.
    """

    rule: RulePlan
    candidates: list[Candidate]
    start: int = 0
    order: float = DEFAULT_ORDER
    weights: Weights = field(default_factory=dict)

    @property
    def steps_bounds(self) -> tuple[int, int]:
        """Fewest and most steps per revolution of the grid."""
        first, last = self.rule.cases[0], self.rule.cases[-1]
        return first.settings.steps_per_revolution, last.settings.steps_per_revolution

    def candidates_within(self, allowed: Tolerances) -> list[Candidate]:
        """Candidates within tolerance, the coarsest first."""
        return [one for one in self.candidates if one.excess(allowed) <= 1.0]

    def next_steps(self, allowed: Tolerances) -> int | None:
        """Return the steps to try next so that the error just suffices, None to stop the search."""
        if not self.candidates:
            return self._round_to_grid(self.start)
        within = self.candidates_within(allowed)
        finer = within[0] if within else None
        below = [one for one in self.candidates if finer is None or one.steps < finer.steps]
        coarse = below[-1] if below else None
        if finer is None:
            assert coarse is not None
            order = self.measured_order(allowed)
            failed = sum(one.result.errors is None for one in self.candidates)
            stagnant = len(self.candidates) > MAX_FAILED_RUNS and order < STAGNANT_ORDER
            if failed >= MAX_FAILED_RUNS or stagnant:
                return None
            steps = self._round_to_grid(self._steps_by_order(coarse, allowed, max(order, STAGNANT_ORDER)))
            return steps if steps > coarse.steps else None
        if coarse is None:
            steps = self._round_to_grid(self._steps_by_order(finer, allowed, self.order))
        else:
            steps = self._round_to_grid(_interpolated_steps(coarse, finer, allowed))
        return steps if steps < MAX_STEPS_RATIO * finer.steps else None

    def measured_order(self, allowed: Tolerances) -> float:
        """Order p = log(e1 / e2) / log(n2 / n1) of the two finest completed runs.

        It is the expected order if there are not two.
        """
        last = [(one.steps, x) for one in self.candidates if (x := one.excess(allowed)) < math.inf][-2:]
        if len(last) < 2:
            return self.order
        (n, x), (more, less) = last
        return math.log(x / less) / math.log(more / n)

    def _steps_by_order(self, candidate: Candidate, allowed: Tolerances, order: float) -> float:
        """Steps n (e TARGET_MARGIN)^(1 / order) at which a candidate's excess e would just suffice."""
        factor: float = (max(candidate.excess(allowed), 1e-30) * TARGET_MARGIN) ** (1.0 / order)
        return candidate.steps * min(max(factor, 1.0 / MAX_STEPS_FACTOR), MAX_STEPS_FACTOR)

    def _round_to_grid(self, steps: float) -> int:
        """Round steps up to a multiple of STEPS_MULTIPLE, within the grid."""
        least, most = self.steps_bounds
        return min(max(STEPS_MULTIPLE * math.ceil(steps / STEPS_MULTIPLE), least), most)


def _interpolated_steps(coarse: Candidate, fine: Candidate, allowed: Tolerances) -> float:
    """Steps between a run out of tolerance and one within, where the error should just suffice."""
    out, within = (one.excess(allowed) for one in (coarse, fine))
    # Geometric mean of the steps if one of the errors is unknown or zero.
    known = math.isfinite(out) and within > 0.0
    share = math.log(out * TARGET_MARGIN) / math.log(out / within) if known else 0.5
    return float(coarse.steps * (fine.steps / coarse.steps) ** share)


def refine_searches(searches: Sequence[StepSearch], allowed: Tolerances, rounds: int) -> Study[None]:
    """Run all searches at their next steps, side by side, for at most a number of rounds."""
    for _ in range(rounds):
        wanted = [(search, n) for search in searches if (n := search.next_steps(allowed)) is not None]
        if not wanted:
            return
        yield from run_searches(wanted)


def run_searches(wanted: Sequence[tuple[StepSearch, int]]) -> Study[None]:
    """Run each search at a number of steps per revolution, and add the candidates."""
    cases = [
        (search, replace(case, settings=search.rule.rule.settings(case.scene, n)))
        for search, n in wanted
        for case in search.rule.cases[:1]
    ]
    found = yield list({case.key: case for _, case in cases}.values())
    for search, case in cases:
        candidates = [*search.candidates, Candidate(found[case.key], search.rule, case, weights=search.weights)]
        search.candidates = sorted(candidates, key=lambda one: one.steps)


def find_finer_candidate(
    search: StepSearch, rejected: Candidate, excess: float, allowed: Tolerances
) -> Study[Candidate | None]:
    """Return a candidate with more steps than a rejected one, None if none is in tolerance.

    Args:
        search: the search of the rule.
        rejected: the candidate that the confirming run rejected.
        excess: largest ratio of an error to its tolerance in the confirming run.
        allowed: the tolerances.
    """
    wanted, most = rejected.steps * (excess * TARGET_MARGIN) ** (1.0 / search.order), search.steps_bounds[1]
    most = most if wanted > MAX_STEPS_OVER_GRID * most else round(MAX_STEPS_OVER_GRID * most)
    steps = STEPS_MULTIPLE * math.ceil(min(wanted, MAX_STEPS_FACTOR * rejected.steps, most) / STEPS_MULTIPLE)
    known = [one for one in search.candidates if rejected.steps < one.steps <= steps]
    if not known and steps > rejected.steps:
        yield from run_searches([(search, steps)])
        known = [one for one in search.candidates if one.steps == steps]
    return next((one for one in known if one.excess(allowed) <= 1.0), None)
