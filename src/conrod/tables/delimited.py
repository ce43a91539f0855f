"""Numbers of a text table, read in pieces: a million rows take a few seconds, and what is no number is named."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.motion import Array
from conrod.tables.fast_numbers import LARGE, numbers_by_arrow
from conrod.tables.layout import BLANKS, CLOCK, COMMENT, NUMBERS, Layout, cells
from conrod.tables.text import blocks


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
