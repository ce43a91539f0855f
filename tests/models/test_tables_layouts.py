"""Layouts of tables of text and archives: what form each has, what is left out, and each refusal word by word."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from table_files import read_file, write_file

from conrod.errors import InvalidInput
from conrod.models.tables import reading
from conrod.models.tables.columns import Column
from conrod.models.tables.reading import Reading, check_values, split_cells
from conrod.scenes import Saw

SAW = Saw(speed=4.0)
COLUMNS = (Column("time", 0, "t [ms]", "ms", 1e-3, "heading"), Column("C.x", 1, "x [mm]", "mm", 1e-3, "heading"))


@pytest.mark.parametrize(("text", "form", "values"), [
    ("time,C.x\n0,1.5\n1,2.5\n", "text, separated by commas, decimal points", [1.5, 2.5]),
    ("time;C.x\n0;1.5\n1;2.5\n", "text, separated by semicolons, decimal points", [1.5, 2.5]),
    ("time;C.x\n0;1,5\n1;2,5\n", "text, separated by semicolons, decimal commas", [1.5, 2.5]),
    ("time\tC.x\n0\t1.5\n1\t2.5\n", "text, separated by tabs, decimal points", [1.5, 2.5]),
    ("time\tC.x\n0\t1,5\n1\t2,5\n", "text, separated by tabs, decimal commas", [1.5, 2.5]),
    ("time C.x\n0  1.5\n1 2.5\n", "text, separated by blanks, decimal points", [1.5, 2.5]),
    ("time C.x\n0 1,5\n1 2,5\n", "text, separated by blanks, decimal commas", [1.5, 2.5]),
    # Whole numbers fit both ways: commas separate.
    ("time,C.x\n0, 1\n1, 2\n", "text, separated by commas, decimal points", [1.0, 2.0]),
    ("time,C.x\n0,+1.5E-1\n1,-.5\n", "text, separated by commas, decimal points", [0.15, -0.5]),
    ("time,C.x\n\n0,1.\n ,\n1,2\n", "text, separated by commas, decimal points", [1.0, 2.0]),
    ("% made by hand\n# time,C.x\n0,1\n# a break\n1,2\n", "text, separated by commas, decimal points", [1.0, 2.0]),
    # The most common width is the table's; titles above have another.
    ("1,2,3\ntime,C.x\n0,1\n1,2\n", "text, separated by commas, decimal points", [1.0, 2.0]),
])  # fmt: skip
def test_text_is_read_in_the_layout_that_most_numbers_fit(
    text: str, form: str, values: list[float], tmp_path: Path
) -> None:
    found = read_file(write_file(tmp_path, text), SAW)
    assert found.form == form
    assert found.values["C.x"].tolist() == values
    assert found.values["time"].tolist() == [0.0, 1.0]


def test_other_encodings_are_named(tmp_path: Path) -> None:
    found = read_file(write_file(tmp_path, "time,crank angle [°]\n0,0\n1,180\n", encoding="cp1252"), SAW)
    assert found.form.startswith("text, separated by commas, decimal points, ")
    assert "UTF-8" not in found.form


@pytest.mark.parametrize(("text", "columns", "unused"), [
    ("time,who,C.x,why\n0,1,2,3\n1,2,3,4\n", ["time", "C.x"], ("who", "why")),
    # A row of units under the names; a name with another unit is none that is known.
    ("time,C.x,C.y [cm]\ns,mm,mm\n0,1,2\n1,2,3\n", ["time [s]", "C.x [mm]"], ("C.y [cm] [mm]",)),
    ("time,C.x [mm],who\ns,mm,-\n0,1,2\n1,2,3\n", ["time [s]", "C.x [mm]"], ("who",)),
    # Rows above with other widths are titles, and one that is no unit is the row of names.
    ("a,b,c\ntime,C.x\n0,1\n1,2\n", ["time", "C.x"], ()),
    ("old,names\ntime,C.x\n0,1\n1,2\n", ["time", "C.x"], ()),
])  # fmt: skip
def test_headings_are_the_last_row_above_the_numbers(
    text: str, columns: list[str], unused: tuple[str, ...], tmp_path: Path
) -> None:
    found = read_file(write_file(tmp_path, text), SAW)
    assert [column.heading for column in found.columns] == columns
    assert found.unused == unused


def test_columns_without_headings_have_numbers(tmp_path: Path) -> None:
    found = read_file(write_file(tmp_path, "0 1 2\n1 2 3\n"), SAW, ["time=1", "C.x=3"])
    assert [column.heading for column in found.columns] == ["1", "3"]
    assert found.unused == ("2",)


@pytest.mark.parametrize(("line", "separator", "cells"), [
    ('a, "b,c" ,d', ",", ["a", "b,c", "d"]), ("a; b ;", ";", ["a", "b", ""]), ('"a"  b\tc', " ", ["a", "b", "c"]),
    ("a\t b", "\t", ["a", "b"]),
])  # fmt: skip
def test_lines_are_split_into_cells_without_blanks(line: str, separator: str, cells: list[str]) -> None:
    assert split_cells(line, separator) == cells


@pytest.mark.parametrize(("text", "message"), [
    ("", "it is empty"),
    *(
        (text, "there is no row of numbers with at least two columns in its first 400 rows; give times in seconds, not "
         "as dates")
        for text in ("time,C.x\nlate,far\n", "time\n0\n1\n")
    ),
    ("time,C.x\n0,1\n1,2,3\n2,3\n", "row 3 has more than the 2 cells of the table's columns"),
    ("time,C.x\n0,1\n1,far\n2,3\n", "row 3: C.x = 'far' is no number (a time is in seconds, no date)"),
    ("time,C.x\n0,1\n1\n2,3\n", "row 3: C.x = '' is no number (a time is in seconds, no date)"),
    ("time,C.x\n0,1\n", "it has 1 row of numbers: at least 2 are needed"),
    ("time,C.x\n0,1\n1,-inf\n", "row 3: C.x = -inf is not finite"),
    ("time,C.x\n\n0,1\n1,2\n1,3\n", "times are repeated: 1 s in row 5 after 1 s in row 4"),
    ("time,C.x\n0,1\n1,2\n0.5,3\n", "times are not in order: 0.5 s in row 4 after 1 s in row 3"),
])  # fmt: skip
def test_text_that_is_no_table_is_refused(text: str, message: str, tmp_path: Path) -> None:
    path = write_file(tmp_path, text)
    with pytest.raises(InvalidInput) as refused:
        read_file(path, SAW)
    assert str(refused.value) == f"{path}: {message}"


def checked(values: Any, numbers: Any = None) -> Reading:
    array = np.array(values, dtype=float).reshape(-1, 2)
    return check_values(
        COLUMNS, array, np.arange(1, len(array) + 1) if numbers is None else numbers, ("who",), "a form"
    )


def test_values_are_scaled_to_si_and_events_left_out() -> None:
    found = checked([[0, 1], [0, 1], [10, 2], [20, 3], [20, 3]])
    assert (found.columns, found.unused, found.form, found.repeated) == (COLUMNS, ("who",), "a form", 2)
    assert found.values["time"] == pytest.approx([0.0, 0.01, 0.02])
    assert found.values["C.x"] == pytest.approx([0.001, 0.002, 0.003])
    assert Reading({}, (), (), "").repeated == 0
    # A thousandth of a billionth of the largest value of a column is the same value; more is another row.
    assert checked([[0, 1], [10, 1000.0], [10, 1000.0 + 0.9e-9]]).repeated == 1
    with pytest.raises(InvalidInput, match=r"^times are repeated: 0\.01 s in row 3 after 0\.01 s in row 2$"):
        checked([[0, 1], [10, 1000.0], [10, 1000.0 + 1.1e-9]])


@pytest.mark.parametrize(("values", "message"), [
    ([], "it has 0 rows of numbers: at least 2 are needed"),
    ([[0, 1]], "it has 1 row of numbers: at least 2 are needed"),
    ([[0, 1], [1, np.nan]], "row 12: C.x = nan is not finite"),
    # 1e33 mm are 1e30 m.
    ([[0, 1], [1, 1.01e33]], "row 12: C.x = 1.01e+33 is too large to be a motion"),
    ([[0, 1], [-1e40, 2]], "row 12: time = -1e+40 is too large to be a motion"),
    ([[0, 1], [1, 2], [1, 3]], "times are repeated: 0.001 s in row 13 after 0.001 s in row 12"),
    ([[5, 1], [1, 2]], "times are not in order: 0.001 s in row 12 after 0.005 s in row 11"),
])  # fmt: skip
def test_values_that_are_no_motion_are_refused(values: Any, message: str) -> None:
    with pytest.raises(InvalidInput) as refused:
        checked(values, np.arange(11, 11 + len(values)))
    assert str(refused.value) == message


def test_large_values_within_the_limit_are_kept() -> None:
    assert checked([[0, 1], [1, 0.99e33]]).values["C.x"][1] == pytest.approx(0.99e30)


# -- archives --------------------------------------------------------------------------------------------------------


def test_archive_holds_columns_and_planar_arrays(tmp_path: Path) -> None:
    file = tmp_path / "t.npz"
    numbers = np.arange(3)
    np.savez(file, time=numbers, C=np.column_stack([numbers, numbers + 1.0]), M=np.ones((3, 3)), words=np.array(["a"]),
             flags=np.array([True]), cube=np.ones((2, 2, 2)), other=numbers.astype(np.float32))  # fmt: skip
    found = read_file(file, SAW)
    assert found.form == "numpy archive"
    assert {name: values.tolist() for name, values in found.values.items()} == {
        "time": [0.0, 1.0, 2.0], "C.x": [0.0, 1.0, 2.0], "C.y": [1.0, 2.0, 3.0],
    }  # fmt: skip
    assert found.unused == ("other",)
    bad = tmp_path / "bad.NPZ"
    np.savez(tmp_path / "u.npz", time=np.array([0.0, 1.0, 0.5]), C=np.ones((3, 2)))
    (tmp_path / "u.npz").rename(bad)
    with pytest.raises(InvalidInput, match=r"times are not in order: 0\.5 s in row 3 after 1 s in row 2$"):
        read_file(bad, SAW)


@pytest.mark.parametrize(("content", "message"), [
    (b"PK\x03\x04", "it is no numpy archive, or holds Python objects, which are not loaded"),
    ({"time": np.arange(3.0), "C.x": np.arange(4.0)}, "columns of different lengths: time 3, C.x 4"),
    ({"time": np.arange(30.0), "C.x": np.arange(30.0)}, "it has 30 rows: at most 29 are kept: thin it out"),
])  # fmt: skip
def test_archives_that_make_no_table_are_refused(
    content: Any, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reading, "MAX_TABLE_ROWS", 29)
    file = tmp_path / "t.npz"
    if isinstance(content, bytes):
        file.write_bytes(content)
    else:
        np.savez(file, **content)
    with pytest.raises(InvalidInput) as refused:
        read_file(file, SAW)
    assert str(refused.value) == f"{file}: {message}"
    monkeypatch.setattr(reading, "MAX_TABLE_ROWS", 30)
    if "30 rows" in message:
        assert len(read_file(file, SAW).values["time"]) == 30
