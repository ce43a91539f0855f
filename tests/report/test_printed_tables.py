"""Tables that pages print are those that their commands make; one that is not is named."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from conrod import InvalidInput
from docs.studies import printed_tables
from docs.studies.printed_tables import COMMAND, END, TABLES, PrintedTable, agrees, main, printed_cells, stale_cells


def small_cell(row: str, column: str) -> str:
    return "0.5" if row.endswith("stock") else "diverged"


SMALL = PrintedTable("page.md", "scene | preset", ("`a` | stock", "`a` | tuned"), ("1 ms",), small_cell)
PAGE = f"# P\n\n<!-- {COMMAND} small -->\n\n{{}}\n\n{END}\n\nmore\n"


@pytest.fixture
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A page with a table of its own."""
    monkeypatch.setattr(printed_tables, "DOCS", tmp_path)
    monkeypatch.setattr(printed_tables, "TABLES", {"small": SMALL})
    (tmp_path / "page.md").write_text(PAGE.format(SMALL.text()), encoding="utf-8")
    return tmp_path / "page.md"


@pytest.mark.parametrize("name", TABLES)
def test_page_prints_every_cell_of_its_table(name: str) -> None:
    assert set(printed_cells(name, TABLES[name])) == {*TABLES[name].cells()}


@pytest.mark.parametrize(
    ("name", "row", "column"),
    [
        ("free-motion-steps", "`pendulum` | stock", "10 ms"),
        ("free-motion-steps", "`saw-coasting` | stock", "10 ms"),
        ("free-motion-chains", "position", "2"),
    ],
)
def test_printed_cell_is_what_is_measured_today(name: str, row: str, column: str) -> None:
    one = TABLES[name]
    assert agrees(printed_cells(name, one)[row, column], one.cell(row, column), one.factor)


@pytest.mark.parametrize(
    ("printed", "measured", "factor", "same"),
    [
        ("3.7e-8", "3.5e-8", 1.0, True),
        ("3.7e-8", "3.4e-8", 1.0, False),
        ("3.7e-8", "3.4e-8", 1.2, True),
        ("0.014", "0.016", 1.0, True),
        ("0.014", "0.017", 1.0, False),
        ("diverged", "0.017", 9.0, False),
        ("diverged", "diverged", 1.0, True),
        ("2.5 s", "2.5 ms", 1.0, False),
        ("1e-8", "-3e-8", 100.0, False),
    ],
)
def test_cell_agrees_within_two_units_of_its_last_digit(printed: str, measured: str, factor: float, same: bool) -> None:
    assert agrees(printed, measured, factor) is same


def test_cell_that_is_not_todays_is_named(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert list(stale_cells(60.0, random.Random(1))) == []
    page.write_text(page.read_text().replace("0.5", "0.9"))
    assert list(stale_cells(60.0, random.Random(1))) == ["docs/page.md: small: `a` | stock, 1 ms: 0.9, today 0.5"]
    monkeypatch.setattr(printed_tables, "TABLES", {"small": replace(SMALL, rows=SMALL.rows[1:])})
    assert list(stale_cells(60.0, random.Random(1))) == [
        "docs/page.md: small: cell `a` | stock, 1 ms is not of today's table"
    ]


def test_table_is_written_into_its_page_alone(page: Path, capsys: pytest.CaptureFixture[Any]) -> None:
    page.write_text(PAGE.format("| old |"))
    main(["small", "--write"])
    assert page.read_text() == PAGE.format(SMALL.text())
    with pytest.raises(InvalidInput, match="unknown table 'smal': did you mean 'small'"):
        main(["smal"])
    assert "diverged" in capsys.readouterr().out
