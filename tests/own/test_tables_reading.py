"""Tables are read as people and tools write them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from table_files import csv_text, exact_table, read, write_all_formats, written

from conrod import InvalidInput
from conrod.own.tables.headings import factor, meant_by, parted, targets
from conrod.report.pack import as_csv, exact_columns
from conrod.scenes import SCENES, CamFollower, Saw

SAW = Saw(speed=4.0)
EXACT = exact_table(SAW, rows=12)


# -- headings and units ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("heading", "name", "unit"), [
    ("C.x [mm]", "C.x", "mm"), ("  TIME  ( sec ) ", "time", "sec"), ("vx_C [m/s]", "C.vx", "m/s"), ("xC", "C.x", ""),
    ("theta [°]", "crank_angle", "°"),
])  # fmt: skip
def test_headings_tell_name_and_unit(heading: str, name: str, unit: str) -> None:
    text, found = parted(heading)
    meant = meant_by(text, targets(("C", "M")))
    assert (meant and meant.name, found) == (name, unit)


@pytest.mark.parametrize(("unit", "dimension", "size"), [
    ("mm", "m", 1e-3), ("in", "m", 0.0254), ("°", "rad", np.pi / 180.0), ("rpm", "rad/s", np.pi / 30.0),
    ("mm/s**2", "m/s^2", 1e-3), ("sec", "s", 1.0), ("mm", "s", None), ("C", "m", None), ("Hz", "rad/s", None),
])  # fmt: skip
def test_units_of_other_tools_are_known_and_no_others(unit: str, dimension: str, size: float | None) -> None:
    assert factor(unit, dimension) == (size if size is None else pytest.approx(size, rel=1e-14))


def test_case_tells_a_point_from_an_acceleration() -> None:
    meant = [meant_by(*one) for one in (("Ax", targets(("A", "G"))), ("ay", targets(("roller",))))]
    assert [one and one.name for one in meant] == ["A.x", "roller.ay"]
    assert meant_by("x", targets(("A", "G"))) is None  # of which point?


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
    found = read(written(tmp_path, text, encoding=encoding), SAW, columns, units)
    assert [column.target.name for column in found.columns] == list(expected)
    values = {"time": found.observed.times, "crank_angle": found.observed.angle}
    for point, quantities in found.observed.points.items():
        for samples, letter in zip(quantities.values(), ("", "v"), strict=False):
            values |= {f"{point}.{letter}{'xy'[a]}": samples.values[:, k] for k, a in enumerate(samples.axes)}
    for name, numbers in expected.items():
        assert values[name] == pytest.approx(numbers, rel=1e-15), name


def test_what_is_read_says_where_its_units_are_from_and_what_is_left_out(tmp_path: Path) -> None:
    text = "time [s],px,C.y,who\n0,1,2,me\n0,1,2,me\n1,2,2,me\n"
    found = read(written(tmp_path, text), SAW, ["C.x=px"], ["m"])
    assert [(column.unit, column.unit_from) for column in found.columns] == [("s", "heading"), *[("m", "--unit")] * 2]
    assert (found.unused, found.repeated) == (("who",), 1)
    found = read(written(tmp_path, "Time,C_x\nsec,\n0,1\n0.25,2\n"), SAW)
    assert [(column.unit, column.unit_from) for column in found.columns] == [("sec", "heading"), ("m", "assumed")]


def test_the_only_point_needs_no_name(tmp_path: Path) -> None:
    found = read(written(tmp_path, "t,x,y,vy\n0,0,1,0\n1,0,1,0\n"), CamFollower())
    assert [column.target.name for column in found.columns] == ["time", "roller.x", "roller.y", "roller.vy"]


# Commas between numbers and in them nobody can tell apart.
@pytest.mark.parametrize(("separator", "decimal"), [(",", "."), (" ", "."), (";", ","), ("\t", ",")])
def test_separator_decimal_mark_and_encoding_are_told(separator: str, decimal: str, tmp_path: Path) -> None:
    found = read(written(tmp_path, csv_text(EXACT, separator, decimal), encoding="utf-8-sig"), SAW).observed
    assert np.array_equal(found.times, EXACT["time"])
    assert np.array_equal(found.points["M"]["position"].values[:, 1], EXACT["M.y"])


def test_all_formats_say_the_same_and_archives_may_hold_planar_arrays(tmp_path: Path) -> None:
    write_all_formats(EXACT, tmp_path)
    planar = {point: np.column_stack([EXACT[f"{point}.x"], EXACT[f"{point}.y"]]) for point in ("C", "M")}
    np.savez(tmp_path / "planar.npz", t=EXACT["time"], title=np.array("a run"), **planar)
    for name in ("t.csv", "t.npz", "t.parquet", "planar.npz"):
        found = read(tmp_path / name, SAW).observed
        assert np.array_equal(found.times, EXACT["time"])
        for point in ("C", "M"):
            assert found.points[point]["position"].values == pytest.approx(planar[point], rel=1e-15)


def test_parquet_says_in_one_line_what_it_needs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    (tmp_path / "t.parquet").write_bytes(b"PAR1")
    with pytest.raises(InvalidInput, match=r"needs pyarrow: pip install pyarrow"):
        read(tmp_path / "t.parquet", SAW)


@pytest.mark.parametrize("name", ["saw-500rpm", "cam-follower"])
def test_conrods_own_export_is_read_whole(name: str, tmp_path: Path) -> None:
    scene = SCENES[name]
    found = read(written(tmp_path, as_csv(exact_columns(scene, 36, 1))), scene)
    assert set(found.observed.points) == set(scene.lengths)
    assert all(len(samples) == 3 for samples in found.observed.points.values())
    assert all(".j" in heading for heading in found.unused)
