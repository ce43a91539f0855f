"""Tables of text, whatever their encoding, separator and decimal mark: their layout and their numbers."""

from __future__ import annotations

import codecs
import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count, islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.columns import Column, Source
from conrod.own.tables.headings import bare_unit, with_unit

LONGEST_LINE = 1_000_000  # characters
HEAD = 1 << 16  # bytes that an encoding is derived from
SAMPLE = 400  # lines that the layout is derived from
BOMS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
BLANKS = " "  # as a separator: any run of blanks
SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", BLANKS: "blanks"}
# Where two fit as well, the earlier one is meant: `0, 1, 2` is separated by commas.
WRITTEN = ((";", "."), (";", ","), ("\t", "."), ("\t", ","), (",", "."), (BLANKS, "."), (BLANKS, ","))
NUMBERS = {mark: re.compile(rf"[+-]?(\d+{re.escape(mark)}?\d*|{re.escape(mark)}\d+)([eEdD][+-]?\d+)?") for mark in ".,"}
CLOCK = re.compile(r"\d{4}-\d\d-\d\d|\d:\d\d")  # dates and times of day
NO_DATES = "; give times in seconds, not as dates"
COMMENT = re.compile(r"\s*(#|%|//)+\s?")
# A heading of a table separated by blanks: a word, with its unit if that is in brackets.
WORD = re.compile(r"\S+(?:\s[\[(][^\])]*[\])])?")
LEAST = 2  # numbers in a row of them: there may be columns of text between

Line = tuple[int, str]  # its number in the file from 1, its text
Row = tuple[int, list[str]]


@dataclass(frozen=True)
class TextTable:
    """A table of text with its layout.

    Attributes:
        separator: a character; `BLANKS` for any run of blanks.
        decimal: mark.
        first: line with the first numbers.
    """

    path: Path
    encoding: str
    separator: str
    decimal: str
    headings: tuple[str, ...]
    first: int

    def read(self, columns: Sequence[Column], most: int) -> tuple[Array, NDArray[np.int64]]:
        """Values (T, columns), and the line of each row (T,); a million rows take a few seconds.

        Raises:
            InvalidInput: a cell that is no number, or more rows than may be kept.
        """
        numbers: list[int] = []

        def texts() -> Iterator[str]:
            numbers.clear()
            for number, line in self._rows():
                if len(numbers) == most:
                    raise InvalidInput(f"it has more than {most} rows, which are all that is kept: thin it out")
                numbers.append(number)
                yield line

        plain = texts() if self.decimal == "." else (line.replace(",", ".") for line in texts())
        separator, places = None if self.separator == BLANKS else self.separator, [c.index for c in columns]
        try:
            values = np.loadtxt(plain, delimiter=separator, usecols=places, comments=None, quotechar='"', ndmin=2)
        except InvalidInput:
            raise
        except ValueError:
            rows = (cells(line, self.separator) for line in texts())
            values = np.array([[self._number(row, column, numbers[-1]) for column in columns] for row in rows])
        return values, np.array(numbers)

    def _rows(self) -> Iterator[Line]:
        """Lines with numbers. Spreadsheets end tables with rows of empty cells; comments may stand anywhere."""
        void, width, blanks = f'{self.separator}" \t', len(self.headings), self.separator == BLANKS
        for number, line in _lines(self.path, self.encoding):
            if number < self.first or not line.strip(void) or COMMENT.match(line):
                continue
            if (len(line.split()) if blanks else line.count(self.separator) + 1) != width:
                # Cells left out at the end of a row are empty; what stands beyond the last heading belongs nowhere.
                row = cells(line, self.separator)
                if any(row[width:]):
                    raise InvalidInput(f"row {number} has {len(row)} cells, the table has {width} columns")
            yield number, line

    def _number(self, row: Sequence[str], column: Column, number: int) -> float:
        """The number in a cell, in more ways than numpy reads them."""
        cell = row[column.index] if column.index < len(row) else ""
        if NUMBERS[self.decimal].fullmatch(cell):
            # Fortran writes 1.5D+00.
            return float(cell.replace(",", ".").replace("D", "E").replace("d", "e"))
        if cell.lower().lstrip("+-") in ("nan", "inf", "infinity"):
            return float(cell)
        what = f"= {cell!r} is no number{NO_DATES if CLOCK.search(cell) else ''}" if cell else "is empty"
        raise InvalidInput(f"row {number}: {column.target.name} {what}")


