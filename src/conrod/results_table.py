"""The ledger as a tidy table: a row a run (and machine that timed it), chosen by an expression, in three formats."""

from __future__ import annotations

import csv
import io
import json
import re
import sqlite3
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

from conrod.errors import InvalidInput, unknown_choice

Row = Mapping[str, Any]
FORMATS = ("csv", "json", "parquet")
QUOTED_TEXT, QUOTED_NAME = re.compile(r"'[^']*'"), re.compile(r'"([^"]*)"')
NO_COLUMN = "no such column: "


@dataclass(frozen=True)
class ResultsTable:
    """Columns by name, in order; every row has all of them, None where it has no value."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]

    def as_csv(self) -> str:
        """Comma-separated values; an empty cell where there is no value."""
        if not self.columns:
            return ""
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(self.rows)
        return stream.getvalue()

    def as_json(self) -> str:
        """A list of objects, one a line."""
        lines = [json.dumps(dict(zip(self.columns, row, strict=True)), allow_nan=False) for row in self.rows]
        return "[\n" + ",\n".join(lines) + "\n]\n"

    def as_parquet(self) -> bytes:
        """Apache Parquet.

        Raises:
            InvalidInput: pyarrow is not installed.
        """
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise InvalidInput("--parquet needs pyarrow: pip install 'conrod[parquet]'") from None
        values = {name: [row[i] for row in self.rows] for i, name in enumerate(self.columns)}
        stream = io.BytesIO()
        pyarrow.parquet.write_table(pyarrow.table(values), stream)
        return stream.getvalue()

    def content(self, kind: str) -> str | bytes:
        """The table in one of `FORMATS`."""
        ways: Mapping[str, Callable[[], str | bytes]]
        ways = {"csv": self.as_csv, "json": self.as_json, "parquet": self.as_parquet}
        return ways[kind]()


def results_table(rows: Iterable[Row], where: Sequence[str] = ()) -> ResultsTable:
    """The rows for which all expressions hold, with the union of their columns.

    Args:
        where: SQL expressions on the columns, such as `engine = 'mujoco' and position_max < 1e-6`; names with a point
            are put in double quotes.

    Raises:
        InvalidInput: an expression that SQLite does not understand; says what it stumbled on.
    """
    kept = list(rows)
    columns = tuple(dict.fromkeys(name for row in kept for name in row))
    if not columns:
        return ResultsTable((), ())
    names = ", ".join(_quoted(name) for name in columns)
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as memory:
        memory.execute(f"CREATE TABLE results ({names})")
        marks = ", ".join("?" * len(columns))
        memory.executemany(f"INSERT INTO results VALUES ({marks})", ([row.get(c) for c in columns] for row in kept))
        # Only what reads is allowed from here on: an expression is a user's, and may come from anywhere.
        memory.set_authorizer(_reading_only)
        for expression in where:
            _check(memory, expression, columns)
        condition = " AND ".join(f"({expression})" for expression in where) or "1"
        return ResultsTable(columns, tuple(_selected(memory, condition, columns)))


def _check(memory: sqlite3.Connection, expression: str, columns: Sequence[str]) -> None:
    """Refuse what is no expression of its own, or names a column that there is not."""
    # SQLite takes a name in double quotes that is no column for a text, and then selects nothing.
    for name in QUOTED_NAME.findall(QUOTED_TEXT.sub("", expression)):
        if name not in columns:
            raise unknown_choice("column", name, columns)
    # Without parentheses around it: what only they would balance is not an expression.
    _selected(memory, f"{expression}\n", columns, most=0)


def _selected(memory: sqlite3.Connection, condition: str, columns: Sequence[str], most: int = -1) -> list[Any]:
    try:
        return memory.execute(f"SELECT * FROM results WHERE {condition} ORDER BY rowid LIMIT {most}").fetchall()
    except (sqlite3.Error, sqlite3.Warning) as error:
        text = str(error)
        if text.startswith(NO_COLUMN):
            raise unknown_choice("column", text.removeprefix(NO_COLUMN), columns) from None
        raise InvalidInput(f"--where: {text}; write SQL on the columns, e.g. engine = 'mujoco'") from None


def _reading_only(action: int, *_: Any) -> int:
    reading = (sqlite3.SQLITE_SELECT, sqlite3.SQLITE_READ, sqlite3.SQLITE_FUNCTION)
    return sqlite3.SQLITE_OK if action in reading else sqlite3.SQLITE_DENY


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'
