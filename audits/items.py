"""The documents' printed numbers, read from their data files."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from importlib.resources import files

from audits.judging import Item
from conrod.errors import InvalidInput
from conrod.models.printed.verdicts import PrintedNumber

COLUMNS = ("key", "place", "line", "quantity", "condition", "printed", "unit", "mechanism")


def shipped_items(document: str, name: str) -> tuple[Item, ...]:
    """Return the items of a file of `audits/data`."""
    text = files("audits").joinpath("data", name).read_text(encoding="utf-8")
    return tuple(items_of(document, text))


def items_of(document: str, text: str) -> Iterator[Item]:
    """Items of a table in CSV with the columns `COLUMNS`.

    Raises:
        InvalidInput: a column is missing, or a value cannot be read; names the row.
    """
    reader = csv.DictReader(text.splitlines())
    missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
    if missing:
        raise InvalidInput(f"printed values of {document}: no column {missing[0]!r}; required are {', '.join(COLUMNS)}")
    for count, row in enumerate(reader, start=2):
        if any(row[name] is None for name in COLUMNS) or not re.fullmatch("[0-9]{1,9}", row["line"]):
            raise InvalidInput(f"printed values of {document}, row {count}: give {', '.join(COLUMNS)}, line a number")
        yield Item(
            document,
            row["key"],
            row["place"],
            int(row["line"]),
            row["quantity"],
            row["condition"],
            PrintedNumber(row["printed"]),
            row["unit"],
            row["mechanism"],
        )
