"""Results in a notebook: shown as HTML, and taken on as data frames of pandas."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING

from markupsafe import escape

from conrod.errors import InvalidInput
from conrod.report.table import Cell, Table, cell_text, safe_html

if TYPE_CHECKING:
    from pandas import DataFrame

EMPTY_CELLS = ("", "-", "n/a")  # as printed where there is no number


class NotebookResult:
    """A result that a notebook shows: a verdict, and tables below it."""

    @property
    @abstractmethod
    def verdict(self) -> str:
        """The answer in a few sentences."""

    @abstractmethod
    def tables(self) -> list[Table]:
        """The tables that the command prints, without empty ones."""

    def _repr_html_(self) -> str:
        """Return the verdict and the tables as HTML for a notebook."""
        return safe_html("".join([f"<p>{escape(self.verdict)}</p>", *map(_html_table, self.tables())]))

    def to_pandas(self, table: int = 0) -> DataFrame:
        """Return a table as a data frame of pandas, with the digits that are printed.

        Args:
            table: its place in `tables()`.

        Raises:
            InvalidInput: pandas is not installed, or there is no such table.
        """
        return data_frame(numbered_table(self.tables(), table))


def numbered_table(tables: Sequence[Table], number: int) -> Table:
    """Return a table by its place in a list.

    Raises:
        InvalidInput: there is no such table; says which there are.
    """
    if 0 <= number < len(tables):
        return tables[number]
    there = ", ".join(f"{k} ({one.title or one.headings[0] or one.headings[-1]})" for k, one in enumerate(tables))
    raise InvalidInput(f"table={number}: there is no such table; {f'there are {there}' if there else 'there is none'}")


def data_frame(table: Table) -> DataFrame:
    """Return a table as a data frame of pandas; columns of numbers are numbers in it, all others text.

    Raises:
        InvalidInput: pandas is not installed.
    """
    try:
        import pandas as pd
    except ImportError:
        raise InvalidInput("to_pandas() takes pandas, which is not installed: pip install pandas") from None
    columns = zip(*table.rows, strict=True) if table.rows else ((),) * len(table.headings)
    named = zip(table.headings, columns, strict=True)
    values = [_column_values(cells, heading in table.right) for heading, cells in named]
    return pd.DataFrame(list(zip(*values, strict=True)), columns=list(table.headings))


def _column_values(cells: Sequence[Cell], is_number: bool) -> Sequence[float | str]:
    """Return a column's cells as floats if all are numbers or empty, and one is a number; else as text."""
    texts = [cell_text(cell) for cell in cells]
    if not is_number or all(text in EMPTY_CELLS for text in texts):
        return texts
    try:
        return [math.nan if text in EMPTY_CELLS else float(text) for text in texts]
    except ValueError:  # such as "< 1e-12"
        return texts


def _html_table(table: Table) -> str:
    rows = [table.headings, *table.rows]
    tags = ["th", *["td"] * len(table.rows)]
    lines = [
        f"<tr>{''.join(f'<{tag}>{escape(cell_text(cell))}</{tag}>' for cell in row)}</tr>"
        for tag, row in zip(tags, rows, strict=True)
    ]
    return f"<table><caption>{escape(table.title)}</caption>{''.join(lines)}</table>"
