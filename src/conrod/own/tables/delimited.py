"""Numbers of a text table, read in pieces: a million rows take a few seconds, and what is no number is named."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.layout import BLANKS, CLOCK, COMMENT, NUMBERS, Layout, cells
from conrod.own.tables.text import lines

PIECE = 50_000  # rows that are read at a time


@dataclass(frozen=True)
class Wanted:
    """Some columns of a text table: their places in it, and their names for errors."""

    path: Path
    layout: Layout
    places: Sequence[int]
    names: Sequence[str]


def read_numbers(wanted: Wanted, most: int) -> tuple[Array, NDArray[np.int64]]:
    """Values (T, columns) of some columns, and the line of each row (T,).

    Args:
        most: rows that are kept.

    Raises:
        InvalidInput: a cell that is no number, or more rows than are kept.
    """
    values, numbers, rows = [], list[int](), _rows(wanted.path, wanted.layout)
    while piece := list(islice(rows, PIECE)):
        numbers += [number for number, _ in piece]
        if len(numbers) > most:
            raise InvalidInput(f"{wanted.path}: it has more than {most} rows, which are all that is kept: thin it out")
        values.append(_converted(wanted, piece))
    return np.concatenate(values), np.array(numbers)


def _rows(path: Path, layout: Layout) -> Iterator[tuple[int, str]]:
    # Spreadsheets end tables with rows of empty cells; comments may stand anywhere.
    void = f'{layout.separator}" \t'
    for number, line in lines(path, layout.encoding):
        if number >= layout.first and line.strip(void) and not COMMENT.match(line):
            yield number, line


def _converted(wanted: Wanted, rows: Sequence[tuple[int, str]]) -> Array:
    layout, texts = wanted.layout, [line for _, line in rows]
    width, blanks = len(layout.headings), layout.separator == BLANKS
    if any((len(line.split()) if blanks else line.count(layout.separator) + 1) != width for line in texts):
        _check_widths(wanted, rows)
    if layout.decimal == ",":
        texts = [line.replace(",", ".") for line in texts]
    try:
        return np.loadtxt(
            texts,
            delimiter=None if blanks else layout.separator,
            usecols=wanted.places,
            comments=None,
            quotechar='"',
            ndmin=2,
        )
    except ValueError:
        return np.array([_row(wanted, number, line) for number, line in rows])


def _check_widths(wanted: Wanted, rows: Sequence[tuple[int, str]]) -> None:
    width = len(wanted.layout.headings)
    for number, line in rows:
        row = cells(line, wanted.layout.separator)
        # Cells that were left out at the end of a row are empty; what stands beyond the last heading belongs nowhere.
        if any(row[width:]):
            raise InvalidInput(f"{wanted.path}: row {number} has {len(row)} cells, the table has {width} columns")


def _row(wanted: Wanted, number: int, line: str) -> list[float]:
    """The numbers of a row, cell by cell: finds the one that is none."""
    row = cells(line, wanted.layout.separator)
    values = []
    for place, name in zip(wanted.places, wanted.names, strict=True):
        cell = row[place] if place < len(row) else ""
        if unit := wanted.layout.carried[place]:
            cell = cell.removesuffix(unit).rstrip()
        if not cell:
            raise InvalidInput(f"{wanted.path}: row {number}: {name} is empty")
        if NUMBERS[wanted.layout.decimal].fullmatch(cell):
            # Fortran writes 1.5D+00.
            values.append(float(cell.replace(",", ".").replace("D", "E").replace("d", "e")))
        elif cell.lower().lstrip("+-") in ("nan", "inf", "infinity"):
            values.append(float(cell))
        else:
            hint = "; give times in seconds, not as dates" if CLOCK.search(cell) else ""
            raise InvalidInput(f"{wanted.path}: row {number}: {name} = {cell!r} is no number{hint}")
    return values
