"""A trajectory from a file of any of the formats, checked; to be called confined, for the file is a user's."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.files import check_readable, of_file
from conrod.own.tables.columns import Column, Request, Source, choose
from conrod.own.tables.headings import CRANK_ACCELERATION, CRANK_ANGLE, CRANK_SPEED, TIME
from conrod.own.tables.samples import QUANTITIES, Observed, Samples
from conrod.own.tables.text_tables import open_text

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
    with of_file(path):
        if path.stat().st_size == 0:
            raise InvalidInput("it is empty")
        source = _open_npz(path) if path.suffix.lower() == ".npz" else open_text(path)
        columns = choose(source.headings, points, asked)
        values, numbers = source.read(columns, MOST_ROWS)
        used = {column.index for column in columns}
        unused = tuple(heading for k, heading in enumerate(source.headings) if k not in used)
        return reading_of(columns, values, numbers, unused, source.form)


def reading_of(
    columns: Sequence[Column], values: Array, numbers: NDArray[np.int64], unused: tuple[str, ...], form: str
) -> Reading:
    """Values (T, columns) in the units of their columns, checked; further arguments as of `Reading`.

    Args:
        numbers: of the rows (T,), for messages.

    Raises:
        InvalidInput: a value is no number, or times are not in order; says in which row.
    """
    count = len(values)
    if count < 2:
        raise InvalidInput(f"it has {count} row{'s' * (count != 1)} of numbers: at least 2 are needed")
    with np.errstate(invalid="ignore"):
        bad = ~(np.abs(values * [column.factor for column in columns]) < LARGEST)
    if bad.any():
        row, place = np.argwhere(bad)[0]
        value, name = values[row, place], columns[place].target.name
        what = "is too large to be a motion" if np.isfinite(value) else "is not finite"
        raise InvalidInput(f"row {numbers[row]}: {name} = {value:g} {what}")
    keep = _new(values, [column.target.name for column in columns].index(TIME))
    values, numbers = values[keep], numbers[keep]
    by_name = {column.target.name: values[:, k] * column.factor for k, column in enumerate(columns)}
    times = by_name[TIME]
    for k in np.flatnonzero(np.diff(times) <= 0.0)[:1]:
        what = "repeated" if times[k + 1] == times[k] else "not in order"
        raise InvalidInput(
            f"times are {what}: {times[k + 1]:.9g} s in row {numbers[k + 1]} after {times[k]:.9g} s in row {numbers[k]}"
        )
    return Reading(_observed(columns, by_name), tuple(columns), unused, form, count - len(values))


def _new(values: Array, time: int) -> NDArray[np.bool_]:
    """Rows (T,) but for the second one of each event: Modelica tools write two at one time, that say the same."""
    keep, first = np.full(len(values), True), np.flatnonzero(np.diff(values[:, time]) == 0.0)
    close = np.abs(values[first + 1] - values[first]) <= SAME * np.abs(values).max(axis=0)
    keep[first[close.all(axis=1)] + 1] = False
    return keep


def _observed(columns: Sequence[Column], values: dict[str, Array]) -> Observed:
    points: dict[str, dict[str, Samples]] = {}
    for point in dict.fromkeys(column.target.point for column in columns if column.target.point):
        for quantity in QUANTITIES:
            own = [c.target for c in columns if (c.target.point, c.target.quantity) == (point, quantity)]
            if own:
                stacked = np.column_stack([values[target.name] for target in own])
                points.setdefault(point, {})[quantity] = Samples(stacked, tuple(target.axis for target in own))
    angle, rate, acceleration = map(values.get, (CRANK_ANGLE, CRANK_SPEED, CRANK_ACCELERATION))
    return Observed(values[TIME], angle, rate, acceleration, points)


# -- archives ----------------------------------------------------------------------------------------------------------


def _open_npz(path: Path) -> Source:
    """A numpy archive: an array (T,) a column, (T, 2) for x and y.

    Raises:
        InvalidInput: it is no such archive, or holds what would have to be executed to be read.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as loaded:
            every = {name: np.asarray(loaded[name]) for name in loaded.files}
    except (OSError, ValueError, OverflowError, zipfile.BadZipFile, EOFError, KeyError, RuntimeError, zlib.error):
        raise InvalidInput("it is no numpy archive, or holds Python objects, which are not loaded") from None
    arrays = dict[str, Array]()
    for name, array in every.items():
        if array.dtype.kind in "fiu" and array.ndim == 1:
            arrays[name] = array
        elif array.dtype.kind in "fiu" and array.ndim == 2 and array.shape[1] == 2:
            arrays |= {f"{name}.{axis}": array[:, k] for k, axis in enumerate("xy")}
    names = tuple(arrays)

    def read(wanted: Sequence[Column], most: int) -> tuple[Array, NDArray[np.int64]]:
        found = {column.target.name: np.asarray(arrays[names[column.index]], dtype=float) for column in wanted}
        lengths = {name: len(values) for name, values in found.items()}
        if len(set(lengths.values())) > 1:
            raise InvalidInput(f"columns of different lengths: {', '.join(f'{n} {k}' for n, k in lengths.items())}")
        if (rows := max(lengths.values())) > most:
            raise InvalidInput(f"it has {rows} rows: at most {most} are kept: thin it out")
        return np.column_stack(list(found.values())), np.arange(1, rows + 1)

    return Source("numpy archive", names, read)
