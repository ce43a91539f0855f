"""A trajectory from a file of any of the formats, checked; to be called confined, for the file is a user's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.readable import check_readable
from conrod.own.tables.archives import Archive, open_npz, open_parquet
from conrod.own.tables.columns import Column, Request, choose
from conrod.own.tables.delimited import Wanted, read_numbers
from conrod.own.tables.layout import layout_of
from conrod.own.tables.quantity import CRANK_ACCELERATION, CRANK_ANGLE, CRANK_SPEED, TIME
from conrod.own.tables.samples import QUANTITIES, Observed, Samples

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
    if path.stat().st_size == 0:
        raise InvalidInput(f"{path}: it is empty")
    kind = path.suffix.lower()
    if kind == ".npz":
        return _from_archive(path, open_npz(path), points, asked)
    if kind == ".parquet":
        return _from_archive(path, open_parquet(path), points, asked)
    layout = layout_of(path)
    columns = _chosen(path, layout.headings, layout.units, points, asked)
    names = [column.target.name for column in columns]
    wanted = Wanted(path, layout, [column.index for column in columns], names)
    values, numbers = read_numbers(wanted, MOST_ROWS)
    return _reading(path, layout.headings, columns, values, numbers, layout.form)


def _chosen(
    path: Path, headings: Sequence[str], units: Sequence[str], points: Sequence[str], asked: Request
) -> list[Column]:
    try:
        return choose(headings, units, points, asked)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None


def _from_archive(path: Path, archive: Archive, points: Sequence[str], asked: Request) -> Reading:
    columns = _chosen(path, archive.headings, (), points, asked)
    lengths = {column.target.name: archive.rows[column.index] for column in columns}
    if len(set(lengths.values())) > 1:
        raise InvalidInput(f"{path}: columns of different lengths: {', '.join(f'{n} {k}' for n, k in lengths.items())}")
    count = lengths[TIME]
    if count > MOST_ROWS:
        raise InvalidInput(f"{path}: it has {count} rows: at most {MOST_ROWS} are kept: thin it out")
    values = np.column_stack([archive.column(column.index) for column in columns])
    return _reading(path, archive.headings, columns, values, np.arange(1, count + 1), archive.form)


def _reading(
    path: Path,
    headings: Sequence[str],
    columns: Sequence[Column],
    values: Array,
    numbers: NDArray[np.int64],
    form: str,
) -> Reading:
    _check_values(path, columns, values, numbers)
    count = len(values)
    values, numbers = _without_repeated(values, numbers, [column.target.name for column in columns].index(TIME))
    by_name = {column.target.name: values[:, k] * column.factor for k, column in enumerate(columns)}
    _check_times(path, by_name[TIME], numbers)
    used = {column.index for column in columns}
    return Reading(
        _observed(columns, by_name),
        tuple(columns),
        tuple(h for k, h in enumerate(headings) if k not in used),
        form,
        count - len(values),
    )


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


def _check_values(path: Path, columns: Sequence[Column], values: Array, numbers: NDArray[np.int64]) -> None:
    if len(values) < 2:
        raise InvalidInput(
            f"{path}: it has {len(values)} row{'s' * (len(values) != 1)} of numbers: at least 2 are needed"
        )
    with np.errstate(invalid="ignore"):
        bad = ~(np.abs(values * [column.factor for column in columns]) < LARGEST)
    if bad.any():
        row, place = np.argwhere(bad)[0]
        value, name = values[row, place], columns[place].target.name
        what = "is too large to be a motion" if np.isfinite(value) else "is not finite"
        raise InvalidInput(f"{path}: row {numbers[row]}: {name} = {value:g} {what}")


def _without_repeated(values: Array, numbers: NDArray[np.int64], time: int) -> tuple[Array, NDArray[np.int64]]:
    """Without the second row of each event: Modelica tools write two at one time, that say the same."""
    same = np.diff(values[:, time]) == 0.0
    if same.any():
        close = np.abs(np.diff(values, axis=0)) <= SAME * np.abs(values).max(axis=0)
        keep = np.append(True, ~(same & close.all(axis=1)))
        return values[keep], numbers[keep]
    return values, numbers


def _check_times(path: Path, times: Array, numbers: NDArray[np.int64]) -> None:
    backward = np.flatnonzero(np.diff(times) <= 0.0)
    if len(backward):
        k = int(backward[0])
        what = "repeated" if times[k + 1] == times[k] else "not in order"
        raise InvalidInput(
            f"{path}: times are {what}: {times[k + 1]:.9g} s in row {numbers[k + 1]} after {times[k]:.9g} s in row "
            f"{numbers[k]}"
        )
