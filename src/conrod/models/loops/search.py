"""Search for the cheapest settings that hold a tolerance: each at the largest step, by powers of two of the file's own.

A setting holds if the driven run is within the tolerance, and if the file runs with it and its own actuators and keeps
its loops as closed; where no setting does all, a file that does not do so as it is may be left without.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from typing import Literal

from conrod.comparison.convergence import ObservedOrder, observed_order
from conrod.comparison.trajectory import Outcome
from conrod.execution.paired_timing import PairedTiming
from conrod.mjcf.loop_results import LOOPS, OWN_SETTINGS, LoopRun, SettingsSearch, ShippedRun, loop_limits

Trial = tuple[LoopRun, ShippedRun]
# What the file's own run has to do with settings: stay within the limit on its loops, or complete.
Need = Literal["within", "complete", "any"]
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
    own: ShippedRun,
    may_go_on: Callable[[], bool] = lambda: True,
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
        own: the file's own run as it is. What this does not keep, settings may break, where none keep it.
        may_go_on: whether a further run may be made; what is not tried is taken not to hold.
    """
    if not may_go_on():
        return SettingsSearch(dict(allowed), tuple(guesses), (step, step))
    tried, timing = dict[tuple[str, int], Trial](), cache(timing_of)
    # A run that nothing drives is not judged: its loops need not stay closer than they do as it is.
    opening = max(loop_limits(allowed).get(LOOPS, math.inf), 0.0 if own.driven else own.gap)

    def excess(need: Need, name: str, power: int) -> float:
        """How far a setting misses a need, at a step of 2^power times the model's own; each is run once."""
        if (name, power) not in tried:
            if not may_go_on():
                return math.inf
            tried[name, power] = run_at(name, step * 2.0**power)
        return _excess(*tried[name, power], allowed, need, opening)

    needs: tuple[Need, ...] = (
        "within",
        *(("complete",) if own.failed or own.exceeds(allowed) or not own.driven else ()),
    )
    for need in (*needs, *(("any",) if own.failed else ())):
        if (best := _cheapest(partial(excess, need), timing, guesses, limits)) is not None:
            break
    ran = [run.timestep for run, _ in tried.values()] or [step]
    searched = SettingsSearch(dict(allowed), tuple(guesses), (min(ran), max(ran)))
    if best is None:
        sizes = {key: excess(need, *key) for key in tried}
        nearest = min(sizes, key=lambda key: sizes[key], default=None)
        known = nearest is not None and math.isfinite(sizes[nearest])
        return replace(searched, nearest=tried[nearest][0]) if nearest is not None and known else searched
    (run, shipped), (name, power) = tried[best], best
    cost, beyond = _cost(name, power, timing), tried.get((name, power + 1))
    return replace(
        searched,
        best=replace(run, cost=cost),
        shipped=shipped,
        coarser=None if beyond is None else replace(beyond[0], cost=0.5 * cost),
        coarser_shipped=None if beyond is None else beyond[1],
        speed=step * 2.0**power / timing(name).seconds,
        own_speed=step / timing(name).other_seconds,
    )


def _cheapest(
    excess: Callable[[str, int], float],
    timing: Callable[[str], PairedTiming],
    guesses: Mapping[str, int],
    limits: tuple[int, int],
) -> tuple[str, int] | None:
    """Name and power of two of the step of the cheapest settings whose excess is at most 1; None if none has it."""
    best, cost = None, math.inf
    for name, guess in guesses.items():
        # A setting that is not the cheapest so far has to hold at a larger step.
        share = _cost(name, 0, timing)
        least = limits[0] if best is None else max(limits[0], math.floor(math.log2(share / cost)) + 1)
        if least > limits[1]:
            continue
        found = _largest_power(partial(excess, name), max(guess, least), (least, limits[1]))
        if found is not None:
            best, cost = (name, found), share / 2.0**found
    return best


def _cost(name: str, power: int, timing: Callable[[str], PairedTiming]) -> float:
    """Cost of a simulated second at a power of two of the own step, over that with the file's own settings."""
    return (1.0 if name == OWN_SETTINGS else timing(name).ratio) / 2.0**power


def order_of(runs: Mapping[float, LoopRun]) -> ObservedOrder:
    """Observed order of completed runs, by their number of steps over the model's own."""
    coarsest = min(runs)
    errors = {round(n / coarsest): run.errors["position"] for n, run in sorted(runs.items()) if run.errors}
    return observed_order(list(errors), list(errors.values()))


def _excess(run: LoopRun, shipped: ShippedRun, allowed: Mapping[str, float], need: Need, opening: float) -> float:
    """Largest error over its limit; infinite where the driven run, or an own run that must complete, did not.

    Args:
        opening: limit on how far the loops open in the file's own run [m].
    """
    if run.outcome is not Outcome.COMPLETED or (need != "any" and shipped.failed):
        return math.inf
    shares = [run.judged_error(name) / limit if limit else math.inf for name, limit in loop_limits(allowed).items()]
    if need == "within":
        shares.append(shipped.gap / opening if opening else math.inf)
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
