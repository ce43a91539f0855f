"""What a setting saves against the engine's stock settings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.studies.cell import Cell
from conrod.studies.measurement import Measurement
from conrod.studies.timing import Timing


@dataclass(frozen=True)
class StockComparison:
    """A setting beside the stock ones at all steps of the grid, by quantity where it is a mapping.

    Attributes:
        digits: decimal digits gained at equal cost; None where no stock run is as cheap as this.
        best: least error that any stock run of the grid reaches; empty where none completed.
        cost_factor: how many times the cost is that the cheapest stock run within all tolerances has; None where the
            stock settings never get there.
    """

    digits: Mapping[str, float | None]
    best: Mapping[str, float]
    cost_factor: float | None


def compared_with_stock(
    measurement: Measurement,
    timing: Timing,
    stock: Sequence[Cell],
    measurements: Mapping[str, Measurement],
    timings: Mapping[str, Timing],
    allowed: Mapping[str, float],
) -> StockComparison:
    """A measured and timed setting beside completed stock runs.

    Args:
        stock: cells of the stock settings, at increasing numbers of steps; those without a timing do not count.
        allowed: largest error by quantity.
    """
    timed = [(timings[c.key].seconds_per_revolution, measurements[c.key]) for c in stock if c.key in timings]
    cost = timing.seconds_per_revolution
    within = [c for c, m in timed if all((m.largest(q) or 0.0) <= limit for q, limit in allowed.items())]
    digits: dict[str, float | None] = {}
    for quantity in allowed:
        errors = [(c, m.largest(quantity) or 0.0) for c, m in timed]
        digits[quantity] = _digits(errors, cost, measurement.largest(quantity) or 0.0)
    return StockComparison(
        digits=digits,
        best={q: min(m.largest(q) or 0.0 for _, m in timed) for q in allowed} if timed else {},
        cost_factor=min(within) / cost if within else None,
    )


def _digits(stock: Sequence[tuple[float, float]], cost: float, error: float) -> float | None:
    """Decimal digits between the stock error at a cost, interpolated between runs, and an error."""
    points = sorted(stock)
    if not points or cost < points[0][0] or error <= 0.0:
        return None
    costs, errors = (np.log([max(p[k], 1e-300) for p in points]) for k in (0, 1))
    return float(np.interp(math.log(cost), costs, errors) - math.log(error)) / math.log(10.0)
