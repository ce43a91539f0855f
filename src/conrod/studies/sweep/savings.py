"""Savings of a setting over the stock ones: digits at equal cost, and cost within the same tolerances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.studies.frame.timing import Timing
from conrod.studies.sweep.step_search import Choice, Tolerances


@dataclass(frozen=True)
class Savings:
    """A setting beside the stock ones at all steps of the grid, by quantity where it is a mapping.

    Attributes:
        digits: decimal digits gained at equal cost; None where no stock run is as cheap as this.
        best: least error that any stock run reaches; empty where none completed.
        cost_factor: cost of the cheapest stock run within all tolerances over this one's; None where there is none.
    """

    digits: Mapping[str, float | None]
    best: Mapping[str, float]
    cost_factor: float | None


def savings_of(choice: Choice, stock: Sequence[Choice], timings: Mapping[str, Timing], allowed: Tolerances) -> Savings:
    """A timed setting beside completed stock runs; at a cost count only those with a timing."""
    cost, own = timings[choice.case.key].seconds_per_revolution, choice.errors(allowed)
    timed = [(timings[one.case.key].seconds_per_revolution, one) for one in stock if one.case.key in timings]
    within = [c for c, one in timed if one.excess(allowed) <= 1.0]
    errors = {q: sorted((c, one.errors(allowed)[q]) for c, one in timed) for q in allowed}
    return Savings(
        digits={q: _digits(errors[q], cost, own[q]) for q in allowed},
        best={q: min(one.errors(allowed)[q] for one in stock) for q in allowed if stock},
        cost_factor=min(within) / cost if within else None,
    )


def _digits(stock: Sequence[tuple[float, float]], cost: float, error: float) -> float | None:
    """Decimal digits between the stock error at a cost, interpolated between (cost, error), and an error."""
    if not stock or cost < stock[0][0] or error <= 0.0:
        return None
    costs, errors = (np.log([max(p[k], 1e-300) for p in stock]) for k in (0, 1))
    return float(np.interp(math.log(cost), costs, errors) - math.log(error)) / math.log(10.0)
