"""Headings of tables: what each column is, in what unit, and what is said of one that cannot be told."""

from __future__ import annotations

import math

import pytest

from conrod.errors import InvalidInput
from conrod.models.tables.columns import (
    Column,
    ColumnRequest,
    bare_unit,
    choose_columns,
    column_request,
    column_with_unit,
    factor_to_si,
    is_unit,
    quantities,
    quantity_named,
    split_heading,
)

POINTS = ("A", "B_1")
NOTHING = ColumnRequest({}, ())


def chosen(*headings: str, columns: dict[str, str] | None = None, units: tuple[str, ...] = ()) -> dict[str, int]:
    """Place of each quantity in a table."""
    found = choose_columns(headings, POINTS, ColumnRequest(columns or {}, units))
    return {column.name: column.index for column in found}


def refusal(*headings: str, columns: dict[str, str] | None = None, units: tuple[str, ...] = ()) -> str:
    with pytest.raises(InvalidInput) as refused:
        chosen(*headings, columns=columns, units=units)
    return str(refused.value)


def test_quantities_of_two_points_have_si_units_in_order() -> None:
    assert quantities(("A", "B")) == {
        "time": "s", "crank_angle": "rad", "crank_speed": "rad/s", "crank_acceleration": "rad/s^2",
        "A.x": "m", "A.y": "m", "A.vx": "m/s", "A.vy": "m/s", "A.ax": "m/s^2", "A.ay": "m/s^2",
        "B.x": "m", "B.y": "m", "B.vx": "m/s", "B.vy": "m/s", "B.ax": "m/s^2", "B.ay": "m/s^2",
    }  # fmt: skip
    assert list(quantities(("A",)))[:4] == ["time", "crank_angle", "crank_speed", "crank_acceleration"]


@pytest.mark.parametrize(("heading", "points", "name"), [
    ("time", POINTS, "time"), ("Time", POINTS, "time"), ("t", POINTS, "time"), ("T", POINTS, "time"),
    ("theta", POINTS, "crank_angle"), ("omega", POINTS, "crank_speed"), ("alpha", POINTS, "crank_acceleration"),
    ("Crank angle", POINTS, "crank_angle"), ("crank-speed", POINTS, "crank_speed"),
    ("A.x", POINTS, "A.x"), ("x_A", POINTS, "A.x"), ("Ax", POINTS, "A.x"), ("xA", POINTS, "A.x"),
    ("vy A", POINTS, "A.vy"), ("a.vy", POINTS, "A.vy"), ("B1.ay", POINTS, "B_1.ay"), ("ay_B_1", POINTS, "B_1.ay"),
    # Without a point it is that of the only one.
    ("x", ("A",), "A.x"), ("vy", ("A",), "A.vy"), ("x", POINTS, None), ("vy", POINTS, None),
    # A capital letter tells a point from a letter of a quantity: Ax is x of A, ax an acceleration.
    ("Ax", ("A",), "A.x"), ("ax", ("A",), "A.ax"), ("ax", ("A", "B"), "A.x"), ("AX", ("A",), None),
    ("speed", POINTS, None), ("", POINTS, None), ("z_A", POINTS, None),
])  # fmt: skip
def test_a_heading_names_a_quantity(heading: str, points: tuple[str, ...], name: str | None) -> None:
    assert quantity_named(heading, list(quantities(points)), points) == name


def test_a_heading_names_only_what_is_asked_for() -> None:
    assert quantity_named("A.x", ["A.y"], POINTS) is None
    assert quantity_named("time", [], POINTS) is None


@pytest.mark.parametrize(("heading", "name", "unit"), [
    ("C.x [mm]", "C.x", "mm"), ("time (s)", "time", "s"), ("x", "x", ""), (" x ", "x", ""),
    ("C.x  [ m / s ]", "C.x", "m / s"), ("r_0[1]", "r_0[1]", ""), ("r_0[1] [mm]", "r_0[1]", "mm"), ("[mm]", "[mm]", ""),
    ("x[mm]", "x", "mm"), ("\u4f4d\u7f6e\uff08mm\uff09", "\u4f4d\u7f6e", "mm"), ("x\uff3bmm\uff3d", "x", "mm"),
    ("x [ ]", "x [ ]", ""),
])  # fmt: skip
def test_a_heading_is_split_into_name_and_unit(heading: str, name: str, unit: str) -> None:
    assert split_heading(heading) == (name, unit)


