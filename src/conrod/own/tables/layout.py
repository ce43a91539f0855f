"""Layout of a text table: separator, decimal mark, headings, and the row where its numbers begin."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.own.tables.headings import bare_unit, is_unit
from conrod.own.tables.text import encoding_of, lines

SAMPLE = 400  # lines that the layout is derived from
BLANKS = " "  # as a separator: any run of blanks
# Where two fit as well, the earlier one is meant: `0, 1, 2` is separated by commas.
WRITTEN = ((";", "."), (";", ","), ("\t", "."), ("\t", ","), (",", "."), (BLANKS, "."), (BLANKS, ","))
NUMBERS = {mark: re.compile(rf"[+-]?(\d+{re.escape(mark)}?\d*|{re.escape(mark)}\d+)([eEdD][+-]?\d+)?") for mark in ".,"}
NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)|#?n/?a|null|none|", re.IGNORECASE)
CLOCK = re.compile(r"\d{4}-\d\d-\d\d|\d:\d\d")  # dates and times of day
COMMENT = re.compile(r"\s*(#|%|//)+\s?")
# MATLAB writes durations with their unit in every cell: 0.25 sec.
CARRIED = re.compile(r"(?P<number>\S+)\s+(?P<unit>[^\W\d]\S*)")
# A heading of a table separated by blanks: a word, with its unit if that is in brackets.
WORD = re.compile(r"\S+(?:\s[\[(][^\])]*[\])])?")

# Of the cells of a row of numbers all are; a table that has none may have columns of text among its numbers.
WHOLLY = 0

Row = tuple[int, list[str]]  # its line in the file, its cells


@dataclass(frozen=True)
class Layout:
    """Layout of a text table.

    Attributes:
        encoding: of the file.
        separator: a character; `BLANKS` for any run of blanks.
        decimal: mark.
        headings: of all columns; their numbers from 1 where the table has none.
        units: in the row under the headings, or in the cells; empty where there are none.
        carried: units that the cells of each column end with; "" where they are bare numbers.
        first: line with the first numbers.
    """

    encoding: str
    separator: str
    decimal: str
    headings: tuple[str, ...]
    units: tuple[str, ...]
    carried: tuple[str, ...]
    first: int

    @property
    def form(self) -> str:
        """In words, for the report."""
        names = {";": "semicolons", "\t": "tabs", ",": "commas", BLANKS: "blanks"}
        marks = {".": "decimal points", ",": "decimal commas"}
        return f"text, separated by {names[self.separator]}, {marks[self.decimal]}"


def cells(line: str, separator: str) -> list[str]:
    """The cells of a line, without the blanks around them."""
    if separator == BLANKS:
        return [cell.strip('"') for cell in line.split()]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]


def layout_of(path: Path) -> Layout:
    """The layout of a table, from its beginning.

    Raises:
        InvalidInput: it is no text, or no table.
    """
    encoding = encoding_of(path)
    sample = list(islice(lines(path, encoding), SAMPLE))
    for least in (WHOLLY, 2):
        (separator, decimal), numeric = max(
            ((way, _numeric_rows(sample, *way, least)) for way in WRITTEN), key=lambda found: len(found[1])
        )
        if numeric:
            break
    else:
        hint = "; give times in seconds, not as dates" if any(CLOCK.search(line) for _, line in sample) else ""
        raise InvalidInput(
            f"{path}: there is no row of numbers with at least two columns in its first {SAMPLE} rows{hint}"
        )
    first, width = numeric[0][0], len(numeric[0][1])
    before = [(number, line) for number, line in sample if number < first]
    headings, units = _headings(path, before, separator, decimal, width)
    carried = tuple(_carried_unit(cell, NUMBERS[decimal]) for cell in numeric[0][1])
    units = units or (carried if any(carried) else ())
    return Layout(encoding, separator, decimal, headings, units, carried, first)


def _numeric_rows(sample: Sequence[tuple[int, str]], separator: str, decimal: str, least: int) -> list[Row]:
    """Rows of numbers of the most common width; `least` of their cells are numbers, or all of them (`WHOLLY`)."""
    rows = [(number, cells(line, separator)) for number, line in sample if not COMMENT.match(line)]
    numeric = [(number, row) for number, row in rows if len(row) > 1 and _is_numeric(row, NUMBERS[decimal], least)]
    if not numeric:
        return []
    width = Counter(len(row) for _, row in numeric).most_common(1)[0][0]
    return [(number, row) for number, row in numeric if len(row) == width]


def _is_numeric(row: Sequence[str], pattern: re.Pattern[str], least: int) -> bool:
    found = [bool(pattern.fullmatch(cell)) for cell in row]
    if least != WHOLLY:
        return sum(found) + sum(bool(_carried_unit(cell, pattern)) for cell in row) >= least
    return any(found) and all(ok or NOT_FINITE.fullmatch(cell) for ok, cell in zip(found, row, strict=True))


def _carried_unit(cell: str, pattern: re.Pattern[str]) -> str:
    """The unit behind the number in a cell; empty without."""
    match = CARRIED.fullmatch(cell)
    return match["unit"] if match and pattern.fullmatch(match["number"]) and is_unit(match["unit"]) else ""


def _headings(
    path: Path, before: Sequence[tuple[int, str]], separator: str, decimal: str, width: int
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Headings and units, from what stands above the numbers."""
    rows = [(number, _heading_cells(line, separator)) for number, line in before]
    texts = [row for row in rows if not any(NUMBERS[decimal].fullmatch(cell) for cell in row[1])]
    fitting = [(number, row) for number, row in texts if len(row) == width]
    if not fitting:
        _check_no_heading(path, texts, width)
        return tuple(str(k + 1) for k in range(width)), ()
    # The last row of names: above it there may be titles and remarks, under it units.
    names = [(number, row) for number, row in fitting if None in map(bare_unit, row)]
    place, headings = (names or fitting)[-1]
    under = [(number, row) for number, row in rows if number > place]
    if not under:
        return tuple(headings), ()
    number, row = under[0]
    units = [bare_unit(cell) for cell in row]
    if len(under) > 1 or len(row) != width or None in units:
        bad = next((cell for cell in row if not NUMBERS[decimal].fullmatch(cell)), row[0])
        raise InvalidInput(f"{path}: row {number}: {bad!r} is no number, and no unit under the headings of row {place}")
    return tuple(headings), tuple(row)


def _heading_cells(line: str, separator: str) -> list[str]:
    text = COMMENT.sub("", line.strip(), count=1) if COMMENT.match(line) else line
    return WORD.findall(text) if separator == BLANKS else cells(text, separator)


def _check_no_heading(path: Path, texts: Sequence[Row], width: int) -> None:
    """Refuse headings of another number than the columns: their columns cannot be determined."""
    wide = [(number, row) for number, row in texts if sum(map(bool, row)) > 1]
    if wide:
        number, row = wide[-1]
        raise InvalidInput(
            f"{path}: row {number} has {len(row)} headings, the rows of numbers have {width} cells "
            "(decimal commas need another separator than a comma)"
        )
