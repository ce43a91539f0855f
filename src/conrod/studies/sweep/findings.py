"""Findings of a sweep on one scene: plain, frozen data that the report and the command line read without any engine."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
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
    """

    engine: str
    name: str
    orders: Mapping[str, ObservedOrder]


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

    def front(self, quantity: str, engine: str | None = None) -> tuple[SweptPoint, ...]:
        """Points that no other one beats in both cost and error, cheapest first."""
        drawn = [p for p in self.points if p.completed and p.cost is not None and engine in (None, p.engine)]
        return pareto_front(drawn, lambda p: (p.cost or 0.0, p.error(quantity) or 0.0))

    def points_of(self, rule: SweptRule) -> list[SweptPoint]:
        """The points of a rule, at increasing numbers of steps."""
        own = [p for p in self.points if (p.engine, p.rule) == (rule.engine, rule.name)]
        return sorted(own, key=lambda p: p.steps_per_revolution)
