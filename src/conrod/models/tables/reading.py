"""Read and check a trajectory from a file of any of the formats; for `call_on_file`, since the file is a user's."""

from __future__ import annotations

import csv
import re
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.models.tables.columns import TIME, Column, ColumnRequest, bare_unit, choose_columns, split_heading
from conrod.user_files.encodings import decode_text
from conrod.user_files.files import check_readable, name_file_in_errors

# With two points and all their derivatives so many rows take a gigabyte with the exact motion (measured).
MAX_TABLE_ROWS = 2_000_000
# Two rows of one time are repeated where they differ by less than this share of each column's largest value.
REPEATED_ROW_TOLERANCE = 1e-12
VALUE_LIMIT = 1e30  # SI: squares of it are still numbers


# The form of a file in words, the headings of all columns, and a function that reads columns: their values (T, columns)
# and the line number of each row (T,).
OpenTable: TypeAlias = tuple[str, tuple[str, ...], Callable[[Sequence[Column]], tuple[Array, NDArray[np.int64]]]]


@dataclass(frozen=True)
class Reading:
    """A table as it was read.

    Attributes:
        values: SI, (T,) by name of the quantity.
        columns: columns that were used.
        unused: headings of the others.
        form: format of the file, in words.
        repeated: rows that said the same as the one before, and were left out.
    """

    values: Mapping[str, Array]
    columns: tuple[Column, ...]
    unused: tuple[str, ...]
    form: str
    repeated: int = 0


def read_table(path: Path, points: tuple[str, ...], request: ColumnRequest) -> Reading:
    """Read the trajectory in a file.

    Args:
        points: names of the scene's observed points.

    Raises:
        InvalidInput: the file or something in it cannot be used; says in which row.
    """
    check_readable(path)
    with name_file_in_errors(path):
        if path.stat().st_size == 0:
            raise InvalidInput("it is empty")
        form, headings, read = open_table(path, request)
        columns = choose_columns(headings, points, request)
        values, numbers = read(columns)
        used = {column.index for column in columns}
        unused = tuple(heading for k, heading in enumerate(headings) if k not in used)
        return check_values(columns, values, numbers, unused, form)


def open_table(path: Path, request: ColumnRequest) -> OpenTable:
    """Open a file as a numpy archive or as text, by its suffix."""
    if path.suffix.lower() == ".npz":
        return _open_npz(path)
    return _open_text(path, tuple(request.columns.values()))


def check_values(
    columns: Sequence[Column], values: Array, numbers: NDArray[np.int64], unused: tuple[str, ...], form: str
) -> Reading:
    """Check values (T, columns) in the units of their columns; further arguments as in `Reading`.

    Args:
        numbers: line numbers (T,) of the rows, for messages.

    Raises:
        InvalidInput: a value is no number, or times are not in order; says in which row.
    """
    count = len(values)
    if count < 2:
        raise InvalidInput(f"it has {count} row{'s' * (count != 1)} of numbers: at least 2 are needed")
    with np.errstate(invalid="ignore"):
        bad = ~(np.abs(values * [column.factor for column in columns]) < VALUE_LIMIT)
    if bad.any():
        row, place = np.argwhere(bad)[0]
        value = values[row, place]
        what = "is too large to be a motion" if np.isfinite(value) else "is not finite"
        raise InvalidInput(f"row {numbers[row]}: {columns[place].name} = {value:g} {what}")
    keep = _mask_repeated_events(values, [column.name for column in columns].index(TIME))
    values, numbers = values[keep], numbers[keep]
    by_name = {column.name: values[:, k] * column.factor for k, column in enumerate(columns)}
    times = by_name[TIME]
    for k in np.flatnonzero(np.diff(times) <= 0.0)[:1]:
        what = "repeated" if times[k + 1] == times[k] else "not in order"
        raise InvalidInput(
            f"times are {what}: {times[k + 1]:.9g} s in row {numbers[k + 1]} after {times[k]:.9g} s in row {numbers[k]}"
        )
    return Reading(by_name, tuple(columns), unused, form, count - len(values))


def _mask_repeated_events(values: Array, time: int) -> NDArray[np.bool_]:
    """Mask (T,) without the second of two equal rows at one time, which Modelica tools write at events."""
    keep, first = np.full(len(values), True), np.flatnonzero(np.diff(values[:, time]) == 0.0)
    close = np.abs(values[first + 1] - values[first]) <= REPEATED_ROW_TOLERANCE * np.abs(values).max(axis=0)
    keep[first[close.all(axis=1)] + 1] = False
    return keep


def _check_rows(rows: int) -> None:
    if rows > MAX_TABLE_ROWS:
        raise InvalidInput(f"it has {rows} rows: at most {MAX_TABLE_ROWS} are kept: thin it out")


# -- archives ----------------------------------------------------------------------------------------------------------


def _open_npz(path: Path) -> OpenTable:
    """Open a numpy archive: an array (T,) is a column, an array (T, 2) is x and y."""
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

    def read_columns(wanted: Sequence[Column]) -> tuple[Array, NDArray[np.int64]]:
        found = {column.name: np.asarray(arrays[names[column.index]], dtype=float) for column in wanted}
        lengths = {name: len(values) for name, values in found.items()}
        if len(set(lengths.values())) > 1:
            raise InvalidInput(f"columns of different lengths: {', '.join(f'{n} {k}' for n, k in lengths.items())}")
        rows = max(lengths.values())
        _check_rows(rows)
        return np.column_stack(list(found.values())), np.arange(1, rows + 1)

    return "numpy archive", names, read_columns


# -- text, whatever its separator and decimal mark ---------------------------------------------------------------------


