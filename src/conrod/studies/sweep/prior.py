"""Errors and costs of the committed sweeps, from which a search for settings begins.

They only say what to try first: every proposed setting is run on the machine itself. `prior.json` is made from
reports/sweep/data by `make prior` (benchmarks/prior.py); a test compares the two.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple

from conrod.exact.motion import QUANTITIES
from conrod.scenes import SCENES, Scene
from conrod.studies.sweep.study import RulePlan

PRIOR_FILE = "prior.json"
# Errors are saved as whole numbers, 10 to a factor of ten, as decibels are; steps are then off by 1/8 at order 1.
DECIBELS = 10.0
# Sweep of one machine: {steps: [...], engine: {rule: [cost of a step, then errors by quantity]}}.
PriorSweep = Mapping[str, Any]
# Steps per revolution and order of a rule that is in no sweep, or has no order at the steps in question.
DEFAULT_STEPS, DEFAULT_ORDER = 200, 2.0


class Guess(NamedTuple):
    """Expected steps and cost at which a settings rule meets the tolerances.

    Attributes:
        rule: the rule.
        steps: expected steps per revolution.
        cost: expected cost of a revolution in steps of the reference loop; infinite if the rule met them in no sweep.
        excess: expected ratio of the error to its tolerance.
        order: expected order of the error in the step.
        machine: name of the machine whose sweep gave the guess; empty if none has this rule.
    """

    rule: RulePlan
    steps: int
    cost: float
    excess: float
    order: float
    machine: str


@cache
def shipped_sweeps() -> Mapping[str, PriorSweep]:
    """Return the sweeps that ship with conrod, by machine name."""
    table: Mapping[str, PriorSweep] = json.loads(files(__package__).joinpath(PRIOR_FILE).read_text(encoding="utf-8"))
    return table


def ranked_guesses(
    rules: Sequence[RulePlan], scene: Scene, allowed: Mapping[str, float], table: Mapping[str, PriorSweep]
) -> list[Guess]:
    """Return the best guess for each rule that the engine can run, the cheapest first.

    If the engine can run no rule, only the first is returned, and its run says why.

    If the scene itself was swept, only its own sweep counts. Otherwise all machines with the same rules count: machines
    closed by joints have other rules than machines with contact.
    """
    same = [name for name in table if name in SCENES and SCENES[name].identity() == scene.identity()]
    known = {name: table[name] for name in same or table}
    best = []
    for rule in [one for one in rules if one.engine.refusal(scene, one.cases[0].settings) is None] or rules[:1]:
        found = [
            _guess_from_sweep(rule, name, swept, allowed) for name, swept in known.items() if _prior_row(rule, swept)
        ]
        unknown = Guess(rule, DEFAULT_STEPS, math.inf, math.inf, DEFAULT_ORDER, "")
        best.append(min(found or [unknown], key=_sort_key))
    return sorted(best, key=_sort_key)


def _sort_key(guess: Guess) -> tuple[float, float]:
    """Key that sorts guesses by cost, then by excess."""
    return guess.cost, guess.excess


def _prior_row(rule: RulePlan, swept: PriorSweep) -> Sequence[Any]:
    """Row of a settings rule in a shipped sweep: cost of a step, then errors by quantity; empty if missing."""
    row: Sequence[Any] = swept.get(rule.engine.name, {}).get(rule.rule.name, ())
    return row


def _guess_from_sweep(rule: RulePlan, machine: str, swept: PriorSweep, allowed: Mapping[str, float]) -> Guess:
    """Guess from the errors of a sweep, interpolated in log(steps).

    If no steps meet the tolerances, the guess is the nearest, at infinite cost.
    """
    steps, (cost, *errors) = swept["steps"], _prior_row(rule, swept)
    over = [_log_excess(column, allowed) for column in zip(*errors, strict=True)]  # at each number of steps
    k = next((k for k, x in enumerate(over) if x <= 0.0), None)
    if k is None:
        k = min(range(len(steps)), key=over.__getitem__)
        return Guess(rule, steps[k], math.inf, math.exp(over[k]), _local_order(steps, over, k), machine)
    at, order = float(steps[k]), _local_order(steps, over, k)
    if k > 0 and math.isfinite(over[k - 1]):
        at *= (steps[k - 1] / steps[k]) ** (over[k] / (over[k] - over[k - 1]))
    return Guess(rule, round(at), at * cost, 1.0, order, machine)


def _log_excess(column: Sequence[int | None], allowed: Mapping[str, float]) -> float:
    """Largest ln(error / tolerance) at one number of steps; infinite if an error is unknown."""
    found = dict(zip(QUANTITIES, column, strict=True))
    logs = [
        math.inf if (size := found[q]) is None else size * math.log(10.0) / DECIBELS - math.log(a)
        for q, a in allowed.items()
    ]
    return max(logs)


def _local_order(steps: Sequence[int], over: Sequence[float], k: int) -> float:
    """Order of the error between steps k and the next coarser or finer ones.

    It is DEFAULT_ORDER if the error does not fall.
    """
    for a, b in ((k - 1, k), (k, k + 1)):
        if a >= 0 and b < len(steps) and math.isfinite(over[a]) and math.isfinite(over[b]) and over[b] < over[a]:
            return (over[a] - over[b]) / math.log(steps[b] / steps[a])
    return DEFAULT_ORDER
