"""Numbers of a text table, read in pieces: a million rows take a few seconds, and what is no number is named."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.motion import Array
from conrod.tables.layout import BLANKS, COMMENT, NUMBERS, Layout, cells
from conrod.tables.text import blocks

Numbered = list[tuple[int, str]]


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
    for piece in _pieces(path, layout):
        count += len(piece)
        if count > most:
            raise InvalidInput(f"{path}: it has more than {most} rows, which is the most that is kept: thin it out")
        values.append(_converted(path, piece, layout, places, names))
        numbers.append(np.array([number for number, _ in piece]))
    return np.concatenate(values), np.concatenate(numbers)


def _pieces(path: Path, layout: Layout) -> Iterator[Numbered]:
    # Spreadsheets end tables with rows of empty cells; comments may stand anywhere.
    void = f'{layout.separator}" \t\r\n'
    for first, block in blocks(path, layout.encoding):
        piece = [(number, line) for number, line in enumerate(block, first) if line.strip(void)]
        if first < layout.first:
            piece = [(number, line) for number, line in piece if number >= layout.first]
        if any(line[0] in "#%/ \t" for _, line in piece):
            piece = [(number, line) for number, line in piece if not COMMENT.match(line)]
        if piece:
            yield piece


def _converted(path: Path, piece: Numbered, layout: Layout, places: Sequence[int], names: Sequence[str]) -> Array:
    texts, marks = [line for _, line in piece], len(layout.headings) - 1
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
        return np.array([_row(path, number, line, layout, places, names) for number, line in piece])


def _check_widths(path: Path, piece: Numbered, layout: Layout) -> None:
    width = len(layout.headings)
    for number, line in piece:
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
        if not cell:
            raise InvalidInput(f"{path}: row {number}: {name} is empty")
        if NUMBERS[layout.decimal].fullmatch(cell):
            # Fortran writes 1.5D+00.
            values.append(float(cell.replace(",", ".").replace("D", "E").replace("d", "e")))
        elif cell.lower().lstrip("+-") in ("nan", "inf", "infinity"):
            values.append(float(cell))
        else:
            raise InvalidInput(f"{path}: row {number}: {name} = {cell!r} is no number")
    return values