@pytest.mark.parametrize(("cell", "unit"), [
    ("mm", "mm"), ("[mm]", "mm"), (" ( mm ) ", "mm"), ("", ""), ("-", ""), ("1", ""), ("[-]", ""), ("parsec2", None),
    ("deg/s", "deg/s"), ("x", None),
])  # fmt: skip
def test_a_cell_of_a_row_of_units(cell: str, unit: str | None) -> None:
    assert bare_unit(cell) == unit


@pytest.mark.parametrize(("unit", "dimension", "factor"), [
    ("mm", "m", 1e-3), ("mm", "s", None), ("ms", "s", 1e-3), ("deg", "rad", math.pi / 180.0),
    ("°", "rad", math.pi / 180.0),
    ("°/s", "rad/s", math.pi / 180.0), ("rpm", "rad/s", math.pi / 30.0), ("", "m", None), (" ", "m", None),
    ("mm/s", "m/s", 1e-3), ("mm/s^2", "m/s^2", 1e-3), ("parsec2", "m", None),
])  # fmt: skip
def test_factors_to_si(unit: str, dimension: str, factor: float | None) -> None:
    assert factor_to_si(unit, dimension) == (None if factor is None else pytest.approx(factor))
    assert is_unit(unit) == any(factor_to_si(unit, one) is not None for one in quantities(("A",)).values())


@pytest.mark.parametrize(("dimension", "stated", "units", "expected"), [
    ("m", "mm", ("cm",), ("mm", 1e-3, "heading")),
    ("m", "", ("deg", "cm"), ("cm", 1e-2, "--unit")),
    ("m/s", "", ("cm",), ("cm/s", 1e-2, "--unit")),
    ("m/s^2", "", ("ms", "cm"), ("cm/s^2", 1e-2, "--unit")),
    ("rad/s", "", ("deg",), ("deg/s", math.pi / 180.0, "--unit")),
    ("s", "", ("cm",), ("s", 1.0, "assumed")),
    ("rad", "", (), ("rad", 1.0, "assumed")),
])  # fmt: skip
def test_a_unit_is_that_of_the_heading_then_of_the_user_then_si(
    dimension: str, stated: str, units: tuple[str, ...], expected: tuple[str, float, str]
) -> None:
    unit, factor, source = expected
    found = column_with_unit("A.x", dimension, 3, "px", stated, ColumnRequest({}, units))
    assert found == Column("A.x", 3, "px", unit, pytest.approx(factor), source)


@pytest.mark.parametrize(("dimension", "what"), [
    ("s", "time"), ("m", "length"), ("m/s", "velocity"), ("m/s^2", "acceleration"),
    ("rad", "angle"), ("rad/s", "angular speed"), ("rad/s^2", "angular acceleration"),
])  # fmt: skip
def test_a_unit_of_something_else_is_refused(dimension: str, what: str) -> None:
    with pytest.raises(InvalidInput) as refused:
        column_with_unit("A.x", dimension, 3, "px", "kg", NOTHING)
    assert str(refused.value) == f"column 'px': 'kg' is no unit of {what}"


def test_columns_are_chosen_by_name_in_the_order_of_quantities() -> None:
    assert chosen("who", "A.y [mm]", "Ax (mm)", "t") == {"time": 3, "A.x": 2, "A.y": 1}
    found = choose_columns(["t [ms]", "A.vy [mm/s]", "theta [deg]"], POINTS, NOTHING)
    assert found == [
        Column("time", 0, "t [ms]", "ms", 1e-3, "heading"),
        Column("crank_angle", 2, "theta [deg]", "deg", pytest.approx(math.pi / 180.0), "heading"),
        Column("A.vy", 1, "A.vy [mm/s]", "mm/s", 1e-3, "heading"),
    ]
    # The crank alone makes a table.
    assert chosen("t", "theta") == {"time": 0, "crank_angle": 1}


