"""Faults of sensors, fitted to a table: single rows, a gain, a drift, an offset, gravity in an accelerometer.

Each has one or two unknowns a column, and is tried on whole turns alone: over a part of a turn any smooth difference is
nearly a straight line, or nearly in proportion.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput, list_names
from conrod.exact.motion import Array
from conrod.models.tables.columns import CRANK_ANGLE, MOTION, quantities
from conrod.models.tables.errors import ERRORS, TableComparison
from conrod.models.tables.slides import Hypothesis

OUTLIER, GAIN, DRIFT, OFFSET, GRAVITY, SPEED = "outlier", "gain", "drift", "offset", "gravity", "crank speed"
SENSOR_FAULTS = (OUTLIER, GAIN, DRIFT, OFFSET, GRAVITY, SPEED)

MIN_ROWS = 20  # fewer show no outlier, and no law of a column
MAX_OUTLIER_SHARE = 0.02  # of all rows; more are no outliers
MAX_OUTLIER_LEFT = 0.05  # share of the largest error that other rows may have
MIN_TURNS = 0.99  # of the crank; a table of one turn may lack its last row
MAX_GAIN_ERROR = 0.2  # beyond it is another unit
# A change counts where it is at least this share of the largest one of the same kind: what is less is noise.
MIN_SHARE = 0.05
SAME_GAIN = 1e-3  # share of a gain's error by which columns of one gain may differ
STANDARD_GRAVITY, SAME_GRAVITY = 9.80665, 0.01  # [m/s^2], and the share by which it differs over the Earth
MAX_POSITION_PHASE, SPEED_STEPS = 0.5, 4  # [rad] that a wrong speed may lead to, and steps of its fit, by positions
MAX_NAMED_COLUMNS = 4  # columns that a cause names


def sensor_hypotheses(table: TableComparison) -> Iterator[Hypothesis]:
    """Undo gains, offsets and drifts of each quantity, and a wrong crank speed, in a table of whole turns."""
    if len(table.times) < MIN_ROWS or not _has_whole_turns(table):
        return
    for quantity in MOTION:
        if table.points(quantity):
            yield from _gain(table, quantity)
            yield from _offset(table, quantity)
            yield from _drift(table, quantity)
    yield from _crank_speed(table)


def outlier_hypotheses(table: TableComparison) -> Iterator[Hypothesis]:
    """Leave out the few rows with far larger errors than all others, for each error of a table."""
    count = len(table.times)
    for name in ERRORS if count >= MIN_ROWS else ():
        if not (sizes := list(table.sizes[name].values())):
            continue
        size = np.max(sizes, axis=0)
        rows: NDArray[np.intp] = np.flatnonzero(size > MAX_OUTLIER_LEFT * float(size.max()))
        if 0 < len(rows) <= max(1, int(MAX_OUTLIER_SHARE * count)):
            keep = np.setdiff1d(np.arange(count), rows)
            values = {column: own[keep] for column, own in table.values.items()}
            yield OUTLIER, _outlier_words(table, name, rows), replace(table, values=values), ERRORS


def _outlier_words(table: TableComparison, name: str, rows: NDArray[np.intp]) -> str:
    """Name the columns that are off in some rows, by how much, and when."""
    angle = np.abs(table.phases) if CRANK_ANGLE in table.values else np.zeros(len(table.times))
    others = np.delete(angle, rows)
    if name != "total" and float(angle[rows].min()) > float(others.max(initial=0.0)) / MAX_OUTLIER_LEFT + 1e-12:
        off = {CRANK_ANGLE: (float(angle[rows].max()), "rad")}
    else:
        sizes = {column: float(np.abs(own[rows]).max()) for column, own in _differences(table, name).items()}
        units = quantities(tuple(table.scene.lengths))
        off = {column: (size, units[column]) for column, size in _largest(sizes).items()}
    first = float(table.times[rows[0]])
    when = f"at {first:.6g} s" if len(rows) == 1 else f"the first at {first:.6g} s"
    sizes_text = list_names((f"{column} by {_text(*found)}" for column, found in off.items()), MAX_NAMED_COLUMNS)
    return f"{len(rows)} of {len(table.times)} rows ({when}) {'is' if len(rows) == 1 else 'are'} off: {sizes_text}"


# -- laws of a column --------------------------------------------------------------------------------------------------


def _gain(table: TableComparison, quantity: str) -> Iterator[Hypothesis]:
    """Undo gains g = v e / (e e) of columns v with exact values e, unless as far off as a wrong unit."""
    gains = dict[str, float]()
    for column, off in _differences(table, quantity).items():
        exact = table.values[column] - off
        if exact.any():  # what stands at 0 has no gain
            gains[column] = float(table.values[column] @ exact / (exact @ exact))
    found = _largest({column: abs(gain - 1.0) for column, gain in gains.items()})
    if not found or max(found.values()) > MAX_GAIN_ERROR:
        return
    values = {column: own / gains[column] if column in found else own for column, own in table.values.items()}
    wrong = [gains[column] for column in found]
    if np.ptp(wrong) <= SAME_GAIN * abs(wrong[0] - 1.0):
        size = ", or a machine of another size" if len(found) == len(gains) and quantity == "position" else ""
        are = "is" if len(found) == 1 else "are each"
        words = f"{list_names(found, MAX_NAMED_COLUMNS)} {are} {wrong[0]:.6g} times what it should be (a gain{size})"
        yield GAIN, words, replace(table, values=values), (quantity, "total")
    else:
        each = list_names((f"{column} by {gains[column]:.6g}" for column in found), MAX_NAMED_COLUMNS)
        yield GAIN, f"columns have gains of their own: {each}", replace(table, values=values), (quantity, "total")


def _offset(table: TableComparison, quantity: str) -> Iterator[Hypothesis]:
    """Undo constant offsets of columns, except offsets of positions that another origin explains."""
    means = {column: float(off.mean()) for column, off in _differences(table, quantity).items()}
    found = _largest({column: abs(mean) for column, mean in means.items()})
    if not found or (quantity == "position" and _is_common(means)):
        return
    values = {column: own - means[column] if column in found else own for column, own in table.values.items()}
    unit = quantities(tuple(table.scene.lengths))[next(iter(found))]
    each = list_names((f"{column} by {_text(means[column], unit)}" for column in found), MAX_NAMED_COLUMNS)
    undone, concerns = replace(table, values=values), (quantity, "total") if quantity == "position" else (quantity,)
    sizes = [math.hypot(*(means.get(f"{p}.a{axis}", 0.0) for axis in "xy")) for p in table.points(quantity)]
    if quantity == "acceleration" and all(abs(s - STANDARD_GRAVITY) <= SAME_GRAVITY * STANDARD_GRAVITY for s in sizes):
        yield GRAVITY, f"gravity is left in the accelerations, as an accelerometer has it: {each}", undone, concerns
    else:
        yield OFFSET, f"columns are offset: {each}", undone, concerns


def _is_common(means: Mapping[str, float]) -> bool:
    """True if all points have the same offset along each axis, as with another origin of the frame."""
    largest = max(map(abs, means.values()))
    return all(
        np.ptp([mean for column, mean in means.items() if column.endswith(axis)] or [0.0]) <= MIN_SHARE * largest
        for axis in "xy"
    )


def _drift(table: TableComparison, quantity: str) -> Iterator[Hypothesis]:
    """Undo straight lines in time, by least squares; offsets alone are no drift."""
    elapsed = table.times - table.times[0]
    form = np.column_stack([np.ones_like(elapsed), elapsed])
    lines = {column: np.linalg.lstsq(form, off, rcond=None)[0] for column, off in _differences(table, quantity).items()}
    span, offset = float(elapsed[-1]), max(abs(float(line[0])) for line in lines.values())
    found = _largest({column: abs(float(line[1])) * span for column, line in lines.items()})
    if not found or max(found.values()) <= MIN_SHARE * offset:
        return
    values = {column: own - form @ lines[column] if column in found else own for column, own in table.values.items()}
    unit = quantities(tuple(table.scene.lengths))[next(iter(found))]
    rates = (f"{column} by {_text(float(lines[column][1]), unit)} a second" for column in found)
    each = list_names(rates, MAX_NAMED_COLUMNS)
    yield DRIFT, f"columns drift: {each}", replace(table, values=values), (quantity, "total")


def _crank_speed(table: TableComparison) -> Iterator[Hypothesis]:
    """Undo another constant speed of the crank, by the slope of the table's crank angle."""
    slope = _speed_error(table)
    speed = table.scene.speed + slope
    if not slope or abs(slope) > MAX_GAIN_ERROR * abs(table.scene.speed):
        return
    undone = replace(table, scene=table.scene.with_parameters(speed=speed))
    own, nominal = (f"{one * 60.0 / (2.0 * np.pi):.6g} rpm" for one in (speed, table.scene.speed))
    yield SPEED, f"the crank turns at {own}, not at {nominal} (--set speed=..)", undone, ERRORS


