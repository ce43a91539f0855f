"""Errors and costs of the committed sweeps, shipped as data: where a search for a setting of any machine begins.

They are a guess, and nothing is promised on them: whatever they propose is run on the machine itself. `prior.json` is
made of reports/sweep/data by `make prior` (benchmarks/prior.py); a test compares the two.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple

from conrod.scenes import SCENES, Scene
from conrod.studies.frame.case import QUANTITIES
from conrod.studies.sweep.study import RulePlan

FILE = "prior.json"
# Errors are kept as whole numbers of this many to a factor of ten: steps are then off by an eighth at order 1.
DECIBELS = 10.0
# A machine that was swept, by name: {steps: [...], engine: {rule: [cost of a step, then errors by quantity]}}.
Swept = Mapping[str, Any]
# Of a rule that no sweep knows, or that has no order where it is asked for.
USUAL_STEPS, USUAL_ORDER = 200, 2.0


class Guess(NamedTuple):
    """Expectation of where a rule meets the tolerances.

    Attributes:
        cost: of a revolution in steps of the reference loop; infinite where no sweep met them.
        excess: expected error over what is allowed.
        order: of the error in the step, there.
        machine: that was swept; empty where none has this rule.
    """

    rule: RulePlan
    steps: int
    cost: float
    excess: float
    order: float
    machine: str


@cache
def shipped() -> Mapping[str, Swept]:
    """The shipped table, by machine."""
    table: Mapping[str, Swept] = json.loads(files(__package__).joinpath(FILE).read_text(encoding="utf-8"))
    return table


def guesses(
    rules: Sequence[RulePlan], scene: Scene, allowed: Mapping[str, float], table: Mapping[str, Swept]
) -> list[Guess]:
    """For each rule that the engine can have on the scene its most favourable guess; the cheapest first.

    Of an engine that can have none the first rule, whose run says why.

    Of a machine that was swept its own sweep counts alone; any other machine is guessed from all that share its rules:
    those closed by joints have others than those with contact.
    """
    same = [name for name in table if name in SCENES and SCENES[name].identity() == scene.identity()]
    known = {name: table[name] for name in same or table}
    best = []
    for rule in [one for one in rules if one.engine.refusal(scene, one.cases[0].settings) is None] or rules[:1]:
        found = [_guess(rule, name, swept, allowed) for name, swept in known.items() if _row(rule, swept)]
        unknown = Guess(rule, USUAL_STEPS, math.inf, math.inf, USUAL_ORDER, "")
        best.append(min(found or [unknown], key=_merit))
    return sorted(best, key=_merit)


def _merit(guess: Guess) -> tuple[float, float]:
    return guess.cost, guess.excess


def _row(rule: RulePlan, swept: Swept) -> Sequence[Any]:
    row: Sequence[Any] = swept.get(rule.engine.name, {}).get(rule.rule.name, ())
    return row


def _guess(rule: RulePlan, machine: str, swept: Swept, allowed: Mapping[str, float]) -> Guess:
    """The first step within the tolerances, read between the swept ones; the one nearest to them where none is."""
    steps, (cost, *errors) = swept["steps"], _row(rule, swept)
    over = [_excess(column, allowed) for column in zip(*errors, strict=True)]  # log of the excess at each step
    k = next((k for k, x in enumerate(over) if x <= 0.0), None)
    if k is None:
        k = min(range(len(steps)), key=over.__getitem__)
        return Guess(rule, steps[k], math.inf, math.exp(over[k]), _order(steps, over, k), machine)
    at, order = float(steps[k]), _order(steps, over, k)
    if k > 0 and math.isfinite(over[k - 1]):
        at *= (steps[k - 1] / steps[k]) ** (over[k] / (over[k] - over[k - 1]))
    return Guess(rule, round(at), at * cost, 1.0, order, machine)


def _excess(column: Sequence[int | None], allowed: Mapping[str, float]) -> float:
    found = dict(zip(QUANTITIES, column, strict=True))
    logs = [
        math.inf if (size := found[q]) is None else size * math.log(10.0) / DECIBELS - math.log(a)
        for q, a in allowed.items()
    ]
    return max(logs)


def _order(steps: Sequence[int], over: Sequence[float], k: int) -> float:
    """Order between a step and its coarser neighbour, or its finer one."""
    for a, b in ((k - 1, k), (k, k + 1)):
        if a >= 0 and b < len(steps) and math.isfinite(over[a]) and math.isfinite(over[b]) and over[b] < over[a]:
            return (over[a] - over[b]) / math.log(steps[b] / steps[a])
    return USUAL_ORDER
