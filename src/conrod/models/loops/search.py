"""Search for the cheapest settings that hold a tolerance: each at the largest step, by powers of two of the file's own.

A setting holds if the driven run is within the tolerance, and if the file runs with it and its own actuators as well as
it does as it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial

from conrod.comparison.trajectory import Outcome
from conrod.execution.paired_timing import PairedTiming
from conrod.mjcf.loop_results import OWN, LoopRun, SettingsSearch, ShippedRun, loop_limits

Trial = tuple[LoopRun, ShippedRun]
# A setting whose error falls by less than this power of the step is not tried at finer steps.
MIN_ORDER = 0.3


def search_settings(
    run_at: Callable[[str, float], Trial],
    timing_of: Callable[[str], PairedTiming],
    guesses: Mapping[str, int],
    allowed: Mapping[str, float],
    step: float,
    limits: tuple[int, int],
    *,
    must_run: bool,
) -> SettingsSearch:
    """Search settings for the cheapest that hold a tolerance.

    Args:
        run_at: makes the driven run and the file's own run with the settings of a name, at a step [s].
        timing_of: cost of a step with the settings of a name, over one with the model's own.
        guesses: names of the settings in the order in which they are tried, each with the power of two of the step at
            which its search begins.
        allowed: tolerance by quantity [SI].
        step: the model's own [s].
        limits: least and greatest power of two of the own step.
        must_run: whether the file has to run with the settings and its own actuators.
    """
    tried, best, cost, speeds = dict[tuple[str, int], Trial](), None, math.inf, (0.0, 0.0)

    @cache
    def excess(name: str, power: int) -> float:
        tried[name, power] = run_at(name, step * 2.0**power)
        return _excess(*tried[name, power], allowed, must_run)

    for name, guess in guesses.items():
        timing = timing_of(name)
        share = 1.0 if name == OWN else timing.ratio
        # A setting that is not the cheapest so far has to hold at a larger step.
        least = limits[0] if best is None else max(limits[0], math.floor(math.log2(share / cost)) + 1)
        if least > limits[1]:
            continue
        found = _largest_power(partial(excess, name), max(guess, least), (least, limits[1]))
        if found is not None:
            best, cost = (name, found), share / 2.0**found
            speeds = step * 2.0**found / timing.seconds, step / timing.other_seconds
    ran = [run.timestep for run, _ in tried.values()]
    searched = SettingsSearch(dict(allowed), tuple(guesses), (min(ran), max(ran)))
    if best is None:
        within = [key for key in tried if math.isfinite(excess(*key))]
        return replace(searched, nearest=tried[min(within, key=lambda key: excess(*key))][0]) if within else searched
    run, shipped = tried[best]
    name, power = best
    beyond = tried.get((name, power + 1))
    return replace(
        searched,
        best=replace(run, cost=cost),
        shipped=shipped,
        coarser=None if beyond is None else replace(beyond[0], cost=0.5 * cost),
        coarser_shipped=None if beyond is None else beyond[1],
        speed=speeds[0],
        own_speed=speeds[1],
    )


def _excess(run: LoopRun, shipped: ShippedRun, allowed: Mapping[str, float], must_run: bool) -> float:
    """Largest error over its limit; infinite where the driven run, or a run that must complete, did not complete."""
    if run.outcome is not Outcome.COMPLETED or (must_run and shipped.failed):
        return math.inf
    shares = [run.judged_error(name) / limit if limit else math.inf for name, limit in loop_limits(allowed).items()]
    return math.inf if any(math.isnan(share) for share in shares) else max(shares)


def _largest_power(excess: Callable[[int], float], first: int, limits: tuple[int, int]) -> int | None:
    """Find the largest power of two of the step whose excess is at most 1; None if no step holds.

    Smaller steps are predicted by the order that the last two show, excess = c h^p; larger ones are tried one by one.
    """
    (least, most), power = limits, min(first, limits[1])
    failed = dict[int, float]()
    while not (over := excess(power)) <= 1.0:
        before, failed[power] = failed.get(power + 1, math.inf), over
        fall = 1
        if math.isfinite(before) and math.isfinite(over):
            if (order := math.log2(before / over)) < MIN_ORDER:
                return None
            fall = max(1, math.ceil(math.log2(over) / order - 1e-9))
        if power == least:
            return None
        power = max(power - fall, least)
    while power < most and power + 1 not in failed and excess(power + 1) <= 1.0:
        power += 1
    return power