def _speed_error(table: TableComparison) -> float:
    """Speed of the table's crank minus the scene's [rad/s], by its angle, or else by positions; 0 if it has neither.

    By positions r, in Newton's iteration: the phase is s t, and s -= (r . r' t) / (r' t . r' t).
    """
    if CRANK_ANGLE in table.values:
        return float(np.polyfit(table.times, table.phases, 1)[0])
    if not table.points("total"):
        return 0.0
    slope, limit = 0.0, MAX_POSITION_PHASE / float(np.abs(table.times).max())
    try:
        for _ in range(SPEED_STEPS):
            other = replace(table, scene=table.scene.with_parameters(speed=table.scene.speed + slope))
            off, form = other.normalised_differences("total"), table.times[:, None] * other.angle_derivatives("total")
            if not form.any():
                return 0.0
            slope -= float(np.sum(off * form) / np.sum(form * form))
            if abs(slope) > limit:
                return 0.0
    except (InvalidInput, ArithmeticError):
        return 0.0
    return slope


# -- columns -----------------------------------------------------------------------------------------------------------


def _has_whole_turns(table: TableComparison) -> bool:
    """True if the crank turns freely, and at least once in the table."""
    turns = (table.times[-1] - table.times[0]) / table.scene.period
    return table.scene.kinematics.mechanism.driver.span is None and bool(turns >= MIN_TURNS)


def _differences(table: TableComparison, name: str) -> dict[str, Array]:
    """Table minus exact motion (T,) of each column that an error is of."""
    found = dict[str, Array]()
    for point in table.points(name):
        found |= dict(zip(table.axes(name, point).values(), table.difference(name, point).T, strict=True))
    return found


def _largest(sizes: Mapping[str, float]) -> dict[str, float]:
    """Return the sizes that are not far below the largest."""
    largest = max(sizes.values(), default=0.0)
    return {name: size for name, size in sizes.items() if size > MIN_SHARE * largest}


def _text(size: float, unit: str) -> str:
    return f"{1e3 * size:.4g} mm" if unit == "m" else f"{size:.4g} {unit}"
