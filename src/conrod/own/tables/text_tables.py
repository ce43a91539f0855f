"""Tables of text, whatever their separator and decimal mark: their layout and their numbers."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.columns import Column, Source
from conrod.own.tables.headings import bare_unit, with_unit

SAMPLE = 400  # lines that the layout is derived from
BLANKS = " "  # as a separator: any run of blanks
SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", BLANKS: "blanks"}
# Where two fit as well, the earlier one is meant: `0, 1, 2` is separated by commas.
WRITTEN = ((";", "."), (";", ","), ("\t", "."), ("\t", ","), (",", "."), (BLANKS, "."), (BLANKS, ","))
NUMBERS = {mark: re.compile(rf"[+-]?(\d+{re.escape(mark)}?\d*|{re.escape(mark)}\d+)([eE][+-]?\d+)?") for mark in ".,"}
COMMENT = re.compile(r"\s*[#%]+\s?")
# A heading of a table separated by blanks: a word, with its unit if that is in brackets.
WORD = re.compile(r"\S+(?:\s[\[(][^\])]*[\])])?")
LEAST = 2  # numbers in a row of them: there may be columns of text between

Line = tuple[int, str]  # its number in the file from 1, its text


def open_text(path: Path) -> Source:
    """A table of text, with the layout that its beginning shows.

    Raises:
        InvalidInput: it is no text, or no table.
    """
    lines = _lines(path)
    found = {way: _numeric_rows(lines[:SAMPLE], *way) for way in WRITTEN}
    separator, decimal = max(WRITTEN, key=lambda way: sum(numbers for _, _, numbers in found[way]))
    if not (numeric := found[separator, decimal]):
        raise InvalidInput(
            f"there is no row of numbers with at least two columns in its first {SAMPLE} rows; give times in seconds, "
            "not as dates"
        )
    first, width = numeric[0][0], len(numeric[0][1])
    headings = _headings([_heading_cells(line, separator) for number, line in lines if number < first], width)
    rows = [one for one in lines if one[0] >= first and not COMMENT.match(one[1])]

    def read(columns: Sequence[Column], most: int) -> tuple[Array, NDArray[np.int64]]:
        return _numbers(rows, columns, (separator, decimal), width, most)

    marks = {".": "decimal points", ",": "decimal commas"}
    return Source(f"text, separated by {SEPARATORS[separator]}, {marks[decimal]}", headings, read)


def _lines(path: Path) -> list[Line]:
    """Lines that are not blank: in UTF-8, or as spreadsheets on Windows write; rows of empty cells are blank, too."""
    content = path.read_bytes()
    if b"\0" in content:
        raise InvalidInput("it is no table of text: it holds zero bytes; save a sheet as CSV")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("cp1252", errors="replace")
    return [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip('";,\t ')]


def cells(line: str, separator: str) -> list[str]:
    """The cells of a line, without the blanks around them."""
    if separator == BLANKS:
        return [cell.strip('"') for cell in line.split()]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]


def _numeric_rows(sample: Sequence[Line], separator: str, decimal: str) -> list[tuple[int, list[str], int]]:
    """Rows with numbers, of the most common width: the line, the cells, and how many of them are numbers."""
    rows = [(number, cells(line, separator)) for number, line in sample if not COMMENT.match(line)]
    counted = [(number, row, sum(map(bool, map(NUMBERS[decimal].fullmatch, row)))) for number, row in rows]
    numeric = [one for one in counted if one[2] >= LEAST]
    width = Counter(len(row) for _, row, _ in numeric).most_common(1)
    return [one for one in numeric if len(one[1]) == width[0][0]]


def _heading_cells(line: str, separator: str) -> list[str]:
    text = COMMENT.sub("", line.strip(), count=1) if COMMENT.match(line) else line
    return WORD.findall(text) if separator == BLANKS else cells(text, separator)


def _headings(above: Sequence[list[str]], width: int) -> tuple[str, ...]:
    """Headings from the last row above the numbers, units from one under it; the columns' numbers from 1 without any.

    Above the row of names there may be titles and remarks.
    """
    fitting = [row for row in above if len(row) == width] or [[str(k + 1) for k in range(width)]]
    units = [unit for unit in map(bare_unit, fitting[-1]) if unit is not None]
    if len(fitting) > 1 and len(units) == width:
        return tuple(map(with_unit, fitting[-2], units))
    return tuple(fitting[-1])


def _numbers(
    rows: Sequence[Line], columns: Sequence[Column], written: tuple[str, str], width: int, most: int
) -> tuple[Array, NDArray[np.int64]]:
    """Values (T, columns), and the line of each row (T,); a million rows take a few seconds.

    Raises:
        InvalidInput: a cell that is no number, or more rows than may be kept.
    """
    separator, decimal = written
    if len(rows) > most:
        raise InvalidInput(f"it has {len(rows)} rows: at most {most} are kept: thin it out")
    for number, line in rows:
        # Cells left out at the end of a row are empty; what stands beyond the last heading belongs nowhere.
        if line.count(separator) >= width and any(cells(line, separator)[width:]):
            raise InvalidInput(f"row {number} has more than the {width} cells of the table's columns")
    plain = (line if decimal == "." else line.replace(",", ".") for _, line in rows)
    delimiter, places = None if separator == BLANKS else separator, [column.index for column in columns]
    try:
        values = np.loadtxt(plain, delimiter=delimiter, usecols=places, comments=None, quotechar='"', ndmin=2)
    except ValueError:
        raise InvalidInput(_bad_cell(rows, columns, written)) from None
    return values, np.array([number for number, _ in rows])


def _bad_cell(rows: Sequence[Line], columns: Sequence[Column], written: tuple[str, str]) -> str:
    """The first cell that is no number, in words."""
    for number, line in rows:
        row = cells(line, written[0])
        for column in columns:
            cell = row[column.index] if column.index < len(row) else ""
            if not NUMBERS[written[1]].fullmatch(cell) and cell.lower().lstrip("+-") not in ("nan", "inf", "infinity"):
                what = f"= {cell!r} is no number (a time is in seconds, no date)" if cell else "is empty"
                return f"row {number}: {column.target.name} {what}"
    return "its rows cannot be read as numbers"