LAYOUT_ROWS = 400  # rows that the layout is derived from
BLANKS = " "  # as a separator: any run of blanks
SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", BLANKS: "blanks"}
# Separators with decimal marks. Where two fit equally well the earlier is taken: `0, 1, 2` is separated by commas.
LAYOUTS = ((";", "."), (";", ","), ("\t", "."), ("\t", ","), (",", "."), (BLANKS, "."), (BLANKS, ","))
NUMBERS = {
    ".": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"),
    ",": re.compile(r"[+-]?(\d+,?\d*|,\d+)([eE][+-]?\d+)?"),
}
COMMENT = re.compile(r"\s*[#%]+\s?")
# A heading of a table separated by blanks: a word, with its unit if that is in brackets.
WORD = re.compile(r"\S+(?:\s[\[(][^\])]*[\])])?")
MIN_ROW_NUMBERS = 2  # numbers that a row of numbers has at least: other columns may be text

NumberedLine = tuple[int, str]  # its number in the file from 1, its text


def _open_text(path: Path, wanted: Sequence[str]) -> OpenTable:
    """Open a table of text, with the layout that its first rows show.

    Args:
        wanted: headings that a user names, which tell in what encoding the text is.
    """
    text, encoding = decode_text(path.read_bytes(), wanted)
    # Rows of empty cells are blank, too.
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip('";,\t ')]
    rows = [line for line in lines if not COMMENT.match(line[1])]
    found = {way: _measure_layout(rows[:LAYOUT_ROWS], *way) for way in LAYOUTS}
    separator, decimal = max(LAYOUTS, key=lambda way: found[way][0])
    numbers, first, width = found[separator, decimal]
    if not numbers:
        raise InvalidInput(
            f"there is no row of numbers with at least two columns in its first {LAYOUT_ROWS} rows; give times in "
            "seconds, not as dates"
        )
    above = [
        COMMENT.sub("", line, count=1) if COMMENT.match(line) else line for number, line in lines if number < first
    ]
    headings = _find_headings(
        [WORD.findall(line) if separator == BLANKS else split_cells(line, separator) for line in above], width
    )
    rows = [line for line in rows if line[0] >= first]

    def read_columns(columns: Sequence[Column]) -> tuple[Array, NDArray[np.int64]]:
        return _read_numbers(rows, columns, separator, decimal, width)

    marks = {".": "decimal points", ",": "decimal commas"}
    form = f"text, separated by {SEPARATORS[separator]}, {marks[decimal]}"
    return form if encoding == "UTF-8" else f"{form}, {encoding}", headings, read_columns


def split_cells(line: str, separator: str) -> list[str]:
    """Split a line into cells, without the blanks around them."""
    if separator == BLANKS:
        return [cell.strip('"') for cell in line.split()]
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
    except csv.Error as error:
        raise InvalidInput(f"it is no table of numbers: {error}") from None


def _measure_layout(sample: Sequence[NumberedLine], separator: str, decimal: str) -> tuple[int, int, int]:
    """Count the numbers in rows of the most common width; return that count, the first such line, and the width."""
    rows = [(number, split_cells(line, separator)) for number, line in sample]
    counted = [(number, len(row), sum(map(bool, map(NUMBERS[decimal].fullmatch, row)))) for number, row in rows]
    numeric = [one for one in counted if one[2] >= MIN_ROW_NUMBERS]
    if not numeric:
        return 0, 0, 0
    width = Counter(wide for _, wide, _ in numeric).most_common(1)[0][0]
    own = [(number, numbers) for number, wide, numbers in numeric if wide == width]
    return sum(numbers for _, numbers in own), own[0][0], width


def _find_headings(above: Sequence[list[str]], width: int) -> tuple[str, ...]:
    """Headings from the last row above the numbers, units from a row under it; column numbers from 1 without any.

    Above the row of names there may be titles and remarks.
    """
    fitting = [row for row in above if len(row) == width] or [[str(k + 1) for k in range(width)]]
    units = [unit for unit in map(bare_unit, fitting[-1]) if unit is not None]
    if len(fitting) == 1 or len(units) < width:
        return tuple(fitting[-1])
    pairs = zip(fitting[-2], units, strict=True)
    return tuple(name if unit in ("", split_heading(name)[1]) else f"{name} [{unit}]" for name, unit in pairs)


def _read_numbers(
    rows: Sequence[NumberedLine], columns: Sequence[Column], separator: str, decimal: str, width: int
) -> tuple[Array, NDArray[np.int64]]:
    """Read values (T, columns), and the line number of each row (T,); a million rows take a few seconds."""
    _check_rows(len(rows))
    for number, line in rows:
        # Cells left out at the end of a row are empty; what stands beyond the last heading belongs nowhere.
        if line.count(separator) >= width and any(split_cells(line, separator)[width:]):
            raise InvalidInput(f"row {number} has more than the {width} cells of the table's columns")
    plain = (line if decimal == "." else line.replace(",", ".") for _, line in rows)
    delimiter, places = None if separator == BLANKS else separator, [column.index for column in columns]
    try:
        values = np.loadtxt(plain, delimiter=delimiter, usecols=places, comments=None, quotechar='"', ndmin=2)
    except ValueError as error:
        for number, line in rows:
            for column in columns:
                cell = "".join(split_cells(line, separator)[column.index : column.index + 1])
                if not NUMBERS[decimal].fullmatch(cell) and cell.lower().lstrip("+-") not in ("nan", "inf", "infinity"):
                    what = f"{column.name} = {cell!r} is no number (a time is in seconds, no date)"
                    raise InvalidInput(f"row {number}: {what}") from None
        raise InvalidInput(f"its rows cannot be read as numbers: {error}") from None
    return values, np.array([number for number, _ in rows])
