"""`conrod validate TABLE --scene SCENE` as a user types it."""

from __future__ import annotations

import json
import struct
import zipfile
from pathlib import Path

import pytest
from command_line import conrod
from table_files import ROWS, Columns, csv_text, exact_table

from conrod.scenes import SCENES

SAW = SCENES["saw-500rpm"]
VALIDATE = ("validate", "t.csv", "--scene", "saw-500rpm")


def late_table() -> Columns:
    """Three tenths of a millisecond late: so much of a step."""
    table = exact_table(SAW, ("position", "velocity"))
    table["time"] = table["time"] + 3e-4
    return table


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "t.csv").write_text(csv_text(late_table()))
    return tmp_path


@pytest.mark.usefixtures("at_once")
def test_a_table_out_of_tolerance_is_status_1_with_cause_document_and_report(folder: Path) -> None:
    before = (folder / "t.csv").read_bytes()
    done = conrod(
        *VALIDATE, "--tolerance", "position=1e-4,velocity=1e-3", "--json", "o.json", "--out", "rep", cwd=folder
    )
    assert done.returncode == 1, done.stderr
    assert "OUT OF TOLERANCE: position" in done.stdout
    assert "likely cause: each row belongs 0.0003 s (0.3 of a step) earlier than its time says" in done.stdout
    document = json.loads((folder / "o.json").read_text())
    summary, findings = document["parts"]["table"]["summary"], document["parts"]["table"]["findings"]
    assert summary["passed"] is False
    assert findings["rows"] == 2 * ROWS + 1
    assert summary["figure"] == max(curves["total"]["size"]["max"] for curves in findings["errors"].values())
    assert findings["causes"][0]["kind"] == "time offset"
    assert findings == json.loads((folder / "rep/data/table.json").read_text())
    page = (folder / "rep/README.md").read_text()
    assert "likely cause: each row belongs" in page
    assert "conrod validate t.csv --scene saw-500rpm --tolerance position=1e-4,velocity=1e-3 --out rep" in page
    assert (folder / "rep/figures/error.svg").read_text().rstrip().endswith("</svg>")
    assert (folder / "t.csv").read_bytes() == before


def test_confined_an_archive_that_asks_for_all_memory_costs_nobody_else(folder: Path) -> None:
    # Its header promises 10^13 numbers; what reads it is told so by the system, in a process of its own.
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (10000000000000,), }"
    entry = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head
    with zipfile.ZipFile(folder / "t.npz", "w") as archive:
        archive.writestr("time.npy", entry)
    done = conrod("validate", "t.npz", "--scene", "saw-500rpm", cwd=folder)
    assert done.returncode == 2
    assert done.stderr.startswith("conrod: t.npz: it")
    assert len(done.stderr.splitlines()) == 1
