"""Slips of a whole column that are found in its values: rows, components, a factor, another speed.

A hypothesis gives each row a range (2,) of values, those at the angles that are printed as its angle. It is a cause
where it reproduces the column, the wrong values in it too, and no other does as well.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conrod.exact.link_rotations import ROTATIONS
from conrod.exact.motion import Array
from conrod.mechanism.units import RPM, parse_quantity
from conrod.models.printed.exact_ranges import EVEN_TOLERANCE, exact_ranges, exact_values
from conrod.models.printed.fixed_slips import MIN_REPRODUCED, SYSTEMATIC_SHARE
from conrod.models.printed.rows import PRINTED_UNITS, TIME_COLUMN, PrintedRow
from conrod.models.printed.verdicts import TIE_WIDTH

MAX_LEFT_OVER = 1  # rows of a short column that a cause need not reproduce; of a long one a share
# Different wrong prints that a cause has to reproduce; a fitted number reproduces one of them by itself.
MIN_EXPLAINED, MIN_EXPLAINED_BY_FIT = MIN_REPRODUCED, MIN_REPRODUCED + 1
LENGTH_UNIT = re.compile("mm|cm|dm|m|inch|in|ft")  # at the begin of a printed unit
LENGTH_UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inches": 0.0254}  # [m]
ANGLE_FACTORS = {"deg in place of rad": 180.0 / math.pi, "rad in place of deg": math.pi / 180.0}
SPEED_FACTORS = {
    "deg/s taken for rad/s": 180.0 / math.pi,
    "rad/s taken for deg/s": math.pi / 180.0,
    "rpm taken for rad/s": 1.0 / RPM,
    "rad/s taken for rpm": RPM,
}
# Derivatives by time.
ORDERS = {name: order for names in (PRINTED_UNITS, ROTATIONS) for order, name in enumerate(names)}
MAX_DIGITS = 15  # of a double


def column_causes(
    rows: Sequence[PrintedRow], exact: Array, speed: tuple[str, float] | None = None
) -> Mapping[str, Array]:
    """Find the slips that reproduce a quantity's values, with the ranges (2, N) that they give; several if all fit.

    Args:
        exact: ranges (2, N) of the exact values.
        speed: another speed that reproduces the machine's rows, in words, and its ratio to the right one.
    """
    wrong = np.array([not is_accepted(row, *bounds) for row, bounds in zip(rows, exact.T, strict=True)])
    if not wrong.any():
        return {}
    found = {
        text: ranges
        for text, ranges in (*_row_slips(rows, exact), *_component_slip(rows))
        if _is_systematic(rows, ranges, wrong, MIN_EXPLAINED)
    }
    if speed is not None:
        found[speed[0]] = exact * speed[1] ** ORDERS[rows[0].quantity[1]]
    else:
        for text, ranges in _constant_factor(rows, exact):
            if _is_systematic(rows, ranges, wrong, MIN_EXPLAINED_BY_FIT):
                found[text] = ranges
    counts = {text: int(reproduced_rows(rows, ranges).sum()) for text, ranges in found.items()}
    return {text: found[text] for text in found if counts[text] == max(counts.values())}


def reproduced_rows(rows: Sequence[PrintedRow], ranges: Array) -> NDArray[np.bool_]:
    """Tell which printed values (N,) are roundings of a value in their ranges (2, N)."""
    value, half = _prints(rows)
    return np.asarray((value - half <= ranges[1]) & (value + half >= ranges[0]))


def is_accepted(row: PrintedRow, low: float, high: float) -> bool:
    """True if a print is the rounding of an exact value in a range, or has its further digits cut off."""
    value, half = row.number.value, 0.5 * row.number.last
    return low - half <= value <= high + half or row.number.is_truncation_of(low) or row.number.is_truncation_of(high)


def other_speed(columns: Sequence[Sequence[PrintedRow]]) -> tuple[str, float] | None:
    """Find the speed that reproduces a machine's printed velocities, accelerations and jerks, and its ratio.

    A speed of k times the right one makes derivatives of order n k^n times as large, at the same crank angle.

    Args:
        columns: the rows of one machine with one set of parameters, by quantity.

    Returns:
        The speed in words, and k; None where no speed reproduces the values of every order.
    """
    moving = [rows for rows in columns if ORDERS[rows[0].quantity[1]]]
    if not moving or any(row.fields.get(TIME_COLUMN) for rows in moving for row in rows):
        return None  # at another speed, a time stands for another angle
    exact = [exact_ranges(rows) for rows in moving]
    orders = [ORDERS[rows[0].quantity[1]] for rows in moving]
    bounds = [_ratio_bounds(rows, own) ** (1.0 / n) for rows, own, n in zip(moving, exact, orders, strict=True)]
    low, high = _most_common(np.concatenate(bounds, axis=1))
    if not 0.0 < low < high < math.inf:
        return None
    right = abs(moving[0][0].scene.speed)
    words, ratio = _speed_words(right, low, high)
    for order in set(orders):
        which = [k for k, own in enumerate(orders) if own == order]
        rows = [row for k in which for row in moving[k]]
        ranges = np.concatenate([exact[k] for k in which], axis=1)
        wrong = ~np.array([is_accepted(row, *own) for row, own in zip(rows, ranges.T, strict=True)])
        if not _is_systematic(rows, ranges * ratio**order, wrong, MIN_EXPLAINED_BY_FIT):
            return None
    if len(set(orders)) == 1:  # which a factor explains as well
        words = f"{_factor_words(moving[0], low ** orders[0], high ** orders[0])[0]}, or {words}"
    return words, ratio


def _is_systematic(rows: Sequence[PrintedRow], ranges: Array, wrong: NDArray[np.bool_], needed: int) -> bool:
    """True if ranges (2, N) reproduce a column but for a few rows, and enough different wrong (N,) values of it."""
    known = ~np.isnan(ranges[0])
    met = reproduced_rows(rows, ranges)
    left = max(MAX_LEFT_OVER, int((1.0 - SYSTEMATIC_SHARE) * known.sum()))
    different = {row.number.value for row, own in zip(rows, met & wrong, strict=True) if own}
    return len(different) >= needed and int((known & ~met).sum()) <= left


# -- hypotheses --------------------------------------------------------------------------------------------------------


def _row_slips(rows: Sequence[PrintedRow], exact: Array) -> list[tuple[str, Array]]:
    """Give each row the exact value of the row after or before it, with the ranges (2, N).

    The last row has that of a table that goes on in equal steps, or starts again; NaN where neither is its print.
    """
    slips = []
    for text, way in (("next", 1), ("previous", -1)):
        ranges, end = np.roll(exact, -way, axis=1), -1 if way == 1 else 0
        for beyond in (ranges[:, end].copy(), _value_beyond(rows, way), np.full(2, np.nan)):
            ranges[:, end] = beyond
            if reproduced_rows(rows, ranges)[end]:
                break
        slips.append((f"a slip by a row (the {text} row's values)", ranges))
    return slips


def _value_beyond(rows: Sequence[PrintedRow], way: int) -> Array:
    """Exact value, twice (2,), a step beyond the last row (`way` 1) or the first (-1); NaN if steps are not equal."""
    degrees = np.array([row.degrees for row in rows])[::way]
    steps = np.diff(degrees)
    if not len(steps) or np.ptp(steps) > EVEN_TOLERANCE * abs(steps[0]):
        return np.full(2, np.nan)
    return exact_values(rows[-1:], np.radians(degrees[-1:] + steps[-1])).repeat(2)


def _component_slip(rows: Sequence[PrintedRow]) -> list[tuple[str, Array]]:
    """Give x the values of y and the reverse, with the ranges (2, N); nothing for a size."""
    point, derivative, axis = rows[0].quantity
    other = {"x": "y", "y": "x"}.get(axis)
    if other is None:
        return []
    swapped = exact_ranges([replace(row, quantity=(point, derivative, other)) for row in rows])
    return [(f"a swap of components ({other} for {axis})", swapped)]


def _constant_factor(rows: Sequence[PrintedRow], exact: Array) -> list[tuple[str, Array]]:
    """Scale exact values by the factor that reproduces most rows; return ranges (2, N), empty if none does."""
    low, high = _most_common(_ratio_bounds(rows, exact))
    if not 0.0 < low < high < math.inf:
        return []
    text, ratio = _factor_words(rows, low, high)
    return [(text, ratio * exact)]


def _factor_words(rows: Sequence[PrintedRow], low: float, high: float) -> tuple[str, float]:
    """A factor within bounds, in words: of a known unit, or of the fewest digits; and its size."""
    unit = LENGTH_UNIT.match(rows[0].fields["unit"])
    own = parse_quantity("unit", f"1 {unit.group()}", "m") if unit else math.nan
    lengths = {f"{name} in place of {unit.group()}": own / size for name, size in LENGTH_UNITS.items()} if unit else {}
    for text, ratio in (*lengths.items(), *ANGLE_FACTORS.items()):
        if low <= ratio <= high and ratio != 1.0:
            return f"a factor of {ratio:.4g} ({text})", ratio
    ratio = _shortest_decimal(low, high)
    return f"a constant factor of {ratio:.10g}", ratio


def _speed_words(right: float, low: float, high: float) -> tuple[str, float]:
    """A speed within bounds, as a ratio to the right one [rad/s], in words, and its ratio."""
    for text, ratio in SPEED_FACTORS.items():
        if low <= ratio <= high:
            return f"another speed ({text})", ratio
    # In the unit that has fewer digits for the right speed, which is that of the document.
    unit, size = min((("rpm", RPM), ("rad/s", 1.0)), key=lambda one: len(f"{right / one[1]:.6g}"))
    found = _shortest_decimal(low * right / size, high * right / size)
    return f"another speed ({found:.10g} {unit} in place of {right / size:.6g} {unit})", found * size / right


# -- fits --------------------------------------------------------------------------------------------------------------


def _prints(rows: Sequence[PrintedRow]) -> tuple[Array, Array]:
    """Printed values (N,), and how far (N,) a value that is rounded to them may be from them."""
    last = np.array([row.number.last for row in rows])
    return np.array([row.number.value for row in rows]), last * (0.5 + TIE_WIDTH)


def _ratio_bounds(rows: Sequence[PrintedRow], exact: Array) -> Array:
    """Bounds (2, M) of the positive factors that turn exact values into prints, of the M rows where they are not 0."""
    value, half = _prints(rows)
    side = np.where(exact[0] > 0.0, 1.0, -1.0)
    least, largest = np.sort(side * exact, axis=0)
    low, high = side * value - half, side * value + half
    some = (least > 0.0) & np.isfinite(largest) & (high > 0.0)
    return np.array([np.maximum(low[some], 0.0) / largest[some], high[some] / least[some]])


def _most_common(bounds: Array) -> tuple[float, float]:
    """Interval that lies within most of the given intervals (2, M); (0, inf) without any."""
    if not bounds.size:
        return 0.0, math.inf
    ends = np.unique(bounds)
    middles = 0.5 * (ends[:-1] + ends[1:])
    inside = (bounds[0][:, None] <= middles) & (middles <= bounds[1][:, None])
    best = int(np.argmax(inside.sum(axis=0)))
    return float(ends[best]), float(ends[best + 1])


def _shortest_decimal(low: float, high: float) -> float:
    """The number of the fewest digits within bounds."""
    middle = 0.5 * (low + high)
    for digits in range(1, MAX_DIGITS):
        found = float(f"{middle:.{digits}g}")
        if low <= found <= high:
            return found
    return middle
