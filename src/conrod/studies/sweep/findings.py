"""Findings of a sweep on one scene: plain, frozen data that the report and the command line read without any engine."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import Any, TypeVar

from conrod.runs.convergence import ObservedOrder

COMPLETED = "completed"
Item = TypeVar("Item")


def pareto_front(items: Iterable[Item], costs: Callable[[Item], tuple[float, float]]) -> tuple[Item, ...]:
    """Items that no other item beats or equals in both costs, by increasing first cost.

    Of items with the same two costs the first is kept.
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
    """One run of the grid.

    Attributes:
        label: number of the point in its scene's table, such as M17: its name in a figure.
        key: of the run in the ledger.
        rule: name of its settings, the step apart.
        preset: the preset that these settings are, if they are one.
        errors: largest of each quantity over the run and the observed points, normalised; None unless it completed.
        cost: CPU time of a revolution [s], where the reference loop takes what it does in the median; None where it
            was not timed.
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
        """True if the run has errors."""
        return self.errors is not None

    def error(self, quantity: str) -> float | None:
        """Largest error of a quantity, normalised; None unless the run completed."""
        return None if self.errors is None else self.errors[quantity]


@dataclass(frozen=True)
class SweptRule:
    """Settings of one engine, the step apart, and how their errors fall with it.

    Attributes:
        orders: by quantity.
        lines: that set this, to be pasted, see `lines_at`; empty in reports of an earlier conrod.
    """

    engine: str
    name: str
    orders: Mapping[str, ObservedOrder]
    lines: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class SweepStudy:
    """Findings on one scene.

    Attributes:
        name, title, parameters: of the scene.
        one_pass: whether its input makes one pass instead of turning.
        engines: name -> version.
        unsupported: engine -> why it cannot be swept.
        machine: that the costs were taken on.
        lengths: L of each observed point [m]; empty in reports of an earlier conrod.
        distrust: scenes and engines whose figures cannot be trusted, and why, in words; empty if there are none.
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
        """Points that no other one beats in both cost and error, cheapest first."""
        drawn = [p for p in self.points if p.completed and p.cost is not None and engine in (None, p.engine)]
        return pareto_front(drawn, lambda p: (p.cost or 0.0, p.error(quantity) or 0.0))

    def points_of(self, rule: SweptRule) -> list[SweptPoint]:
        """The points of a rule, at increasing numbers of steps."""
        own = [p for p in self.points if (p.engine, p.rule) == (rule.engine, rule.name)]
        return sorted(own, key=lambda p: p.steps_per_revolution)

    def lines_of(self, point: SweptPoint) -> str:
        """Lines that set what a point is, ready to paste; empty where they are not known."""
        rules = (rule for rule in self.rules if (rule.engine, rule.name) == (point.engine, point.rule))
        return next((lines_at(rule.lines, point.steps_per_revolution) for rule in rules), "")


# -- lines to paste ----------------------------------------------------------------------------------------------------

NUMBER = re.compile(r"(?<![\w.])-?\d[\d.]*(?:e[-+]?\d+)?")
# A number that goes with the step or with its square, as that at one step a revolution over a power of their number.
OVER_STEPS = re.compile(r"\{([^{}]+)/n(\d)\}")
ANY, ROUNDING = "n", 1e-12


def shared_lines(pastes: Mapping[int, str]) -> dict[str, str]:
    """Lines at numbers of steps as one text for any of these; the lines of each where they differ in another way."""
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
    shared = {ANY: text}
    alike = all(_alike(lines_at(shared, steps), paste) for steps, paste in pastes.items())
    return shared if alike else {str(steps): paste for steps, paste in pastes.items()}


def lines_at(lines: Mapping[str, str], steps: int) -> str:
    """Lines that `shared_lines` made, at a number of steps per revolution; empty where there are none."""
    shared = lines.get(ANY, lines.get(str(steps), ""))
    return OVER_STEPS.sub(lambda found: f"{float(found[1]) / steps ** int(found[2]):.15g}", shared)


def _alike(one: str, other: str) -> bool:
    """True if lines are the same but for the rounding of numbers."""
    pairs = zip(*(map(float, NUMBER.findall(lines)) for lines in (one, other)), strict=False)
    return NUMBER.split(one) == NUMBER.split(other) and all(math.isclose(*pair, rel_tol=ROUNDING) for pair in pairs)
