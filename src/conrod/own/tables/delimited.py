"""Numbers of large text tables by pyarrow, where that is installed: the same numbers, sooner.

A million rows of five numbers are read in 2.0 s instead of 2.9 s (means of two runs each, in turns).

Both read the nearest double. What pyarrow does not take for rows of numbers of one width is left to the slow way, which
names what is wrong.

Numbers of a text table, read in pieces: a million rows take a few seconds, and what is no number is named.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.layout import BLANKS, CLOCK, COMMENT, NUMBERS, Layout, cells
from conrod.own.tables.text import blocks

# Below so many bytes loading pyarrow takes longer than it saves.
LARGE = 4_000_000


@cache
def _arrow_csv() -> Any:
    try:
        import pyarrow.csv
    except ImportError:
        return None
    return pyarrow.csv


def numbers_by_arrow(texts: Sequence[str], layout: Layout, places: Sequence[int]) -> Array | None:
    """Some columns (T, columns) of rows of text; None where they have to be read in another way.

    Args:
        texts: rows without the ends of their lines.
        places: of the columns.
    """
    csv = _arrow_csv()
    # Runs of blanks are one separator here, and many there.
    if csv is None or layout.separator == BLANKS or layout.decimal != ".":
        return None
    import pyarrow

    names = [str(place) for place in range(len(layout.headings))]
    wanted = [names[place] for place in places]
    try:
        table = csv.read_csv(
            pyarrow.py_buffer("\n".join(texts).encode()),
            read_options=csv.ReadOptions(column_names=names, use_threads=False),
            parse_options=csv.ParseOptions(delimiter=layout.separator),
            convert_options=csv.ConvertOptions(
                include_columns=wanted, column_types=dict.fromkeys(wanted, pyarrow.float64()), null_values=[]
            ),
        )
    except pyarrow.ArrowException:
        return None
    if table.num_rows != len(texts):
        return None
    return np.column_stack([table.column(name).to_numpy() for name in wanted])


class Piece(NamedTuple):
    """Rows of a table: their lines in the file (T,), and their texts."""

    numbers: NDArray[np.int64]
    texts: list[str]


def read_numbers(
    path: Path, layout: Layout, places: Sequence[int], names: Sequence[str], most: int
) -> tuple[Array, NDArray[np.int64]]:
    """Some columns of a text table.

    Args:
        places: of the columns.
        names: of them, for errors.
        most: rows that are kept.

    Returns:
        Their values (T, columns) and the line of each row (T,).

    Raises:
        InvalidInput: a cell that is no number, or more rows than are kept.
    """
    values, numbers, count = [], [], 0
    large = path.stat().st_size > LARGE
    for piece in _pieces(path, layout):
        count += len(piece.texts)
        if count > most:
            raise InvalidInput(f"{path}: it has more than {most} rows, which is the most that is kept: thin it out")
        fast = numbers_by_arrow(piece.texts, layout, places) if large else None
        values.append(_converted(path, piece, layout, places, names) if fast is None else fast)
        numbers.append(piece.numbers)
    return np.concatenate(values), np.concatenate(numbers)


def _pieces(path: Path, layout: Layout) -> Iterator[Piece]:
    # Spreadsheets end tables with rows of empty cells; comments may stand anywhere.
    void = f'{layout.separator}" \t\r\n'
    for first, block in blocks(path, layout.encoding):
        start = max(layout.first - first, 0)
        keep = [k for k, line in enumerate(block) if k >= start and line.strip(void)]
        texts = block if len(keep) == len(block) else [block[k] for k in keep]
        if any(line[0] in "#%/ \t" for line in texts):
            keep = [k for k in keep if not COMMENT.match(block[k])]
            texts = [block[k] for k in keep]
        if texts:
            yield Piece(first + np.array(keep), texts)


def _converted(path: Path, piece: Piece, layout: Layout, places: Sequence[int], names: Sequence[str]) -> Array:
    texts, marks = piece.texts, len(layout.headings) - 1
    if layout.separator == BLANKS:
        odd = any(len(line.split()) != marks + 1 for line in texts)
    else:
        odd = any(line.count(layout.separator) != marks for line in texts)
    if odd:
        _check_widths(path, piece, layout)
    if layout.decimal == ",":
        texts = [line.replace(",", ".") for line in texts]
    try:
        return np.loadtxt(
            texts,
            delimiter=None if layout.separator == BLANKS else layout.separator,
            usecols=places,
            comments=None,
            quotechar='"',
            ndmin=2,
        )
    except ValueError:
        rows = zip(piece.numbers.tolist(), piece.texts, strict=True)
        return np.array([_row(path, number, line, layout, places, names) for number, line in rows])


def _check_widths(path: Path, piece: Piece, layout: Layout) -> None:
    width = len(layout.headings)
    for number, line in zip(piece.numbers.tolist(), piece.texts, strict=True):
        row = cells(line, layout.separator)
        # Cells that were left out at the end of a row are empty; what stands beyond the last heading belongs nowhere.
        if any(row[width:]):
            raise InvalidInput(f"{path}: row {number} has {len(row)} cells, the table has {width} columns")


def _row(
    path: Path, number: int, line: str, layout: Layout, places: Sequence[int], names: Sequence[str]
) -> list[float]:
    """The numbers of a row, cell by cell: finds the one that is none."""
    row = cells(line, layout.separator)
    values = []
    for place, name in zip(places, names, strict=True):
        cell = row[place] if place < len(row) else ""
        if unit := layout.carried[place]:
            cell = cell.removesuffix(unit).rstrip()
        if not cell:
            raise InvalidInput(f"{path}: row {number}: {name} is empty")
        if NUMBERS[layout.decimal].fullmatch(cell):
            # Fortran writes 1.5D+00.
            values.append(float(cell.replace(",", ".").replace("D", "E").replace("d", "e")))
        elif cell.lower().lstrip("+-") in ("nan", "inf", "infinity"):
            values.append(float(cell))
        else:
            hint = "; give times in seconds, not as dates" if CLOCK.search(cell) else ""
            raise InvalidInput(f"{path}: row {number}: {name} = {cell!r} is no number{hint}")
    return values
