"""Columns that stand still while the exact motion moves: dead, frozen, clipped or held sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conrod.exact.motion import Array
from conrod.models.tables.columns import AXES, CRANK_ANGLE, CRANK_SPEED, MOTION, quantities
from conrod.models.tables.errors import TableComparison

Mask = NDArray[np.bool_]

MIN_STUCK_ROWS = 5  # of a stretch in which a value is one and the same
SAME_VALUE_TOLERANCE = 1e-12  # of a column's largest value, by which one and the same value may differ
# The exact value moves by so much, of its travel in all rows, and by so many steps of the column's digits.
MIN_TRAVEL, MIN_TRAVEL_DIGITS = 0.02, 3.0
# Noise about a constant: of so little of the exact scatter, and with no memory from row to row (of white noise the
# differences have twice the variance of the values).
MAX_NOISE, MIN_ROUGHNESS = 0.1, 1.0
NOISE_STARTS = np.linspace(0.0, 0.9, 19)  # shares of the rows after which noise about a constant may begin


def stuck_rows(table: TableComparison) -> dict[str, Mask]:
    """Mask (T,) of rows where a column stands still while the exact motion moves, by column."""
    exact = _exact_columns(table)
    found = {name: _stuck_mask(table.values[name], exact[name]) for name in exact}
    speed = table.values.get(CRANK_SPEED)
    if speed is not None:
        found[CRANK_SPEED] = speed == 0.0  # at a prescribed speed no crank stands still
    return {name: rows for name, rows in found.items() if rows.any()}


def replace_stuck(table: TableComparison, stuck: Mapping[str, Mask]) -> TableComparison:
    """Replace values of stuck columns by the exact ones, so that they count as no error."""
    exact = _exact_columns(table) | {CRANK_SPEED: np.full(len(table.times), table.scene.speed)}
    values = {name: np.where(rows, exact[name], table.values[name]) for name, rows in stuck.items()}
    return replace(table, values={**table.values, **values})


def drop_stuck(table: TableComparison, stuck: Mapping[str, Mask]) -> TableComparison:
    """Drop columns that are stuck in most rows, then all rows with a stuck column."""
    kept = {name: values for name, values in table.values.items() if not (name in stuck and stuck[name].mean() > 0.5)}
    rows = ~np.any([stuck[name] for name in stuck if name in kept] or [np.zeros(len(table.times), bool)], axis=0)
    return replace(table, values={name: values[rows] for name, values in kept.items()})


def stuck_words(table: TableComparison, stuck: Mapping[str, Mask]) -> str:
    """Describe which columns are stuck, where, and at what value."""
    return "; ".join(_column_words(table, name, rows) for name, rows in stuck.items())


def _exact_columns(table: TableComparison) -> dict[str, Array]:
    """Exact values (T,), at the nominal time, of the table's columns of motion and crank angle."""
    exact = {CRANK_ANGLE: table.nominal_angle}
    for point in table.scene.lengths:
        motion = table.motion_at_nominal_crank.point(point)
        for quantity, (letter, _) in MOTION.items():
            both = getattr(motion, quantity)
            exact |= {f"{point}.{letter}{axis}": both[:, k] for k, axis in enumerate(AXES)}
    return {name: values for name, values in exact.items() if name in table.values}


def _stuck_mask(values: Array, exact: Array) -> Mask:
    """Mask (T,) of rows with one value, or noise about one value, while the exact value travels."""
    stuck, travel = np.zeros(len(values), dtype=bool), float(np.ptp(exact))
    if travel <= SAME_VALUE_TOLERANCE * float(np.abs(exact).max()):
        return stuck  # it has nowhere to go
    steps = np.abs(np.diff(values))
    moving = steps > SAME_VALUE_TOLERANCE * float(np.abs(values).max())
    digit = float(steps[moving].min()) if moving.any() else 0.0
    edges = np.flatnonzero(np.concatenate([[True], moving, [True]]))
    for begin, end in pairwise(edges):
        by = float(np.ptp(exact[begin:end]))
        if end - begin >= MIN_STUCK_ROWS and by > max(MIN_TRAVEL * travel, MIN_TRAVEL_DIGITS * digit):
            stuck[begin:end] = True
    for begin in (NOISE_STARTS * len(values)).astype(int):
        some, meant = values[begin:], exact[begin:]
        small = len(some) > 2 * MIN_STUCK_ROWS and 0.0 < np.std(some) < MAX_NOISE * np.std(meant)
        if small and np.var(np.diff(some)) > MIN_ROUGHNESS * np.var(some):
            stuck[begin:] = True
            break
    return stuck


def _column_words(table: TableComparison, name: str, rows: Mask) -> str:
    """Describe how one column is stuck."""
    values, times = table.values[name], table.times
    unit = quantities(tuple(table.scene.lengths))[name]
    at, places = values[rows], np.flatnonzero(rows)
    value = f"{float(np.median(at)):.4g} {unit}"
    stretches = int(np.count_nonzero(np.diff(places) > 1)) + 1
    noise = "" if np.ptp(at) <= SAME_VALUE_TOLERANCE * np.abs(values).max() else f" but for {np.ptp(at):.2g} {unit}"
    changes = int(np.count_nonzero(np.diff(at)[np.diff(places) == 1]))
    if 0 < changes < len(at) // 2:  # with noise nearly every row has another value
        return f"{name} is held at one value for rows on end, in {len(places)} of {len(rows)} rows"
    if rows.all():
        return f"{name} does not change: it is {value}{noise} in all {len(rows)} rows"
    if stretches == 1 and rows[-1]:
        return f"{name} is frozen at {value}{noise} from {times[places[0]]:.6g} s on"
    if set(np.unique(at)) <= {values.max(), values.min()}:
        limits = " and ".join(f"{limit:.4g} {unit}" for limit in np.unique(at))
        return f"{name} is cut off at {limits}, in {len(places)} of {len(rows)} rows"
    if stretches == 1:
        return f"{name} stands still at {value} from {times[places[0]]:.6g} to {times[places[-1]]:.6g} s"
    return f"{name} stands still in {stretches} stretches, {len(places)} of {len(rows)} rows"
