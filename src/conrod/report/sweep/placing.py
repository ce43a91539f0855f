"""How points stand and look in a work-precision diagram.

Where each point of a sweep stands on the cost axis, those that have no measured cost among them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from conrod.engines.registry import look_of
from conrod.exact.motion import Array
from conrod.report.charts.canvas import on_log_grid
from conrod.report.charts.styles import colour
from conrod.studies.sweep.results import SweepStudy, SweptPoint

FRONT_OF_ALL: dict[str, Any] = {"color": "#c4c4c4", "linewidth": 7.0, "zorder": 1, "solid_capstyle": "round"}


def drawn_costs(points: Sequence[SweptPoint]) -> Array:
    """Measured costs [s], on the grid that is drawn."""
    return on_log_grid(np.array([point.cost or 0.0 for point in points]))


def drawn_errors(points: Sequence[SweptPoint], quantity: str) -> Array:
    """Errors, on the grid that is drawn."""
    return on_log_grid(np.array([point.error(quantity) or 0.0 for point in points]))


def dot_style(engine: str) -> dict[str, Any]:
    """Arguments of `Axes.plot` for runs that are nothing in particular."""
    return {
        "linestyle": "none",
        "marker": look_of(engine).dot,
        "markersize": 2.6,
        "color": colour(engine),
        "alpha": 0.35,
        "markeredgewidth": 0.0,
        "zorder": 2,
    }


def front_style(engine: str) -> dict[str, Any]:
    """Arguments of `Axes.plot` for the front of an engine."""
    hue = colour(engine)
    marked = {"marker": look_of(engine).dot, "markersize": 4.0, "markeredgecolor": "white", "markeredgewidth": 0.5}
    return {"color": hue, "linewidth": 2.2, "alpha": 0.9, "zorder": 6, "linestyle": "-", **marked}


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

    What a run cost that did not complete means nothing: the engine stopped, or computed with numbers that are none. It
    is placed at what its steps would cost, and so is a completed run that was not timed: a step costs what it costs at
    the nearest number of steps of the same rule, or in the median of the engine's other rules.
    """
    placed = []
    for engine in study.engines:
        points = [point for point in study.points if point.engine == engine]
        timed = [point for point in points if point.completed and point.cost is not None]
        for point in points:
            if point.completed and point.cost is not None:
                placed.append(Placed(point, point.cost, False))
            elif timed:
                placed.append(Placed(point, point.steps_per_revolution * _step_cost(point, timed), True))
    return tuple(placed)


def reference_seconds(study: SweepStudy, engine: str) -> float | None:
    """CPU time of a step of the engine's reference loop [s], in the median of its timings; None where there is none."""
    found = [p.timing.reference_seconds for p in study.points if p.engine == engine and p.timing is not None]
    return median(found) if found else None


def _step_cost(point: SweptPoint, timed: Sequence[SweptPoint]) -> float:
    """CPU time of a step [s]."""
    of_rule = [other for other in timed if other.rule == point.rule]
    if of_rule:
        wanted = math.log(point.steps_per_revolution)
        return _cost_per_step(min(of_rule, key=lambda p: abs(math.log(p.steps_per_revolution) - wanted)))
    return median(_cost_per_step(other) for other in timed)


def _cost_per_step(point: SweptPoint) -> float:
    return (point.cost or 0.0) / point.steps_per_revolution
