"""Which points no other one beats in both of two costs.

What a sweep finds: plain, frozen data that the report and the command line read. Needs no engine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from conrod.scenes import Scene
from conrod.studies.frame.timing import Timing

if TYPE_CHECKING:
    from conrod.studies.frame.measurement import Measurement
    from conrod.studies.sweep.error_budget import ErrorBudget
    from conrod.studies.sweep.grid_convergence import GridConvergence
    from conrod.studies.sweep.observed_orders import ObservedOrders
    from conrod.studies.sweep.sensitivity import Sensitivity

Item = TypeVar("Item")


def pareto_front(items: Iterable[Item], costs: Callable[[Item], tuple[float, float]]) -> tuple[Item, ...]:
    """The items that no other item beats or equals in both costs, by increasing first cost.

    Of items with the same two costs the first is kept.
    """
    front: list[Item] = []
    least = float("inf")
    for item in sorted(items, key=costs):
        if costs(item)[1] < least:
            least = costs(item)[1]
            front.append(item)
    return tuple(front)


COMPLETED = "completed"


@dataclass(frozen=True)
class SweptPoint:
    """One cell of the grid.

    Attributes:
        label: number of the point in its scene's table, such as M17: what a figure names it by.
        rule: name of its settings, the step apart.
        preset: the preset that these settings are, if they are one.
        knobs: every knob and where it stands.
        settings: all of them, as the engine gets them.
        timing: None where the cell could not be timed.
    """

    label: str
    key: str
    engine: str
    rule: str
    preset: str | None
    path: str
    knobs: Mapping[str, str]
    settings: Mapping[str, Any]
    steps_per_revolution: int
    measurement: Measurement
    timing: Timing | None

    @property
    def completed(self) -> bool:
        """Whether the run has errors."""
        return self.measurement.outcome == COMPLETED

    @property
    def cost(self) -> float | None:
        """CPU time of a revolution [s]."""
        return None if self.timing is None else self.timing.seconds_per_revolution

    def error(self, quantity: str) -> float | None:
        """Largest error over the run and the observed points, normalised."""
        return self.measurement.largest(quantity)


@dataclass(frozen=True)
class SweepStudy:
    """Everything that a sweep finds on one scene."""

    name: str
    scene: Scene
    grid: str
    engines: Mapping[str, str]  # name -> version
    machine: str  # that the timings are of
    points: tuple[SweptPoint, ...]
    orders: tuple[ObservedOrders, ...]
    grid_convergence: tuple[GridConvergence, ...]  # of rules that differ in what they come to
    both_ways: tuple[GridConvergence, ...]  # of the presets' settings, the step refined alone and with softness
    budgets: tuple[ErrorBudget, ...]
    sensitivities: tuple[Sensitivity, ...]

    def front(self, quantity: str, engine: str | None = None) -> tuple[SweptPoint, ...]:
        """Points that no other one beats in both cost and error, cheapest first."""
        drawn = [p for p in self.points if p.completed and p.cost is not None and engine in (None, p.engine)]
        return pareto_front(drawn, lambda p: (p.cost or 0.0, p.error(quantity) or 0.0))

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {
            "scene": self.name,
            "parameters": dict(self.scene.parameters),
            "grid": self.grid,
            "engines": dict(self.engines),
            "machine": self.machine,
            "points": [_point_dict(point) for point in self.points],
            "orders": [found.as_dict() for found in self.orders],
            "grid_convergence": [found.as_dict() for found in self.grid_convergence],
            "both_ways": [found.as_dict() for found in self.both_ways],
            "budgets": [found.as_dict() for found in self.budgets],
            "sensitivities": [found.as_dict() for found in self.sensitivities],
        }


def _point_dict(point: SweptPoint) -> dict[str, Any]:
    values = asdict(point)
    # The signed errors are for other studies; the ledger has them.
    del values["measurement"]["signed"]
    return values
