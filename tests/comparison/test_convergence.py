"""The observed order is found where there is one, and claimed nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from conrod.comparison.convergence import ORDER_GRID, PAIR_TOLERANCE, claimed_order, fit_floor, observed_order

STEPS = (125, 250, 500, 1000)
LONG = (125, 250, 500, 1000, 2000, 4000, 8000)


def errors(order: float, steps: tuple[int, ...] = STEPS, floor: float = 0.0, size: float = 1e-3) -> list[float]:
    """c h^p + floor."""
    return [size * (steps[0] / n) ** order + floor for n in steps]


@pytest.mark.parametrize("order", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("size", [1e-2, 1e-7])
def test_observed_order_recovers_pure_power(order: float, size: float) -> None:
    found = observed_order(STEPS, errors(order, size=size))
    assert found.claimed == pytest.approx(order, abs=1e-9)
    assert fit_floor(np.array(STEPS), np.array(errors(order, size=size))) == pytest.approx(0.0, abs=1e-9 * size)


@pytest.mark.parametrize("order", [2.0, 4.0])
@pytest.mark.parametrize("floor", [1e-8, 1e-10])
def test_observed_order_excludes_floor(order: float, floor: float) -> None:
    found = observed_order(LONG, errors(order, LONG, floor))
    assert fit_floor(np.array(LONG), np.array(errors(order, LONG, floor))) == pytest.approx(floor, rel=0.05)
    # What stands 20 times clear of the floor is biased by at most a twentieth at its last point.
    assert found.claimed == pytest.approx(order, abs=PAIR_TOLERANCE)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("floor", [0.0, 3e-7])
def test_fit_floor_has_no_negative_terms(seed: int, floor: float) -> None:
    """Of all orders, each fitted by scipy's non-negative least squares in relative errors."""
    scatter = np.random.default_rng(seed).uniform(0.7, 1.3, len(LONG))
    values = np.array(errors(2.0, LONG, floor)) * scatter
    fits, ones = [], np.ones(len(LONG))
    for order in ORDER_GRID:
        columns = np.stack([(LONG[0] / np.array(LONG)) ** order, ones], axis=1)
        terms, miss = nnls(columns / values[:, None], ones)
        fits.append((miss, terms[1]))
    assert fit_floor(np.array(LONG), values) == pytest.approx(min(fits)[1], rel=1e-6, abs=1e-20)


def test_fit_floor_is_zero_when_error_grows() -> None:
    assert fit_floor(np.array(STEPS), np.array([1e-4, 2e-4, 4e-4, 8e-4])) == 0.0


@pytest.mark.parametrize("seed", range(10))
def test_observed_order_claims_none_for_noise(seed: int) -> None:
    values = 10.0 ** np.random.default_rng(seed).uniform(-9, -3, len(LONG))
    assert observed_order(LONG, list(values)).claimed is None


def test_observed_order_claims_none_when_pairs_disagree() -> None:
    # Order 4 that turns into order 2: neither is the order.
    steps = np.array(LONG, dtype=float)
    h = steps[0] / steps
    found = observed_order(LONG, list(1e-3 * (h**4 + 0.02 * h**2)))
    assert found.claimed is None


def test_observed_order_comes_from_finest_points() -> None:
    """First order as long as the step is coarse, then second."""
    steps, errors_found = (100, 200, 400, 800, 1600), [16e-3, 8e-3, 4e-3, 1e-3, 2.5e-4]
    assert observed_order(steps, errors_found).claimed == pytest.approx(2.0, abs=1e-9)
    # Pairs that agree from the coarsest on alone are no order.
    assert observed_order(steps, [16e-3, 8e-3, 4e-3, 2e-3, 0.5e-3]).claimed is None


def test_observed_order_reports_order_and_plateau() -> None:
    values = errors(5.0, LONG, floor=4.5e-5, size=1.0)
    found = observed_order(LONG, values)
    assert found.claimed == pytest.approx(5.0, abs=PAIR_TOLERANCE)
    assert found.plateau == values[-1]


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_observed_order_claims_none_for_error_not_finite(bad: float) -> None:
    assert observed_order(STEPS, [*errors(2.0)[:3], bad]).claimed is None


def test_claimed_order_skips_runs_without_error() -> None:
    found = [(100, 4e-3), (200, None), (400, 2.5e-4), (800, 6.25e-5)]
    assert claimed_order(found) == pytest.approx(2.0, abs=1e-9)
    assert claimed_order([(100, None)]) is None
    assert claimed_order([]) is None
