"""`conrod results`: a table to read on a terminal, comma-separated values in a pipe, and columns that are asked for."""

from __future__ import annotations

import csv
import io

import pytest

from conrod.cli.console import TERMINAL_COLUMNS, ledger_table
from conrod.errors import InvalidInput
from conrod.execution.results_table import table_text, tidy_row

IDENTITY = {
    "scene": "Saw", "study": "validate", "parameters": {"crank": 0.1}, "engine": "mujoco", "engine_version": "4.0.0",
    "preset": "tuned", "settings": {"steps_per_revolution": 1000, "timestep": 1e-3}, "cache_version": 4,
}  # fmt: skip
RESULT = {"outcome": "completed", "passed": True, "sizes": {"position": {"max": 1.23456e-7}}}
ROW = tidy_row("abc", "saw-500rpm", IDENTITY, RESULT, None)


def test_terminal_table_has_ten_columns_that_every_ledger_has() -> None:
    assert len(TERMINAL_COLUMNS) == 10
    assert set(TERMINAL_COLUMNS) <= set(ROW)
    (cells,) = ledger_table([ROW]).rows
    assert cells[:3] == ("saw-500rpm", "validate", "mujoco")
    assert "completed" in cells


def test_results_have_the_columns_that_are_asked_for() -> None:
    assert list(csv.reader(io.StringIO(table_text([ROW], "csv", ("outcome", "scene"))))) == [
        ["outcome", "scene"],
        ["completed", "saw-500rpm"],
    ]
    assert ledger_table([ROW], ("preset",)).rows == (("tuned",),)
    assert len(next(csv.reader(io.StringIO(table_text([ROW], "csv"))))) == len(ROW)


def test_results_refuse_an_unknown_column_with_the_nearest() -> None:
    with pytest.raises(InvalidInput, match=r"unknown column 'outcom': did you mean 'outcome'"):
        table_text([ROW], "csv", ("outcom",))
