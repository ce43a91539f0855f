"""Clock offset and crank phase of a table, estimated where a user asks for them.

All of them shift the crank angle: the shift is looked for around the turn, and then by least squares.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.models.tables.columns import CRANK_ANGLE, TIME
from conrod.models.tables.errors import TableComparison

ESTIMABLE = ("time", "phase")
REVOLUTION = 2.0 * math.pi
# Rows that estimates are made from, and those that the turn is looked through with, evenly spread.
MAX_ESTIMATE_ROWS, SCAN_ROWS = 50_000, 300
SCAN_ANGLES = 120  # in a turn
PRECISION = 4.0 * float(np.finfo(float).eps)  # relative, of the sum of squares, of a step and of the slope
# Further Gauss-Newton steps, as a sum of squares says no more of a shift than the root of its own last digit.
GAUSS_NEWTON_STEPS = 3
MIN_DERIVATIVE = 1e-7  # a slope below this share of L leaves a shift undetermined


@dataclass(frozen=True)
class Estimate:
    """One estimated quantity, SI.

    Attributes:
        name: `time` is the table's clock minus the scene's, `phase` the crank angle at the scene's time 0, `zero` that
            where the table's own is 0.
        error: its standard error, for errors of one size (relative to L) that are independent from row to row.
        remaining: rms error that is left, divided by L; of the crank angle [rad] where a table has no positions.
    """

    name: str
    value: float
    error: float
    remaining: float


def check_estimated(names: Sequence[str]) -> tuple[str, ...]:
    """Check the names of quantities to estimate, and drop repeated ones.

    Raises:
        InvalidInput: a name is no quantity that can be estimated.
    """
    for name in names:
        if name not in ESTIMABLE:
            raise unknown_choice("thing to estimate", name, ESTIMABLE)
    return tuple(dict.fromkeys(names))


def estimate(table: TableComparison, asked: Sequence[str]) -> tuple[Estimate, ...]:
    """Estimate the clock offset or the crank phase of a table.

    Raises:
        InvalidInput: the table lacks the columns, or the rows, that the estimate needs.
    """
    what, has_places, has_angle = f"--estimate {','.join(asked)}", table.points("position"), CRANK_ANGLE in table.values
    if not has_places and not has_angle:
        raise InvalidInput(f"{what}: the table has no positions to estimate it from")
    if table.scene.kinematics.mechanism.driver.span is not None:
        raise InvalidInput(f"{what}: it would be looked for anywhere in a turn, and the input makes one pass")
    if len(asked) > 1 and not (has_places and has_angle):
        raise InvalidInput(f"{what}: at constant speed one looks like the other in this table: ask for one of them")
    found = tuple(_estimates(table.thin_rows(MAX_ESTIMATE_ROWS), asked))
    if undetermined := [one.name for one in found if math.isinf(one.error)]:
        raise InvalidInput(f"{what}: {undetermined[0]} cannot be determined: nothing in this table depends on it")
    return found


def _estimates(table: TableComparison, asked: Sequence[str]) -> Iterator[Estimate]:
    """Estimate the table's crank zero first, then the clock."""
    has_places, clock = table.points("position"), "time" if "time" in asked else "phase"
    if "phase" in asked and has_places and CRANK_ANGLE in table.values:
        yield Estimate("zero", *best_crank_shift(table, "position"))
    if has_places:
        shift, error, left = best_crank_shift(table, "total")
    else:
        off = table.phases
        spread = float(np.sum((off - off.mean()) ** 2))
        error, left = math.sqrt(spread / (len(off) - 1) / len(off)), math.sqrt(spread / len(off))
        shift = math.remainder(float(off.mean()), REVOLUTION)
    by = -table.scene.speed if clock == "time" else 1.0
    yield Estimate(clock, shift / by, error / abs(by), left)


def align_clock(table: TableComparison, estimates: Sequence[Estimate]) -> TableComparison:
    """Shift a table by the estimates to the scene's clock and crank zero."""
    for one in estimates:
        if one.name == "zero":
            table = shift_crank(table, one.value)
        else:
            by = -one.value if one.name == "time" else one.value / table.scene.speed
            table = table.change_columns(partial(np.add, by), TIME)
    return table


# -- shifts of the crank -----------------------------------------------------------------------------------------------


def shift_crank(table: TableComparison, by: float) -> TableComparison:
    """Add an angle [rad] to the table's crank angle."""
    return table.change_columns(partial(np.add, by), CRANK_ANGLE)


def best_crank_shift(table: TableComparison, name: str) -> tuple[float, float, float]:
    """The smallest shift of the crank that brings the exact positions nearest to a table's.

    Args:
        name: `total` at the nominal time, `position` at the table's own crank angle.

    Returns:
        The shift and its standard error [rad], infinite where nothing depends on it, and the rms error that is left,
        divided by L.
    """
    few, turns = table.thin_rows(SCAN_ROWS), np.arange(SCAN_ANGLES) * (REVOLUTION / SCAN_ANGLES)
    tiled = {column: np.tile(values, SCAN_ANGLES) for column, values in few.values.items()}
    tried = (
        replace(few, values=tiled, turn=np.repeat(turns, len(few.times)))
        .normalised_differences(name)
        .reshape(SCAN_ANGLES, -1)
    )

    def errors(by: Array) -> Array:
        return replace(table, turn=float(by[0])).normalised_differences(name).ravel()

    def slopes(by: Array) -> Array:
        return replace(table, turn=float(by[0])).angle_derivatives(name).reshape(-1, 1)

    start = turns[[np.argmin(np.sum(tried**2, axis=1))]]
    found = least_squares(errors, start, jac=slopes, method="lm", xtol=PRECISION, ftol=PRECISION, gtol=PRECISION)
    count, slope, squares = len(found.fun), float(np.linalg.norm(found.jac)), 2.0 * float(found.cost)
    if slope <= MIN_DERIVATIVE * math.sqrt(count):
        return math.remainder(float(found.x[0]), REVOLUTION), math.inf, math.sqrt(squares / count)
    by, pull = found.x, slopes(found.x).T @ errors(found.x)
    for _ in range(GAUSS_NEWTON_STEPS):
        further = by - pull / slope**2
        if abs(left := slopes(further).T @ errors(further)) >= abs(pull):
            break  # as far as it goes, or a table so far off that the slope alone does not lead there
        by, pull = further, left
    # Of independent errors of one size: the square root of s^2 / (J^T J), s^2 = r^T r / (N - 1).
    error = math.sqrt(squares / (count - 1)) / slope
    rms = math.sqrt(squares / (len(table.points(name)) * len(table.times)))
    return math.remainder(float(by[0]), REVOLUTION), error, rms