def test_words_of_other_alphabets_leave_the_time_alone() -> None:
    assert chosen("\u65f6\u95f4 t", "A.x") == {"time": 0, "A.x": 1}
    # The word may say that x is a velocity: it is no position then.
    assert chosen("t", "A.y", "\u901f\u5ea6 A.x") == {"time": 0, "A.y": 1}
    # Latin letters alone are read, and none left out of them.
    assert "no column for the time" in refusal("t me", "A.x")
    assert "no column for the time" in refusal("\u65f6\u95f4", "A.x")


def test_column_is_chosen_by_heading_name_or_number() -> None:
    headings = ("clock", "px [mm]", "2", "t")
    for wanted, place in (("px [mm]", 1), ("px", 1), ("2", 2), ("1", 0), ("4", 3), ("clock", 0)):
        assert chosen(*headings, columns={"A.x": wanted, "time": "t" if wanted != "4" else "clock"})["A.x"] == place
    # What a user names is not also something else.
    assert chosen("t", "A.x", columns={"A.y": "A.x"}) == {"time": 0, "A.y": 1}


@pytest.mark.parametrize(("headings", "columns", "message"), [
    (("tme", "", "A.x"), {}, "no column for the time among 'tme', 'A.x'; say which it is, by its name or its number "
     "from 1, with --column time=..."),
    (("t", "px"), {}, "no column for any of A, B_1 or the crank among 't', 'px'; say which it is, by its name or its "
     "number from 1, with --column A.x=..."),
    (("t", "A.x", "x_A"), {}, "columns 'A.x' and 'x_A' may both be A.x: say which with --column A.x=..."),
    (("t", "p", "p"), {"A.x": "p"}, "--column A.x=p: the table has 2 columns of that name"),
    (("t", "p [mm]", "p [cm]"), {"A.x": "p"}, "--column A.x=p: the table has 2 columns of that name"),
    (("t", "p"), {"A.x": "3"}, "unknown column in --column A.x= '3': choose from p, t"),
    (("t", "p"), {"A.x": "0"}, "unknown column in --column A.x= '0': choose from p, t"),
    (("t", "pxy", ""), {"A.x": "pxz"}, "unknown column in --column A.x= 'pxz': did you mean 'pxy'? choose from pxy, t"),
    (("t", "A.x [mm]", "A.y", "A.vx [m/s]"), {},
     "mixed units: A.y has no unit, A.x is in mm; say with --unit what it is in"),
    (("t", "A.x [mm]", "A.vy"), {}, "mixed units: A.vy has no unit, A.x is in mm; say with --unit what it is in"),
    (("t", "theta", "omega [rpm]"), {},
     "mixed units: crank_angle has no unit, crank_speed is in rpm; say with --unit what it is in"),
])  # fmt: skip
def test_columns_that_cannot_be_told_are_refused(
    headings: tuple[str, ...], columns: dict[str, str], message: str
) -> None:
    assert refusal(*headings, columns=columns) == message


def test_units_of_other_families_may_be_mixed() -> None:
    # Angles in degrees say nothing of lengths, nor does a time.
    assert chosen("t [ms]", "A.x", "theta [deg]") == {"time": 0, "A.x": 1, "crank_angle": 2}
    assert chosen("t", "A.x [mm]", "A.y", units=("cm",)) == {"time": 0, "A.x": 1, "A.y": 2}


def test_an_error_names_twenty_headings_at_most() -> None:
    headings = [f"column {k}" for k in range(1, 25)]
    assert "'column 20'; say" in refusal(*headings)
    assert "column 21" not in refusal(*headings)
    named = refusal("t", *headings, columns={"A.x": "nothing like it"})
    assert "column 19" in named
    assert "column 20" not in named


@pytest.mark.parametrize(("columns", "units", "message"), [
    ({"A.z": "p"}, (), "unknown quantity 'A.z': did you mean "),
    ({}, ("mm", "kg"), "--unit kg: it is no unit of time, length, velocity, acceleration, angle, angular speed, "
     "angular acceleration, torque; give e.g. mm or deg"),
])  # fmt: skip
def test_a_request_for_what_is_not_there_is_refused(
    columns: dict[str, str], units: tuple[str, ...], message: str
) -> None:
    with pytest.raises(InvalidInput) as refused:
        column_request(columns, units, POINTS)
    assert str(refused.value).startswith(message)
    assert column_request({"A.x": "p"}, ["mm", "deg"], POINTS) == ColumnRequest({"A.x": "p"}, ("mm", "deg"))
