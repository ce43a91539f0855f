"""What cannot be used of a table is said in one line, with its row, and the table stays as it is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from table_files import exact_table, read, write_all_formats, written

from conrod import InvalidInput
from conrod.own.tables import reading
from conrod.scenes import Saw

SAW = Saw(speed=4.0)
EXACT = exact_table(SAW, rows=12)


def table(*rows: str, head: str = "time [s],C.x [mm],C.y [mm]") -> str:
    return "\n".join([head, *rows]) + "\n"


GOOD = ("0,1,2", "1,2,3", "2,3,4")


@pytest.mark.parametrize(("text", "message"), [
    (table("0,1,2"), "it has 1 row of numbers: at least 2 are needed"),
    (table(*GOOD, head="tme,C.x,C.y"), "no column for the time among 'tme', 'C.x', 'C.y'; say which it is"),
    (table("0,1,2", "2,2,3", "1,3,4"), "times are not in order: 1 s in row 4 after 2 s in row 3"),
    (table("2024-05-02 12:00,1,2", "2024-05-02 12:01,2,3"), "is no number .a time is in seconds, no date"),
    (table("0,1,2", "1,2,3", "1,2.001,3"), "times are repeated: 1 s in row 4 after 1 s in row 3"),
    (table("0,1,2", "1,nan,3", "2,3,4"), "row 3: C.x = nan is not finite"),
    (table("0,1,2", "1,1e200,2", "2,3,4"), r"row 3: C.x = 1e\+200 is too large"),
    (table("0,1,2", "1,two,3", "2,3,4"), "row 3: C.x = 'two' is no number"),
    (table("0,1,2", "1,2,3,4", "2,3,4"), "row 3 has more than the 3 cells"),
    (table("0,1,2", "1,2", "2,3,4"), "row 3: C.y is empty"),
    (table(*GOOD, head="time [s],C.x [mm],C.y"), "mixed units: C.y has no unit, C.x is in mm"),
    (table(*GOOD, head="time [s],C.x [s],C.y [mm]"), "'s' is no unit of length"),
    (table(*GOOD, head="time,C.x,x_C"), "columns 'C.x' and 'x_C' may both be C.x: say which with --column C.x="),
])  # fmt: skip
def test_a_bad_table_is_refused_in_one_line(text: str, message: str, tmp_path: Path) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InvalidInput, match=message) as refused:
        read(path, SAW)
    assert str(refused.value).startswith(str(path))
    assert "\n" not in str(refused.value)
    assert path.read_text() == text


@pytest.mark.parametrize("row", ["1,+2,3", "1, 2 ,3", '1,"2",3', "1,2,3,"])
def test_the_same_table_without_the_slip_is_read(row: str, tmp_path: Path) -> None:
    # Negative control of the list above.
    found = read(written(tmp_path, table(GOOD[0], row, GOOD[2])), SAW).observed
    assert found.points["C"]["position"].values[1] == pytest.approx([2e-3, 3e-3])


NO_ARCHIVES = (b"no such thing", b"PK\x03\x04", b"")


@pytest.mark.parametrize(("name", "content", "message"), [
    ("t.csv", b"\x00\x01\x02" * 100, "it holds zero bytes; save a sheet as CSV"),
    *((f"t.{kind}", bad, "it is no|it is empty") for kind in ("npz", "parquet") for bad in NO_ARCHIVES),
])  # fmt: skip
def test_files_that_are_not_what_they_are_called_are_refused(
    name: str, content: bytes, message: str, tmp_path: Path
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InvalidInput, match=message):
        read(tmp_path / name, SAW)


@pytest.mark.parametrize(("kind", "columns", "message"), [
    ("npz", {"time": np.array([0, {}], dtype=object)}, "Python objects, which are not loaded"),
    ("npz", {"time": np.arange(3.0), "C.x": np.arange(4.0)}, "different lengths: time 3, C.x 4"),
    ("parquet", {"time": [0.0, 1.0], "C.x": ["a", "b"]}, r"column 'C.x' \(string\) cannot be read as numbers"),
])  # fmt: skip
def test_columns_of_an_archive_that_make_no_table_are_refused(
    kind: str, columns: dict[str, Any], message: str, tmp_path: Path
) -> None:
    import pyarrow
    import pyarrow.parquet

    path = tmp_path / f"t.{kind}"
    if kind == "npz":
        np.savez(path, **columns)
    else:
        pyarrow.parquet.write_table(pyarrow.table(columns), path)
    with pytest.raises(InvalidInput, match=message):
        read(path, SAW)


@pytest.mark.parametrize("kind", ["csv", "npz"])
def test_more_rows_than_are_kept_are_refused(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_all_formats(EXACT, tmp_path)
    monkeypatch.setattr(reading, "MOST_ROWS", len(EXACT["time"]) - 1)
    with pytest.raises(InvalidInput, match=r"rows.*kept: thin it out"):
        read(tmp_path / f"t.{kind}", SAW)


@pytest.mark.parametrize(("columns", "units", "message"), [
    (["C.z=px"], [], r"unknown quantity 'C.z': did you mean 'C"),
    (["C.x=pxx"], [], "unknown column in --column C.x= 'pxx': did you mean 'px'\\? choose from "),
    ([], ["parsec2"], "--unit parsec2: it is no unit of time, length"),
])  # fmt: skip
def test_bad_options_name_what_is_near(columns: list[str], units: list[str], message: str, tmp_path: Path) -> None:
    path = written(tmp_path, "time,px,py\n0,1,2\n1,2,3\n")
    with pytest.raises(InvalidInput, match=message):
        read(path, SAW, columns, units)
