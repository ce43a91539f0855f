"""Engines at equal error: every preset at the fewest steps that keep its errors below a bar, and the cost of that."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

from conrod.studies.frame.case import Study
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.findings import SweepStudy
from conrod.studies.sweep.step_search import Choice, StepSearch, Tolerances, follow
from conrod.studies.sweep.study import Clock, SweepPlan, sweep_study

BARS = (1e-3, 1e-6, 1e-9)
KEPT = tuple(QUANTITIES[: k + 1] for k in range(len(QUANTITIES)))  # position; and velocity; and acceleration
TARGETS: tuple[Tolerances, ...] = tuple(dict.fromkeys(kept, bar) for kept, bar in product(KEPT, BARS))
MOST_STEPS = 100_000  # a revolution: runs of ten seconds
ROUNDS, MARGIN = 6, 1.05


def sweep_presets(plan: SweepPlan, time: Clock) -> Study[SweepStudy]:
    """The study of a plan of presets: the runs of its grid, then at each target the fewest steps, to a seventh.

    Args:
        time: takes costs, after all runs, of those of the grid and of those that are the coarsest within a target.
    """
    runs = dict((yield plan.cases))
    searches = [
        StepSearch(rule, [Choice(runs[case.key], rule, case) for case in rule.cases], most=MOST_STEPS, margin=MARGIN)
        for rule in plan.rules
    ]
    for target in TARGETS:
        yield from follow([one for one in searches if is_hopeful(one, target)], target, ROUNDS)
    runs |= {one.case.key: one.measurement for search in searches for one in search.tried}
    coarsest = [one.case for search in searches for target in TARGETS for one in search.within(target)[:1]]
    timed = {case.key: case for case in (*plan.cases, *coarsest) if runs[case.key].errors is not None}
    found = tuple(replace(one.rule, refined=tuple(choice.case for choice in one.tried)) for one in searches)
    timings = time(sorted(timed.values(), key=lambda case: case.settings.steps_per_revolution))
    return sweep_study(replace(plan, rules=found), runs, timings)


def is_hopeful(search: StepSearch, allowed: Tolerances) -> bool:
    """True if the tolerances are met, or will be within the most steps at the order of the two finest runs."""
    order, finest = search.order_measured(allowed), search.tried[-1]
    if search.within(allowed):
        return True
    # In logarithms: at an order near 0 the steps that would be needed have no float.
    return math.log(finest.excess(allowed)) <= order * math.log(MOST_STEPS / finest.steps)
