"""Tables are read as people and tools write them; what cannot be used is said in one line, with its row."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from table_files import csv_text, exact_table, read_file, write_file

from conrod import InvalidInput
from conrod.models.tables import reading
from conrod.scenes import CamFollower, Saw

SAW = Saw(speed=4.0)
EXACT = exact_table(SAW, rows=12)


# -- forms -------------------------------------------------------------------------------------------------------------

STUDENTS = "\r\n".join(["My saw;;", "", "Time;x_C;y_C", "s;mm;mm", "", "0,5;1,25;-2", "", "1,5;1e1;3,0", ";;", ";;"])
PLAIN = "# by hand\n# time  C.x (mm)\n 0.0  1.5E+00\n# a break\n 1.0  2.5E+00\n"
# Text, its encoding, columns and units that are named; and the quantities that are read, SI.
FORMS: dict[str, tuple[str, str, list[str], list[str], dict[str, Any]]] = {
    "a student's spreadsheet": (STUDENTS, "utf-8-sig", [], [], {
        "time": [0.5, 1.5], "C.x": [1.25e-3, 0.01], "C.y": [-2e-3, 3e-3],
    }),
    "Latin letters of Windows": ("time,crank angle [°]\n0,0\n1,180\n", "cp1252", [], [], {
        "time": [0.0, 1.0], "crank_angle": [0.0, np.pi],
    }),
    "comments": (PLAIN, "utf-8", [], [], {"time": [0.0, 1.0], "C.x": [1.5e-3, 2.5e-3]}),
    "no headings": ("0 1.5 2\n1 2.5 2\n", "utf-8", ["time=1", "C.x=2"], [], {"time": [0.0, 1.0], "C.x": [1.5, 2.5]}),
    "columns and units by options": (
        "clock,px [in],slider.r_0[2]\n0,1,2\n10,3,4\n", "utf-8", ["time=clock", "C.x=px", "C.y=slider.r_0[2]"],
        ["ms", "mm"], {"time": [0.0, 0.01], "C.x": [0.0254, 0.0762], "C.y": [0.002, 0.004]},
    ),
    "velocities in the unit of lengths": ("t,C.x,C.vx\n0,1,2\n1,3,4\n", "utf-8", [], ["mm"], {
        "time": [0.0, 1.0], "C.x": [1e-3, 3e-3], "C.vx": [2e-3, 4e-3],
    }),
    "two rows of an event, by Modelica": ("time,C.x\n0,1\n0,1\n1,2\n1,2\n2,3\n", "utf-8", [], [], {
        "time": [0.0, 1.0, 2.0], "C.x": [1.0, 2.0, 3.0],
    }),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_tables_are_read_as_people_and_tools_write_them(form: str, tmp_path: Path) -> None:
    text, encoding, columns, units, expected = FORMS[form]
    found = read_file(write_file(tmp_path, text, encoding=encoding), SAW, columns, units)
    assert [column.name for column in found.columns] == list(expected)
    for name, numbers in expected.items():
        assert found.values[name] == pytest.approx(numbers, rel=1e-15), name


def test_table_has_the_source_of_its_units_and_unused_columns(tmp_path: Path) -> None:
    text = "time [s],px,C.y,who\n0,1,2,me\n0,1,2,me\n1,2,2,me\n"
    found = read_file(write_file(tmp_path, text), SAW, ["C.x=px"], ["m"])
    assert [(column.unit, column.unit_from) for column in found.columns] == [("s", "heading"), *[("m", "--unit")] * 2]
    assert (found.unused, found.repeated) == (("who",), 1)
    found = read_file(write_file(tmp_path, "Time,C_x\nsec,\n0,1\n0.25,2\n"), SAW)
    assert [(column.unit, column.unit_from) for column in found.columns] == [("sec", "heading"), ("m", "assumed")]
    # The only point needs no name.
    found = read_file(write_file(tmp_path, "t,x,y,vy\n0,0,1,0\n1,0,1,0\n"), CamFollower())
    assert list(found.values) == ["time", "roller.x", "roller.y", "roller.vy"]


def test_formats_have_equal_values_and_archives_planar_arrays(tmp_path: Path) -> None:
    write_file(tmp_path, csv_text(EXACT))
    np.savez(tmp_path / "t.npz", **EXACT)  # type: ignore[arg-type]
    # Commas between numbers and in them nobody can tell apart.
    for separator, decimal in ((" ", "."), ("\t", ",")):
        write_file(tmp_path, csv_text(EXACT, separator, decimal), f"{ord(separator)}.txt", "utf-8-sig")
    planar = {point: np.column_stack([EXACT[f"{point}.x"], EXACT[f"{point}.y"]]) for point in ("C", "M")}
    np.savez(tmp_path / "planar.npz", t=EXACT["time"], title=np.array("a run"), **planar)
    # Columns of single precision or whole numbers are computed with in double precision.
    short = {name: np.asarray(values, dtype="f4") for name, values in EXACT.items()}
    np.savez(tmp_path / "short.npz", **short)  # type: ignore[arg-type]
    assert {values.dtype for values in read_file(tmp_path / "short.npz", SAW).values.values()} == {np.dtype(float)}
    for name in ("t.csv", "32.txt", "9.txt", "t.npz", "planar.npz"):
        found = read_file(tmp_path / name, SAW).values
        assert {column: values.tolist() for column, values in found.items()} == {
            column: values.tolist() for column, values in EXACT.items()
        }


def table(*rows: str, head: str = "time [s],C.x [mm],C.y [mm]") -> str:
    return "\n".join([head, *rows]) + "\n"


GOOD = ("0,1,2", "1,2,3", "2,3,4")


@pytest.mark.parametrize(("text", "message"), [
    (table(*(f"{k},1,2" for k in range(30))), "it has 30 rows: at most 29 are kept"),
    (table(f"0,1,{'2' * 200_000}", *GOOD), "it is no table of numbers: field larger than"),
    (table("0,1,2"), "it has 1 row of numbers: at least 2 are needed"),
    (table(*GOOD, head="tme,C.x,C.y"), "no column for the time among 'tme', 'C.x', 'C.y'; say which it is"),
    (table("0,1,2", "2,2,3", "1,3,4"), "times are not in order: 1 s in row 4 after 2 s in row 3"),
    (table("2024-05-02 12:00,1,2", "2024-05-02 12:01,2,3"), "is no number .a time is in seconds, no date"),
    (table("0,1,2", "1,2,3", "1,2.001,3"), "times are repeated: 1 s in row 4 after 1 s in row 3"),
    (table("0,1,2", "1,nan,3", "2,3,4"), "row 3: C.x = nan is not finite"),
    (table("0,1,2", "1,1e200,2", "2,3,4"), r"row 3: C.x = 1e\+200 is too large"),
    (table("0,1,2", "1,two,3", "2,3,4"), "row 3: C.x = 'two' is no number"),
    (table("0,1,2", "1,NaN,3", "2,two,4"), "row 4: C.x = 'two' is no number"),
    (table("0,1,2", "1,2,3,4", "2,3,4"), "row 3 has more than the 3 cells"),
    (table("0,1,2", "1,2", "2,3,4"), "row 3: C.y = '' is no number"),
    (table(*GOOD, head="time [s],C.x [mm],C.y"), "mixed units: C.y has no unit, C.x is in mm"),
    (table(*GOOD, head="time [s],C.x [s],C.y [mm]"), "'s' is no unit of length"),
    (table(*GOOD, head="time,C.x,x_C"), "columns 'C.x' and 'x_C' may both be C.x: say which with --column C.x="),
])  # fmt: skip
def test_a_bad_table_is_refused_in_one_line(
    text: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reading, "MAX_TABLE_ROWS", 29)
    path = write_file(tmp_path, text)
    with pytest.raises(InvalidInput, match=message) as refused:
        read_file(path, SAW)
    assert str(refused.value).startswith(str(path))
    assert "\n" not in str(refused.value)
    assert path.read_text() == text


@pytest.mark.parametrize("row", ["1,+2,3", "1, 2 ,3", '1,"2",3', "1,2,3,"])
def test_the_same_table_without_the_slip_is_read(row: str, tmp_path: Path) -> None:
    # Negative control of the list above.
    found = read_file(write_file(tmp_path, table(GOOD[0], row, GOOD[2])), SAW).values
    assert (found["C.x"][1], found["C.y"][1]) == pytest.approx((2e-3, 3e-3))


@pytest.mark.parametrize(("columns", "units", "message"), [
    (["C.z=px"], [], r"unknown quantity 'C.z': did you mean 'C"),
    (["C.x=pxx"], [], "unknown column in --column C.x= 'pxx': did you mean 'px'\\? choose from "),
    ([], ["parsec2"], "--unit parsec2: it is no unit of time, length"),
])  # fmt: skip
def test_bad_options_name_what_is_near(columns: list[str], units: list[str], message: str, tmp_path: Path) -> None:
    path = write_file(tmp_path, "time,px,py\n0,1,2\n1,2,3\n")
    with pytest.raises(InvalidInput, match=message):
        read_file(path, SAW, columns, units)


@pytest.mark.parametrize(("content", "message"), [
    (b"PK\x03\x04", "it is no numpy archive"), (b"", "it is empty"),
    ({"time": np.array([0, {}], dtype=object)}, "Python objects, which are not loaded"),
    ({"time": np.arange(3.0), "C.x": np.arange(4.0)}, "different lengths: time 3, C.x 4"),
    ({"time": np.arange(30.0), "C.x": np.arange(30.0)}, "30 rows: at most 29 are kept: thin it out"),
])  # fmt: skip
def test_an_archive_that_makes_no_table_is_refused(
    content: Any, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reading, "MAX_TABLE_ROWS", 29)
    if isinstance(content, bytes):
        (tmp_path / "t.npz").write_bytes(content)
    else:
        np.savez(tmp_path / "t.npz", **content)
    with pytest.raises(InvalidInput, match=message):
        read_file(tmp_path / "t.npz", SAW)
