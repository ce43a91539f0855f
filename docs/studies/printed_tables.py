"""`python -m docs.studies.printed_tables [NAME ...] [--write]`: tables that the pages of docs/ print, made anew.

On a page such a table stands behind a line that names its command, in a comment, as
`<!-- python -m docs.studies.printed_tables NAME -->`. Cells can be made one by one: a fast test and `make stale` draw
some of them, and compare them with what is printed.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import conrod
from conrod.crash import run_guarded
from conrod.errors import unknown_choice
from conrod.execution.writing import single_file, write_together
from conrod.report.numbers import measured_text
from conrod.report.table import table
from conrod.report.template import table_text

DOCS = Path(__file__).parents[1]
COMMAND = "python -m docs.studies.printed_tables"
END = "<!-- end of the table -->"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
UNITS_OF_LAST_DIGIT = 2.0  # by which a number may differ on another machine


@dataclass(frozen=True)
class PrintedTable:
    """A table of a page, of which each cell is a measurement.

    Attributes:
        page: name of the page in docs/.
        corner: heading of the first column.
        rows: labels of the rows; several columns of labels are joined by ` | `.
        columns: headings of the measured columns.
        cell: measures a cell, given row and column, and returns its text.
        factor: factor by which a cell may differ on another machine, where rounding is amplified; 1 where it is not.
    """

    page: str
    corner: str
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    cell: Callable[[str, str], str]
    factor: float = 1.0

    def text(self) -> str:
        """Measure all cells, and return the table as Markdown."""
        heads = (*self.corner.split(" | "), *self.columns)
        rows = [(*row.split(" | "), *(self.cell(row, column) for column in self.columns)) for row in self.rows]
        return table_text(table(heads, rows))

    def cells(self) -> list[tuple[str, str]]:
        """Return row and column of each cell."""
        return [(row, column) for row in self.rows for column in self.columns]


def printed_text(name: str, one: PrintedTable) -> str:
    """Return what the page prints between the lines that mark the table."""
    found = (DOCS / one.page).read_text(encoding="utf-8").partition(f"<!-- {COMMAND} {name} -->\n")[2]
    return found.partition(END)[0].strip()


def printed_cells(name: str, one: PrintedTable) -> dict[tuple[str, str], str]:
    """Read the cells that the page prints, by row and column."""
    head, _, *lines = (
        [cell.strip() for cell in line.strip().strip("|").split("|")] for line in printed_text(name, one).splitlines()
    )
    labels = len(one.corner.split(" | "))
    return {
        (" | ".join(line[:labels]), column): cell
        for line in lines
        for column, cell in zip(head[labels:], line[labels:], strict=True)
    }


def agrees(printed: str, measured: str, factor: float = 1.0) -> bool:
    """Say whether a cell is what is printed: the same words, and numbers within two units of the last printed digit."""
    was, now = NUMBER.findall(printed), NUMBER.findall(measured)
    if NUMBER.sub("#", printed) != NUMBER.sub("#", measured) or len(was) != len(now):
        return False
    return all(_is_near(before, float(after), factor) for before, after in zip(was, now, strict=True))


def _is_near(printed: str, measured: float, factor: float) -> bool:
    mantissa, _, exponent = printed.partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    value = float(printed)
    if abs(measured - value) <= (UNITS_OF_LAST_DIGIT + 1e-6) * unit:
        return True
    return value * measured > 0.0 and 1.0 / factor <= measured / value <= factor


def stale_cells(seconds: float, draw: random.Random, most: int | None = None) -> Iterator[str]:
    """Measure cells of all tables, drawn at random, and say which are not what the pages print.

    Args:
        seconds: CPU time for all of them.
        most: most cells of each table.
    """
    for number, (name, one) in enumerate(TABLES.items()):
        printed, begun, made = printed_cells(name, one), _cpu_seconds(), 0
        share = seconds / (len(TABLES) - number)
        missing = sorted({*one.cells()} ^ {*printed})
        yield from (f"docs/{one.page}: {name}: cell {row}, {column} is not of today's table" for row, column in missing)
        for row, column in draw.sample(one.cells(), len(one.cells())):
            if made == most or _cpu_seconds() - begun > share:
                break
            made += 1
            measured = one.cell(row, column)
            if (row, column) in printed and not agrees(printed[row, column], measured, one.factor):
                yield f"docs/{one.page}: {name}: {row}, {column}: {printed[row, column]}, today {measured}"
        seconds -= _cpu_seconds() - begun
        print(f"docs/{one.page}: {name}: {made} of {len(printed)} cells made again", file=sys.stderr)


def _cpu_seconds() -> float:
    """CPU time of this process and of those that it started and that have ended [s]."""
    return sum(os.times()[:4])


# -- free motion -------------------------------------------------------------------------------------------------------


@cache
def free_error(scene: str, preset: str, milliseconds: float) -> str:
    """Return the largest position error of a scene let go in MuJoCo for ten seconds, or how the run ended."""
    found = conrod.free_motion([scene], seconds=10.0, step=1e-3 * milliseconds, engines=["mujoco"], preset=preset)
    (result,) = found.study.results
    error = result.largest("position")
    return result.outcome if error is None else measured_text(error)


SWUNG = ("four-bar-chain-2", "four-bar-chain-10", "four-bar-swing", "six-bar-swing", "saw-coasting", "pendulum")
CHAINS = (2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14, 20, 40)
TABLES: Mapping[str, PrintedTable] = {
    "free-motion-steps": PrintedTable(
        "free-motion.md",
        "scene | preset",
        tuple(
            f"`{scene}` | {preset}"
            for scene in (*SWUNG, "press-cutting-flywheel")
            for preset in ("stock", "tuned", "hardened")
        ),
        ("10 ms", "5 ms", "2.5 ms", "1.25 ms", "1 ms"),
        lambda row, column: free_error(*row.replace("`", "").split(" | "), float(column.removesuffix(" ms"))),
        factor=1.3,
    ),
    "free-motion-chains": PrintedTable(
        "free-motion.md",
        "four-bars",
        ("position",),
        tuple(map(str, CHAINS)),
        lambda row, column: free_error(f"four-bar-chain-{column}", "hardened", 5.0),
        factor=30.0,
    ),
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Print tables of the pages, made anew, and write them where it is asked for."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=main.__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"[all] {', '.join(TABLES)}")
    parser.add_argument("--write", action="store_true", help="write them into their pages")
    asked = parser.parse_args(arguments)
    for name in asked.names or TABLES:
        if name not in TABLES:
            raise unknown_choice("table", name, TABLES)
        text = TABLES[name].text()
        print(f"{name}\n\n{text}\n", flush=True)
        if asked.write:
            page = DOCS / TABLES[name].page
            before, mark, rest = page.read_text(encoding="utf-8").partition(f"<!-- {COMMAND} {name} -->\n")
            whole = f"{before}{mark}\n{text}\n\n{END}{rest.partition(END)[2]}"
            write_together([single_file(page, whole)])


if __name__ == "__main__":
    run_guarded(main)