def cells(line: str, separator: str) -> list[str]:
    """The cells of a line, without the blanks around them."""
    if separator == BLANKS:
        return [cell.strip('"') for cell in line.split()]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]


# -- text ------------------------------------------------------------------------------------------------------------


def _encoding_of(path: Path) -> str:
    with path.open("rb") as file:
        head = file.read(HEAD)
    if not head.strip():
        raise InvalidInput("it is empty")
    for mark, encoding in BOMS.items():
        if head.startswith(mark):
            return encoding
    if b"\0" in head:
        raise InvalidInput("it is no table of text: it holds zero bytes; save a sheet as CSV")
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "cp1252"  # what spreadsheets on Windows write
    return "utf-8"


def _lines(path: Path, encoding: str) -> Iterator[Line]:
    """Lines that are not blank, of bounded length."""
    with path.open(encoding=encoding) as file:
        for number in count(1):
            try:
                line = file.readline(LONGEST_LINE + 1)
            except UnicodeError:
                raise InvalidInput(f"behind row {number}: it is no text in {encoding}") from None
            if len(line) > LONGEST_LINE:
                raise InvalidInput(f"row {number} is longer than {LONGEST_LINE} characters: it is no table")
            if "\0" in line:
                raise InvalidInput(f"row {number} holds zero bytes: it is no table of text")
            if not line:
                return
            if not line.isspace():
                yield number, line.rstrip("\n")


# -- layout ----------------------------------------------------------------------------------------------------------


def open_text(path: Path) -> Source:
    """A table of text, with the layout that its beginning shows.

    Raises:
        InvalidInput: it is no text, or no table.
    """
    encoding = _encoding_of(path)
    sample = list(islice(_lines(path, encoding), SAMPLE))
    found = {way: _numeric_rows(sample, *way) for way in WRITTEN}
    separator, decimal = max(WRITTEN, key=lambda way: sum(numbers for _, _, numbers in found[way]))
    if not (numeric := found[separator, decimal]):
        hint = NO_DATES if any(CLOCK.search(line) for _, line in sample) else ""
        raise InvalidInput(f"there is no row of numbers with at least two columns in its first {SAMPLE} rows{hint}")
    first, row, _ = numeric[0]
    above = [(number, _heading_cells(line, separator)) for number, line in sample if number < first]
    there = TextTable(path, encoding, separator, decimal, _headings(above, NUMBERS[decimal], len(row)), first)
    marks = {".": "decimal points", ",": "decimal commas"}
    return Source(f"text, separated by {SEPARATORS[separator]}, {marks[decimal]}", there.headings, there.read)


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


def _headings(above: Sequence[Row], pattern: re.Pattern[str], width: int) -> tuple[str, ...]:
    """Headings with their units from the rows above the numbers; without any, the columns' numbers from 1."""
    texts = [row for row in above if not any(map(pattern.fullmatch, row[1]))]
    fitting = [row for row in texts if len(row[1]) == width]
    if not fitting:
        if wide := [row for row in texts if sum(map(bool, row[1])) > 1]:
            number, row = wide[-1]
            raise InvalidInput(
                f"row {number} has {len(row)} headings, the rows of numbers have {width} cells "
                "(decimal commas need another separator than a comma)"
            )
        return tuple(str(k + 1) for k in range(width))
    # The last row of names: above it there may be titles and remarks, under it units.
    place, headings = next((row for row in reversed(fitting) if None in map(bare_unit, row[1])), fitting[-1])
    for number, row in (row for row in above if row[0] > place):
        units = [unit for unit in map(bare_unit, row) if unit is not None]
        if not len(units) == len(row) == width or number != above[-1][0]:
            bad = next((cell for cell in row if not pattern.fullmatch(cell)), row[0])
            raise InvalidInput(f"row {number}: {bad!r} is no number, and no unit under the headings of row {place}")
        headings = list(map(with_unit, headings, units))
    return tuple(headings)
