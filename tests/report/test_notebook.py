"""Results in notebooks: HTML, and data frames where pandas is installed."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import conrod
from conrod import InvalidInput
from conrod.guide.doctor.api import Diagnosis, EngineCheck, PackageCheck
from conrod.models.harden.results import HardenedModel, HardeningRun
from conrod.models.lint.findings import Finding, Report, Severity
from conrod.report.notebook import NotebookResult, data_frame
from conrod.report.table import ColouredCell, table

HEAD = "scene,quantity,angle_deg,printed,unit,place\n"
ROWS = {
    "one": "saw-40rpm,C position x,45,-42.49,mm,row 1\n",
    "two": "saw-40rpm,C position x,90,-113.65,mm,row 1\nsaw-40rpm,C position x,135,1.5,mm,row 2\n",
}
DIAGNOSIS = Diagnosis("Linux", (PackageCheck("numpy", "2.3.0", ">=2.3", True),), (EngineCheck("pymunk", "7.0"),), ())
FOUND = Finding(rule="step-too-long", what="<b>it", severity=Severity.ERROR, evidence={}, why="so", fix="halve it")
HARDENED = HardenedModel(
    "model.xml", "3.8", loops=("pin",), reference_known_to=1e-9, variants=(
        HardeningRun("as it is", 10, openings=(1e-3,), drift=2e-3), HardeningRun("hardened", 10, openings=(0.0,)),
    ),
)  # fmt: skip
RESULTS = {"doctor": DIAGNOSIS, "lint": Report("model.xml", "a run", (FOUND,)), "harden": HARDENED}


@dataclass(frozen=True)
class Frame:
    """What conrod uses of `pandas.DataFrame`."""

    rows: list[tuple[Any, ...]]
    columns: list[str]

    def __getitem__(self, column: str) -> list[Any]:
        return [row[self.columns.index(column)] for row in self.rows]


@pytest.fixture
def pandas(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pandas with no more than data frames."""
    stub = ModuleType("pandas")
    stub.DataFrame = Frame  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "pandas", stub)


def frame(result: NotebookResult, *which: int) -> Any:
    return result.to_pandas(*which)


def test_columns_of_numbers_are_numbers_in_a_data_frame(pandas: None) -> None:
    rows = [("a", "1.5e-3", "-", "< 1e-12", ColouredCell("1", "good")), ("b", "n/a", "-", "2", "2")]
    made: Any = data_frame(table(("name", "size", "none", "bound", "verdict"), rows, ("size", "none", "bound")))
    assert made["size"][0] == 1.5e-3
    assert math.isnan(made["size"][1])
    # Text stays text: a bound, a column without any number, and one that is no column of numbers.
    assert (made["none"], made["bound"], made["verdict"]) == (["-", "-"], ["< 1e-12", "2"], ["1", "2"])
    assert data_frame(table(("name", "size"), [])).columns == ["name", "size"]


def audited(folder: Path, *names: str) -> Any:
    files = [folder / f"{name}.csv" for name in names]
    for file in files:
        file.write_text(HEAD + ROWS[file.stem], encoding="utf-8")
    return conrod.audit(files)


def test_findings_become_a_data_frame_with_their_parts(pandas: None, tmp_path: Path) -> None:
    made = frame(audited(tmp_path, "one", "two"))
    assert made.columns[:3] == ["part", "document", "agrees"]
    assert (made["part"], made["agrees"], made["items"]) == (["one", "two"], [1.0, 1.0], [1.0, 2.0])


def test_a_table_that_is_not_there_is_refused(pandas: None, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"table=1: there is no such table; there are 0 \(document\)"):
        frame(audited(tmp_path, "one"), 1)
    with pytest.raises(InvalidInput, match="table=0: there is no such table; there is none"):
        frame(Report("model.xml", "a run", ()))


def test_a_missing_pandas_is_named_with_its_command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    for result in (audited(tmp_path, "one"), *RESULTS.values()):
        with pytest.raises(InvalidInput, match="pandas, which is not installed: pip install pandas"):
            frame(result)


@pytest.mark.parametrize(
    ("name", "column", "cells"),
    [
        ("doctor", "installed", ["2.3.0"]),
        ("lint", "rule", ["step-too-long"]),
        ("harden", "as it is", [10.0, 1.0, 2.0]),
    ],
)
def test_every_result_is_a_table_in_a_notebook(pandas: None, name: str, column: str, cells: list[Any]) -> None:
    result = RESULTS[name]
    assert frame(result)[column] == cells
    html = result._repr_html_()
    assert f"<th>{column}</th>" in html
    assert f"<p>{result.verdict}</p>" in html
    assert "<b>" not in html
