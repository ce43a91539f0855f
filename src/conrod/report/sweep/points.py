"""Points of a sweep that are worth naming: of a preset, on a front, the cheapest within a tolerance."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from statistics import median

from conrod.report import numbers
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.findings import SweepStudy, SweptPoint

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-9)


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


def front_points(study: SweepStudy) -> list[tuple[SweptPoint, Mapping[str, bool]]]:
    """Every point on the front of its engine for some quantity, cheapest first within its engine.

    Returns:
        Points, each with the quantities on whose front of its engine it is, and whether on that of all engines too.
    """
    named: dict[str, tuple[SweptPoint, dict[str, bool]]] = {}
    for quantity in QUANTITIES:
        overall = {p.label for p in study.front(quantity)}
        for engine in study.engines:
            for point in study.front(quantity, engine):
                named.setdefault(point.label, (point, {}))[1][quantity] = point.label in overall
    order = list(study.engines)
    return sorted(named.values(), key=lambda entry: (order.index(entry[0].engine), entry[0].cost or 0.0))


def cheapest_within(points: Iterable[SweptPoint], quantity: str, allowed: float, engine: str) -> SweptPoint | None:
    """The cheapest point of an engine whose error of a quantity is within a tolerance; None where there is none."""
    timed = [p for p in points if p.engine == engine and p.cost is not None and p.completed]
    within = [p for p in timed if (p.error(quantity) or 0.0) <= allowed]
    return min(within, key=lambda p: (p.cost or 0.0, p.error(quantity) or 0.0), default=None)


def least_error(study: SweepStudy, quantity: str, engine: str, preset: str | None = None) -> float | None:
    """The least error of a quantity that any completed run of an engine has, or one of a preset; None without runs."""
    runs = [p for p in study.points if p.completed and p.engine == engine and preset in (None, p.preset)]
    return min((p.error(quantity) or 0.0 for p in runs), default=None)


def timed_engines(study: SweepStudy) -> list[str]:
    """Engines of which a completed run was timed."""
    return [e for e in study.engines if any(p.engine == e and p.completed and p.cost is not None for p in study.points)]


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
        steps = {  # what one costs [s], by rule and number of them
            (p.rule, p.steps_per_revolution): p.cost / p.steps_per_revolution
            for p in points
            if p.completed and p.cost is not None
        }
        for point in points:
            if point.completed and point.cost is not None:
                placed.append(Placed(point, point.cost, False))
                continue
            count = point.steps_per_revolution
            of_rule = {abs(math.log(n / count)): step for (rule, n), step in steps.items() if rule == point.rule}
            step = of_rule[min(of_rule)] if of_rule else median(steps.values())
            placed.append(Placed(point, count * step, True))
    return tuple(placed)


# -- names -------------------------------------------------------------------------------------------------------------


def tolerance(value: float) -> str:
    """A given tolerance: `1e-6`."""
    return numbers.quantity(value) if value >= 1.0 else f"{value:.0e}".replace("e-0", "e-")


def rule_of(point: SweptPoint) -> str:
    """The rule, marked where it is a preset."""
    return f"{point.rule} (`{point.preset}`)" if point.preset else point.rule
