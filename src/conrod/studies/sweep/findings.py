"""Findings of a sweep on one scene: plain, frozen data that is read without an engine."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import Any, TypeVar

from conrod.comparison.convergence import ObservedOrder

COMPLETED = "completed"
Item = TypeVar("Item")


def pareto_front(items: Iterable[Item], costs: Callable[[Item], tuple[float, float]]) -> tuple[Item, ...]:
    """Return the Pareto front: items that no other beats in both costs, by the first cost.

    Of several items with the same two costs the first is kept.
    """
    front: list[Item] = []
    least = math.inf
    for item in sorted(items, key=costs):
        if costs(item)[1] < least:
            least = costs(item)[1]
            front.append(item)
    return tuple(front)


@dataclass(frozen=True)
class SweptPoint:
    """One run of a sweep's grid.

    Attributes:
        label: name of the point in tables and figures, such as M17.
        key: key of the run in the ledger.
        rule: name of the settings rule; with the steps it gives the settings.
        preset: name of the preset that the settings equal; None if there is none.
        errors: largest of each quantity over the run and the observed points, normalised; None unless it completed.
        cost: CPU time of a revolution [s] at the median speed of the reference loop; None if it was not timed.
        ratio: the same in steps of the engine's fixed reference loop.
    """

    label: str
    key: str
    engine: str
    rule: str
    preset: str | None
    steps_per_revolution: int
    outcome: str
    reason: str
    errors: Mapping[str, float] | None
    cost: float | None
    ratio: float | None

    @property
    def completed(self) -> bool:
        """True if the run completed, and so has errors."""
        return self.errors is not None

    def error(self, quantity: str) -> float | None:
        """Largest error of a quantity, normalised; None unless the run completed."""
        return None if self.errors is None else self.errors[quantity]


@dataclass(frozen=True)
class SweptRule:
    """A settings rule of one engine, and the orders of its errors in the step.

    Attributes:
        orders: observed orders by quantity.
        lines: template of lines to paste, see `fill_paste_template`; empty in reports of an earlier conrod.
    """

    engine: str
    name: str
    orders: Mapping[str, ObservedOrder]
    lines: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class SweepStudy:
    """Findings of a sweep on one scene.

    Attributes:
        name, title, parameters: identification of the scene.
        one_pass: True if its input makes one pass and cannot turn fully.
        engines: versions by engine name.
        unsupported: reasons why engines cannot be swept, by engine name.
        machine: fingerprint of the machine on which the costs were measured.
        lengths: length L of each observed point [m]; empty in reports of an earlier conrod.
        distrust: scenes and engines whose figures cannot be trusted, and why, in words; empty if all can.
    """

    name: str
    title: str
    parameters: Mapping[str, Any]
    one_pass: bool
    grid: str
    engines: Mapping[str, str]
    unsupported: Mapping[str, str]
    machine: str
    rules: tuple[SweptRule, ...]
    points: tuple[SweptPoint, ...]
    lengths: Mapping[str, float] = field(default_factory=dict)
    distrust: str = ""

    def front(self, quantity: str, engine: str | None = None) -> tuple[SweptPoint, ...]:
        """Return the timed points that no other beats in both cost and error, the cheapest first."""
        drawn = [p for p in self.points if p.completed and p.cost is not None and engine in (None, p.engine)]
        return pareto_front(drawn, lambda p: (p.cost or 0.0, p.error(quantity) or 0.0))

    def points_of(self, rule: SweptRule) -> list[SweptPoint]:
        """Return the points of a rule, by increasing steps."""
        own = [p for p in self.points if (p.engine, p.rule) == (rule.engine, rule.name)]
        return sorted(own, key=lambda p: p.steps_per_revolution)

    def settings_lines(self, point: SweptPoint) -> str:
        """Return the lines to paste for the settings of a point; empty if unknown."""
        rules = (rule for rule in self.rules if (rule.engine, rule.name) == (point.engine, point.rule))
        return next((fill_paste_template(rule.lines, point.steps_per_revolution) for rule in rules), "")


# -- lines to paste ----------------------------------------------------------------------------------------------------

NUMBER = re.compile(r"(?<![\w.])-?\d[\d.]*(?:e[-+]?\d+)?")
# Field {a/nk} of a template: the number a / n^k, which follows n steps per revolution.
STEP_POWER_FIELD = re.compile(r"\{([^{}]+)/n(\d)\}")
ANY_STEPS = "n"  # key of a template that holds for any number of steps
NUMBER_TOLERANCE = 1e-12  # relative difference of numbers that are the same but for rounding


def paste_template(pastes: Mapping[int, str]) -> dict[str, str]:
    """Return a template of lines for any steps, if they differ by powers of the steps.

    Else return the lines by steps.

    Args:
        pastes: lines to paste by steps per revolution.
    """
    few, many = min(pastes), max(pastes)
    text = ""
    numbers = (NUMBER.findall(pastes[steps]) for steps in (few, many))
    for between, one, other in zip_longest(NUMBER.split(pastes[few]), *numbers, fillvalue=""):
        text += between
        if one == other or not (one and other and float(one) * float(other) > 0.0):
            text += one
            continue
        power = round(math.log(float(one) / float(other)) / math.log(many / few))
        text += f"{{{float(one) * few**power:.16g}/n{power}}}"
    shared = {ANY_STEPS: text}
    alike = all(_equal_but_for_rounding(fill_paste_template(shared, steps), paste) for steps, paste in pastes.items())
    return shared if alike else {str(steps): paste for steps, paste in pastes.items()}


def fill_paste_template(lines: Mapping[str, str], steps: int) -> str:
    """Fill a template of `paste_template` for some steps per revolution; empty if missing."""
    shared = lines.get(ANY_STEPS, lines.get(str(steps), ""))
    return STEP_POWER_FIELD.sub(lambda found: f"{float(found[1]) / steps ** int(found[2]):.15g}", shared)


def _equal_but_for_rounding(one: str, other: str) -> bool:
    """True if two texts are the same but for the rounding of numbers."""
    pairs = zip(*(map(float, NUMBER.findall(lines)) for lines in (one, other)), strict=False)
    return NUMBER.split(one) == NUMBER.split(other) and all(
        math.isclose(*pair, rel_tol=NUMBER_TOLERANCE) for pair in pairs
    )
