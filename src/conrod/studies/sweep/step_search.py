"""Search for the coarsest step at which the error of a rule is within given tolerances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from conrod.studies.frame.case import Measurement, Study
from conrod.studies.frame.run import RunCase
from conrod.studies.sweep.prior import USUAL_ORDER
from conrod.studies.sweep.study import RulePlan

# A step is tried at which the error should be this much below what is allowed, so that other runs confirm it.
AIMED_MARGIN = 1.25
STEP_UNIT = 4  # steps per revolution are multiples of this
WORTH = 0.92  # another run for a coarser step has to save this much
LONGEST = 4.0  # from one step to the next one tried
BEYOND = 2.5  # times the most steps of the grid, for what does in the grid and not in a confirming run
STILL, STILL_TRIED = 0.3, 2  # an error of a lower order after more runs does not fall; nor do so many lost runs mend

Tolerances = Mapping[str, float]  # largest normalised error by quantity


@dataclass(frozen=True)
class Tried:
    """A run that a choice rests on."""

    measurement: Measurement

    def errors(self, allowed: Tolerances) -> dict[str, float]:
        """Largest error of each quantity that a tolerance was given for; none unless the run completed."""
        return {q: error for q in allowed if (error := self.measurement.largest(q)) is not None}

    def excess(self, allowed: Tolerances) -> float:
        """Largest error over what is allowed; infinite unless the run completed with numbers."""
        over = [error / allowed[q] for q, error in self.errors(allowed).items()]
        return max(over) if over and not any(map(math.isnan, over)) else math.inf


@dataclass(frozen=True)
class Choice(Tried):
    """A rule of an engine's grid at some step."""

    swept: RulePlan
    case: RunCase

    @property
    def steps(self) -> int:
        """Steps per revolution."""
        return self.case.settings.steps_per_revolution


@dataclass
class StepSearch:
    """Runs of one rule, by increasing steps.

    Attributes:
        start: steps to look at first.
        order: expected of its error.
    """

    rule: RulePlan
    tried: list[Choice]
    start: int = 0
    order: float = USUAL_ORDER

    @property
    def bounds(self) -> tuple[int, int]:
        """Fewest and most steps that are tried: those of the grid."""
        first, last = self.rule.cases[0], self.rule.cases[-1]
        return first.settings.steps_per_revolution, last.settings.steps_per_revolution

    def within(self, allowed: Tolerances) -> list[Choice]:
        """Those within tolerance, the coarsest first."""
        return [one for one in self.tried if one.excess(allowed) <= 1.0]

    def next_steps(self, allowed: Tolerances) -> int | None:
        """Steps to try next, so that the error just does; None where that would gain little, or there is no hope."""
        if not self.tried:
            return self._even(self.start)
        within = self.within(allowed)
        finer = within[0] if within else None
        below = [one for one in self.tried if finer is None or one.steps < finer.steps]
        coarse = below[-1] if below else None
        if finer is None:
            assert coarse is not None
            order = self.order_measured(allowed)
            lost = sum(one.measurement.errors is None for one in self.tried)
            if lost >= STILL_TRIED or (len(self.tried) > STILL_TRIED and order < STILL):
                return None
            wanted = self._even(self._scaled(coarse, allowed, max(order, STILL)))
            return wanted if wanted > coarse.steps else None
        if coarse is None:
            wanted = self._even(self._scaled(finer, allowed, self.order))
        else:
            wanted = self._even(_between(coarse, finer, allowed))
        return wanted if wanted < WORTH * finer.steps else None

    def order_measured(self, allowed: Tolerances) -> float:
        """Order between the two finest runs that completed, the expected one where there are none."""
        last = [(one.steps, x) for one in self.tried if (x := one.excess(allowed)) < math.inf][-2:]
        if len(last) < 2:
            return self.order
        (n, x), (more, less) = last
        return math.log(x / less) / math.log(more / n)

    def _scaled(self, one: Choice, allowed: Tolerances, order: float) -> float:
        factor: float = (max(one.excess(allowed), 1e-30) * AIMED_MARGIN) ** (1.0 / order)
        return one.steps * min(max(factor, 1.0 / LONGEST), LONGEST)

    def _even(self, steps: float) -> int:
        """The next multiple of the unit, within the grid."""
        least, most = self.bounds
        return min(max(STEP_UNIT * math.ceil(steps / STEP_UNIT), least), most)


def _between(coarse: Choice, fine: Choice, allowed: Tolerances) -> float:
    """The steps between the last run that is out and the first one within, at which the error should just do."""
    out, within = (one.excess(allowed) for one in (coarse, fine))
    # Where there is no error to go by: the middle.
    known = math.isfinite(out) and within > 0.0
    share = math.log(out * AIMED_MARGIN) / math.log(out / within) if known else 0.5
    return float(coarse.steps * (fine.steps / coarse.steps) ** share)


def follow(searches: Sequence[StepSearch], allowed: Tolerances, rounds: int) -> Study[None]:
    """Let all searches try their next steps, side by side, so many times."""
    for _ in range(rounds):
        wanted = [(search, n) for search in searches if (n := search.next_steps(allowed)) is not None]
        if not wanted:
            return
        yield from run_at(wanted)


def run_at(wanted: Sequence[tuple[StepSearch, int]]) -> Study[None]:
    """Run searches at numbers of steps per revolution."""
    cases = [
        (search, replace(case, settings=search.rule.rule.settings(case.scene, n)))
        for search, n in wanted
        for case in search.rule.cases[:1]
    ]
    found = yield list({case.key: case for _, case in cases}.values())
    for search, case in cases:
        search.tried = sorted([*search.tried, Choice(found[case.key], search.rule, case)], key=lambda one: one.steps)


def finer_than(search: StepSearch, rejected: Choice, excess: float, allowed: Tolerances) -> Study[Choice | None]:
    """The rule at as many more steps as a confirming run was out by; None where there are none, or it is out."""
    wanted, most = rejected.steps * (excess * AIMED_MARGIN) ** (1.0 / search.order), search.bounds[1]
    most = most if wanted > BEYOND * most else round(BEYOND * most)
    steps = STEP_UNIT * math.ceil(min(wanted, LONGEST * rejected.steps, most) / STEP_UNIT)
    known = [one for one in search.tried if rejected.steps < one.steps <= steps]
    if not known and steps > rejected.steps:
        yield from run_at([(search, steps)])
        known = [one for one in search.tried if one.steps == steps]
    return next((one for one in known if one.excess(allowed) <= 1.0), None)
