"""Tables are read as people and tools write them, and what cannot be used is said in one line."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from conrod import InvalidInput
from conrod.own.tables.headings import factor, meant_by, readings, targets
from conrod.report.pack.export import as_csv, exact_columns
from conrod.scenes import SCENES, CamFollower, Saw
from tests.support.table_files import csv_text, exact_table, read, write_all_formats, written

SAW = Saw(speed=4.0)
EXACT = exact_table(SAW, rows=12)


# -- headings and units ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("heading", "name", "unit"),
    [
        ("C.x [mm]", "C.x", "mm"),
        ("time (s)", "time", "s"),
        ("crank_angle/deg", "crank_angle", "deg"),
        ("x_C in mm", "C.x", "mm"),
        ("t_ms", "time", "ms"),
        ("  TIME  ( sec ) ", "time", "sec"),
        ("C.vx / (mm/s)", "C.vx", "mm/s"),
        ("vx_C [m/s]", "C.vx", "m/s"),
        ("xC", "C.x", ""),
        ("C_x", "C.x", ""),
        ("theta [°]", "crank_angle", "°"),
        ("C.ax {m/s²}", "C.ax", "m/s²"),
        ("Zeit, s", "time", "s"),
        ("ydot_M", "M.vy", ""),
    ],
)
def test_headings_tell_name_and_unit(heading: str, name: str, unit: str) -> None:
    known = targets(("C", "M"))
    found = [(meant, u) for text, u in readings(heading) if (meant := meant_by(text, known)) is not None]
    # Without its brackets a heading may mean the same; the unit is not lost.
    assert {meant.name for meant, _ in found} == {name}
    assert found[-1][1] == unit


@pytest.mark.parametrize(
    ("unit", "dimension", "size"),
    [
        ("mm", "m", 1e-3), ("in", "m", 0.0254), ("ms", "s", 1e-3), ("deg", "rad", np.pi / 180.0),
        ("°", "rad", np.pi / 180.0), ("rpm", "rad/s", np.pi / 30.0), ("deg/s", "rad/s", np.pi / 180.0),
        ("mm/s", "m/s", 1e-3), ("m/s2", "m/s^2", 1.0),
        ("mm/s**2", "m/s^2", 1e-3), ("m.s-2", "m/s^2", 1.0), ("g", "m/s^2", 9.80665), ("rev", "rad", 2.0 * np.pi),
        ("MM", "m", 1e-3), ("Sec", "s", 1.0),
    ],
)  # fmt: skip
def test_units_of_other_tools_are_known(unit: str, dimension: str, size: float) -> None:
    assert factor(unit, dimension) == pytest.approx(size, rel=1e-14)


@pytest.mark.parametrize(("unit", "dimension"), [("mm", "s"), ("g", "m"), ("C", "m"), ("Hz", "rad/s"), ("dt", "s")])
def test_what_is_no_unit_of_the_dimension_is_none(unit: str, dimension: str) -> None:
    assert factor(unit, dimension) is None


def test_case_tells_a_point_from_an_acceleration() -> None:
    known = targets(("A", "G"))
    assert meant_by("Ax", known).name == "A.x"  # type: ignore[union-attr]
    # Which point's acceleration would it be?
    assert meant_by("ay", targets(("roller",))).name == "roller.ay"  # type: ignore[union-attr]
    assert meant_by("x", known) is None


def test_the_only_point_needs_no_name(tmp_path: Path) -> None:
    path = written(tmp_path, "t,x,y,vy\n0,0,1,0\n1,0,1,0\n")
    found = read(path, CamFollower())
    assert [column.target.name for column in found.columns] == ["time", "roller.x", "roller.y", "roller.vy"]


def test_options_name_columns_and_units(tmp_path: Path) -> None:
    path = written(tmp_path, "clock,px [in],slider.r_0[2]\n0,1,2\n10,3,4\n")
    found = read(path, SAW, ["time=clock", "C.x=px", "C.y=slider.r_0[2]"], ["ms", "C.y=mm"])
    observed = found.observed
    assert observed.times.tolist() == [0.0, 0.01]
    samples = observed.points["C"]["position"]
    assert np.allclose(samples.values, [[0.0254, 0.002], [0.0762, 0.004]], rtol=1e-15)
    assert [column.unit_from for column in found.columns] == ["--unit", "heading", "--unit"]


def test_velocities_follow_the_unit_of_lengths_that_was_given(tmp_path: Path) -> None:
    path = written(tmp_path, "t,C.x,C.vx\n0,1,2\n1,3,4\n")
    found = read(path, SAW, units=["mm"])
    assert [(c.target.name, c.unit) for c in found.columns] == [("time", "s"), ("C.x", "mm"), ("C.vx", "mm/s")]


def test_columns_without_headings_are_called_by_number(tmp_path: Path) -> None:
    path = written(tmp_path, "0 1.5 2\n1 2.5 2\n", "t.txt")
    found = read(path, SAW, ["time=1", "C.x=2"])
    assert found.observed.points["C"]["position"].values.tolist() == [[1.5], [2.5]]


# -- forms -------------------------------------------------------------------------------------------------------------


def test_a_students_spreadsheet_is_read(tmp_path: Path) -> None:
    lines = ["My saw;;", "", "Zeit;x_C;y_C", "s;mm;mm", "", "0,5;1,25;-2", "", "1,5;1e1;3,0", ";;", ";;"]
    found = read(written(tmp_path, "\r\n".join(lines), encoding="utf-8-sig"), SAW)
    assert found.observed.times.tolist() == [0.5, 1.5]
    assert found.observed.points["C"]["position"].values == pytest.approx(1e-3 * np.array([[1.25, -2], [10, 3]]))
    assert "semicolons, decimal commas" in found.form


# Commas between numbers and in them nobody can tell apart.
@pytest.mark.parametrize(
    ("separator", "decimal"), [(",", "."), (";", "."), ("\t", "."), (" ", "."), (";", ","), ("\t", ","), (" ", ",")]
)
def test_separator_decimal_mark_and_encoding_are_told(separator: str, decimal: str, tmp_path: Path) -> None:
    for encoding in ("utf-8", "utf-8-sig", "utf-16"):
        found = read(written(tmp_path, csv_text(EXACT, separator, decimal), encoding=encoding), SAW).observed
        assert np.array_equal(found.times, EXACT["time"])
        assert np.array_equal(found.points["M"]["position"].values[:, 1], EXACT["M.y"])


def test_latin_letters_of_windows_are_read(tmp_path: Path) -> None:
    path = written(tmp_path, "time,crank angle [°]\n0,0\n1,180\n", encoding="cp1252")
    assert read(path, SAW).observed.angle == pytest.approx([0.0, np.pi])


def test_comments_quotes_and_fortran_numbers_are_read(tmp_path: Path) -> None:
    plain = "# by hand\n# time  C.x (mm)\n 0.0  1.5D+00\n# a break\n 1.0  2.5D+00\n"
    found = read(written(tmp_path, plain, "t.txt"), SAW)
    assert found.observed.points["C"]["position"].values.ravel() == pytest.approx([1.5e-3, 2.5e-3], rel=1e-15)
    quoted = read(written(tmp_path, '"time [s]","C.x [m]","who, when"\n"0","1","me, now"\n"1","2","me, then"\n'), SAW)
    assert quoted.observed.points["C"]["position"].values.tolist() == [[1.0], [2.0]]
    assert quoted.unused == ("who, when",)


@pytest.mark.parametrize("kind", ["csv", "npz", "parquet"])
def test_all_formats_say_the_same(kind: str, tmp_path: Path) -> None:
    write_all_formats(EXACT, tmp_path)
    found = read(tmp_path / f"t.{kind}", SAW).observed
    assert np.array_equal(found.times, EXACT["time"])
    for point in ("C", "M"):
        stacked = np.column_stack([EXACT[f"{point}.x"], EXACT[f"{point}.y"]])
        assert np.array_equal(found.points[point]["position"].values, stacked)


def test_archives_may_hold_planar_arrays_and_units(tmp_path: Path) -> None:
    path = tmp_path / "t.npz"
    planar = np.column_stack([EXACT["C.x"], EXACT["C.y"]]) * 1e3
    units = np.array([["C.x", "mm"], ["C.y", "mm"], ["t", "s"]])
    np.savez(path, t=EXACT["time"], C=planar, units=units, title=np.array("a run"))
    found = read(path, SAW)
    assert found.observed.points["C"]["position"].values == pytest.approx(planar * 1e-3, rel=1e-15)


def test_parquet_says_in_one_line_what_it_needs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    (tmp_path / "t.parquet").write_bytes(b"PAR1")
    with pytest.raises(InvalidInput, match=r"needs pyarrow: pip install 'conrod\[parquet\]'"):
        read(tmp_path / "t.parquet", SAW)


@pytest.mark.parametrize("name", SCENES)
def test_conrods_own_export_is_read_whole(name: str, tmp_path: Path) -> None:
    scene = SCENES[name]
    found = read(written(tmp_path, as_csv(exact_columns(scene, 36, 1))), scene)
    assert set(found.observed.points) == set(scene.lengths)
    for samples in found.observed.points.values():
        assert set(samples) == {"position", "velocity", "acceleration"}
    assert all(".j" in heading for heading in found.unused)
    assert len(found.unused) == 2 * len(scene.lengths)


def test_units_in_every_cell_are_those_of_the_column(tmp_path: Path) -> None:
    # As MATLAB writes a timetable.
    path = written(tmp_path, "Time,C_x\n0 sec,1\n0.25 sec,2\n")
    found = read(path, SAW)
    assert found.observed.times.tolist() == [0.0, 0.25]
    assert [(column.unit, column.unit_from) for column in found.columns] == [("sec", "rows"), ("m", "assumed")]
    assert read(written(tmp_path, "Time,C_x\n0 ms,1\n250 ms,2\n"), SAW).observed.times.tolist() == [0.0, 0.25]
    with pytest.raises(InvalidInput, match=r"row 3: time = '250 ms' is no number"):
        read(written(tmp_path, "Time,C_x\n0 sec,1\n250 ms,2\n"), SAW)


def test_the_second_row_of_an_event_is_left_out(tmp_path: Path) -> None:
    # As Modelica tools write; a clock with too few digits is something else, and refused.
    found = read(written(tmp_path, "time,C.x\n0,1\n0,1\n1,2\n1,2\n2,3\n"), SAW)
    assert found.observed.times.tolist() == [0.0, 1.0, 2.0]
    assert found.observed.points["C"]["position"].values.ravel().tolist() == [1.0, 2.0, 3.0]
    assert found.repeated == 2
    with pytest.raises(InvalidInput, match="times are repeated: 1 s in row 4 after 1 s in row 3"):
        read(written(tmp_path, "time,C.x\n0,1\n1,2\n1,2.001\n2,3\n"), SAW)


@pytest.mark.parametrize(
    ("row", "values"),
    [
        ("1,+2,3", [2.0, 3.0]), ("1, 2 ,3", [2.0, 3.0]), ('1,"2",3', [2.0, 3.0]), ("1,2D0,3", [2.0, 3.0]),
        ("1,NA,3", "C.x = 'NA' is no number"), ("1,0x10,3", "C.x = '0x10' is no number"),
    ],
)  # fmt: skip
def test_cells_are_numbers_as_people_write_them_or_refused(row: str, values: list[float] | str, tmp_path: Path) -> None:
    path = written(tmp_path, f"time,C.x,C.y\n0,1,2\n{row}\n2,3,4\n")
    if isinstance(values, str):
        with pytest.raises(InvalidInput, match=f"row 3:? {values}"):
            read(path, SAW)
    else:
        assert read(path, SAW).observed.points["C"]["position"].values[1].tolist() == values
