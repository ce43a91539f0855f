"""A trajectory from a file of any of the formats, checked; to be called confined, for the file is a user's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.files import check_readable
from conrod.own.tables.archives import open_npz, open_parquet
from conrod.own.tables.columns import Column, Request, choose
from conrod.own.tables.headings import CRANK_ACCELERATION, CRANK_ANGLE, CRANK_SPEED, TIME
from conrod.own.tables.samples import QUANTITIES, Observed, Samples
from conrod.own.tables.text_tables import open_text

OPENERS = {".npz": open_npz, ".parquet": open_parquet}  # all else is text
# So many rows of two points with all their rates take a gigabyte, the exact motion beside them included (measured).
MOST_ROWS = 2_000_000
# Of the largest value of a column: rows of one time that differ by less say the same.
SAME = 1e-12
LARGEST = 1e30  # SI: squares of it are still numbers


@dataclass(frozen=True)
class Reading:
    """A table that was read.

    Attributes:
        observed: what it says, SI.
        columns: that were used.
        unused: headings of the others.
        form: how the file is written, in words.
        repeated: rows that said the same as the one before, and were left out.
    """

    observed: Observed
    columns: tuple[Column, ...]
    unused: tuple[str, ...]
    form: str
    repeated: int = 0


def read_table(path: Path, points: tuple[str, ...], asked: Request) -> Reading:
    """The trajectory in a file.

    Args:
        points: names of the scene's observed points.

    Raises:
        InvalidInput: the file or something in it cannot be used; says in which row.
    """
    check_readable(path)
    try:
        return _reading(path, points, asked)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None


def _reading(path: Path, points: tuple[str, ...], asked: Request) -> Reading:
    if path.stat().st_size == 0:
        raise InvalidInput("it is empty")
    source = OPENERS.get(path.suffix.lower(), open_text)(path)
    columns = choose(source.headings, source.units, points, asked)
    values, numbers = source.read(columns, MOST_ROWS)
    _check_values(columns, values, numbers)
    count = len(values)
    values, numbers = _without_repeated(values, numbers, [column.target.name for column in columns].index(TIME))
    by_name = {column.target.name: values[:, k] * column.factor for k, column in enumerate(columns)}
    _check_times(by_name[TIME], numbers)
    used = {column.index for column in columns}
    unused = tuple(heading for k, heading in enumerate(source.headings) if k not in used)
    return Reading(_observed(columns, by_name), tuple(columns), unused, source.form, count - len(values))


def _observed(columns: Sequence[Column], values: dict[str, Array]) -> Observed:
    points: dict[str, dict[str, Samples]] = {}
    for point in dict.fromkeys(column.target.point for column in columns if column.target.point):
        for quantity in QUANTITIES:
            own = [c.target for c in columns if (c.target.point, c.target.quantity) == (point, quantity)]
            if own:
                stacked = np.column_stack([values[target.name] for target in own])
                points.setdefault(point, {})[quantity] = Samples(stacked, tuple(target.axis for target in own))
    angle, rate, acceleration = (values.get(name) for name in (CRANK_ANGLE, CRANK_SPEED, CRANK_ACCELERATION))
    return Observed(values[TIME], angle, rate, acceleration, points)


def _check_values(columns: Sequence[Column], values: Array, numbers: NDArray[np.int64]) -> None:
    if len(values) < 2:
        raise InvalidInput(f"it has {len(values)} row{'s' * (len(values) != 1)} of numbers: at least 2 are needed")
    with np.errstate(invalid="ignore"):
        bad = ~(np.abs(values * [column.factor for column in columns]) < LARGEST)
    if bad.any():
        row, place = np.argwhere(bad)[0]
        value, name = values[row, place], columns[place].target.name
        what = "is too large to be a motion" if np.isfinite(value) else "is not finite"
        raise InvalidInput(f"row {numbers[row]}: {name} = {value:g} {what}")


def _without_repeated(values: Array, numbers: NDArray[np.int64], time: int) -> tuple[Array, NDArray[np.int64]]:
    """Without the second row of each event: Modelica tools write two at one time, that say the same."""
    same = np.diff(values[:, time]) == 0.0
    if not same.any():
        return values, numbers
    close = np.abs(np.diff(values, axis=0)) <= SAME * np.abs(values).max(axis=0)
    keep = np.append(True, ~(same & close.all(axis=1)))
    return values[keep], numbers[keep]


def _check_times(times: Array, numbers: NDArray[np.int64]) -> None:
    backward = np.flatnonzero(np.diff(times) <= 0.0)
    if len(backward):
        k = int(backward[0])
        what = "repeated" if times[k + 1] == times[k] else "not in order"
        raise InvalidInput(
            f"times are {what}: {times[k + 1]:.9g} s in row {numbers[k + 1]} after {times[k]:.9g} s in row {numbers[k]}"
        )
