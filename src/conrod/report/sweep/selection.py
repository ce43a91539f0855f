"""Points of a sweep that are worth naming: on a front, of a preset, the cheapest within a tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median

from conrod.report import numbers
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.findings import SweepStudy, SweptPoint

# The divisor of an error, in words that follow a number.
UNITS: Mapping[str, str] = {"position": "L", "velocity": "ω L", "acceleration": "ω² L"}

Among = Callable[[SweptPoint], bool]


@dataclass(frozen=True)
class Curve:
    """The points of one preset of one engine, at increasing numbers of steps; failed ones among them."""

    engine: str
    preset: str
    points: tuple[SweptPoint, ...]

    @property
    def rule(self) -> str:
        """The name of the rule that the preset is; of most of its points, where several rules share them."""
        names = [point.rule for point in self.points]
        return max(names, key=names.count)


def preset_curves(study: SweepStudy) -> tuple[Curve, ...]:
    """A curve for each engine and preset that the sweep holds, both in their order."""
    curves = []
    for engine in study.engines:
        of_engine = [p for p in study.points if p.engine == engine and p.preset is not None]
        for preset in dict.fromkeys(p.preset or "" for p in of_engine):
            # Two rules may share a run: it is one point of the curve.
            runs = {p.key: p for p in of_engine if p.preset == preset}.values()
            curves.append(Curve(engine, preset, tuple(sorted(runs, key=lambda p: p.steps_per_revolution))))
    return tuple(curves)


def labelled_points(
    study: SweepStudy, quantities: Sequence[str] = QUANTITIES
) -> tuple[tuple[SweptPoint, Mapping[str, bool]], ...]:
    """Every point on the front of its engine for some quantity, cheapest first within its engine.

    Returns:
        Points, each with the quantities on whose front of its engine it is, and whether on that of all engines too.
    """
    named: dict[str, tuple[SweptPoint, dict[str, bool]]] = {}
    for quantity in quantities:
        overall = {p.label for p in study.front(quantity)}
        for engine in study.engines:
            for point in study.front(quantity, engine):
                named.setdefault(point.label, (point, {}))[1][quantity] = point.label in overall
    order = list(study.engines)
    return tuple(sorted(named.values(), key=lambda entry: (order.index(entry[0].engine), entry[0].cost or 0.0)))


def cheapest_within(
    study: SweepStudy, quantity: str, allowed: float, engine: str, among: Among = lambda point: True
) -> SweptPoint | None:
    """The cheapest point of an engine whose error of a quantity is within a tolerance; None where there is none."""
    within = [
        p for p in study.points
        if p.engine == engine and p.cost is not None and p.completed and among(p)
        and (p.error(quantity) or 0.0) <= allowed
    ]  # fmt: skip
    return min(within, key=lambda p: (p.cost or 0.0, p.error(quantity) or 0.0), default=None)


def most_accurate(study: SweepStudy, quantity: str, engine: str) -> SweptPoint | None:
    """The completed point of an engine with the least error of a quantity; None where there is none."""
    completed = [p for p in study.points if p.completed and p.engine == engine]
    return min(completed, key=lambda p: p.error(quantity) or 0.0, default=None)


def timed_engines(study: SweepStudy) -> list[str]:
    """Engines of which a completed run was timed."""
    return [e for e in study.engines if any(p.engine == e and p.completed and p.cost is not None for p in study.points)]


# -- costs of points that have none ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Placed:
    """A point and the cost that it is drawn at.

    Attributes:
        cost: CPU time of a revolution [s].
        estimated: the cost is that of a step of another point, times the steps.
    """

    point: SweptPoint
    cost: float
    estimated: bool


def placed_points(study: SweepStudy) -> tuple[Placed, ...]:
    """All points of the engines of which any was timed.

    The cost of a run that did not complete means nothing: the engine stopped, or computed with numbers that are none.
    It is placed at what its steps would cost, and so is a completed run that was not timed: a step costs what it costs
    at the nearest number of steps of the same rule, or in the median of the engine's other rules.
    """
    placed = []
    for engine in timed_engines(study):
        points = [point for point in study.points if point.engine == engine]
        timed = [point for point in points if point.completed and point.cost is not None]
        for point in points:
            if point.completed and point.cost is not None:
                placed.append(Placed(point, point.cost, False))
            else:
                placed.append(Placed(point, point.steps_per_revolution * _step_cost(point, timed), True))
    return tuple(placed)


def _step_cost(point: SweptPoint, timed: Sequence[SweptPoint]) -> float:
    """CPU time of a step [s]."""
    of_rule = [other for other in timed if other.rule == point.rule]
    if not of_rule:
        return median(_cost_per_step(other) for other in timed)
    target = math.log(point.steps_per_revolution)
    return _cost_per_step(min(of_rule, key=lambda p: abs(math.log(p.steps_per_revolution) - target)))


def _cost_per_step(point: SweptPoint) -> float:
    return (point.cost or 0.0) / point.steps_per_revolution


# -- names -------------------------------------------------------------------------------------------------------------


def with_unit(value: float | None, quantity: str) -> str:
    """A normalised error and what it is a share of: `0.043 L`."""
    return f"{numbers.measured(value)} {UNITS[quantity]}"


def tolerance(value: float) -> str:
    """A given tolerance: `1e-6`."""
    return numbers.quantity(value) if value >= 1.0 else f"{value:.0e}".replace("e-0", "e-")


def rule_of(point: SweptPoint) -> str:
    """The rule, marked where it is a preset."""
    return f"{point.rule} (`{point.preset}`)" if point.preset else point.rule


def setting_of(point: SweptPoint) -> str:
    """The rule, the preset that it is if it is one, and the steps: all that identifies a setting."""
    named = f"`{point.preset}`, that is {point.rule}" if point.preset else point.rule
    return f"{named}, at {point.steps_per_revolution} steps per revolution ({point.label})"
