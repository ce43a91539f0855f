"""Observed order of convergence: e = c h^p + floor (docs/design.md, 'Convergence order')."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array

# An order is claimed if orders of consecutive pairs of runs differ by less, and errors exceed the floor by this factor.
PAIR_TOLERANCE = 0.1
MIN_FLOOR_RATIO = 20.0
ORDER_GRID = np.linspace(0.05, 6.0, 1191)
# Factors of safety of a numerical uncertainty if three runs show an order of at least `MIN_ORDER`, and if not.
SAFETY_FACTOR, SAFETY_FACTOR_WITHOUT_ORDER, MIN_ORDER = 1.25, 3.0, 0.5


@dataclass(frozen=True)
class ObservedOrder:
    """Result of a refinement study.

    Attributes:
        claimed: slope over the finest points, clear of the floor, whose pairs agree; None where there are not two.
        plateau: error of the finest point where it has stopped falling: the orders of the last two pairs have no size.
            None where it falls, or grows, to the end.
    """

    claimed: float | None
    plateau: float | None


def observed_order(steps: Sequence[int], errors: Sequence[float]) -> ObservedOrder:
    """Estimate the order of convergence from errors at increasing numbers of steps per revolution."""
    pairs = [_pair_order(steps[i : i + 2], errors[i : i + 2]) for i in range(len(steps) - 1)]
    still = len(pairs) > 1 and all(order is not None and abs(order) <= PAIR_TOLERANCE for order in pairs[-2:])
    plateau, known = errors[-1] if still else None, [p for p in pairs if p is not None]
    if len(known) < 2 or len(known) < len(pairs):
        return ObservedOrder(None, plateau)
    floor = fit_floor(np.asarray(steps), np.asarray(errors))
    clear = [i for i, e in enumerate(errors) if e > MIN_FLOOR_RATIO * floor]
    # The points clear of the floor are the coarse ones: a leading run.
    count = next((k for k, i in enumerate(clear) if i != k), len(clear))
    run = known[: max(count - 1, 0)]
    first = len(run) - 1
    while first > 0 and abs(run[first] - run[first - 1]) <= PAIR_TOLERANCE:
        first -= 1
    if len(run) - first < 2:
        return ObservedOrder(None, plateau)
    points = slice(first, count)
    slope = -float(np.polyfit(np.log(steps[points]), np.log(errors[points]), 1)[0])
    # An error that does not fall with the step is a plateau, and a plateau is a floor.
    return ObservedOrder(slope if slope > PAIR_TOLERANCE else None, plateau)


def claimed_order(errors: Iterable[tuple[int, float | None]]) -> float | None:
    """Order claimed from errors at increasing numbers of steps; runs without an error are left out."""
    known = [(steps, error) for steps, error in errors if error is not None]
    return observed_order([n for n, _ in known], [e for _, e in known]).claimed


def _pair_order(steps: Sequence[int], errors: Sequence[float]) -> float | None:
    """Observed order between two errors; None if either is zero or not finite."""
    if not all(0.0 < e < math.inf for e in errors):
        return None
    return math.log(errors[0] / errors[1]) / math.log(steps[1] / steps[0])


def fit_floor(steps: Array, errors: Array) -> float:
    """Floor >= 0 of the best fit e = c h^p + floor in relative least squares, over a fine grid of orders p."""
    shapes = (steps / steps[0]) ** -ORDER_GRID[:, None]
    columns = np.stack([shapes, np.ones_like(shapes)], axis=2) / errors[:, None]
    c, f = np.linalg.pinv(columns).sum(axis=2).T
    without = columns[:, :, 0].sum(axis=1) / (columns[:, :, 0] ** 2).sum(axis=1)
    c, f = np.where(f < 0.0, without, c), np.maximum(f, 0.0)
    misses = ((columns @ np.stack([c, f], axis=1)[:, :, None] - 1.0)[:, :, 0] ** 2).sum(axis=1)
    # Where the error grows towards finer steps no floor is fitted.
    return float(np.where(c > 0.0, f, 0.0)[np.where(c > 0.0, misses, math.inf).argmin()])


def numerical_uncertainty(
    path: Iterable[tuple[int, float | None]], steps: int, formal: int | None = None
) -> tuple[float | None, float, float] | None:
    """Order, limit at a step of zero, and uncertainty of an error's size, from the three finest runs.

    Roache's grid convergence index, as ASME V&V 20 has it: a factor of safety times the distance from that limit. An
    order counts up to the formal one (2 if none is stated), and as 1 if no order is observed (None).

    Args:
        steps: per revolution of the run whose uncertainty is estimated.

    Returns:
        None if fewer than three runs completed.
    """
    known = [(n, size) for n, size in path if size is not None]
    if len(known) < 3:
        return None
    (_, first), (n2, second), (n3, third) = known[-3:]
    coarse, fine, ratio = first - second, second - third, n3 / n2
    order = math.log(coarse / fine) / math.log(ratio) if fine and coarse / fine > 0.0 else 0.0
    shown = order >= MIN_ORDER
    limit = max(0.0, third - fine / (ratio ** (min(order, formal or 2) if shown else 1.0) - 1.0))
    own = next((size for n, size in known if n >= steps), third)
    return order if shown else None, limit, (SAFETY_FACTOR if shown else SAFETY_FACTOR_WITHOUT_ORDER) * abs(own - limit)
