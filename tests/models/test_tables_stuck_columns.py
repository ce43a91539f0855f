"""Columns that stand still, word by word: which, where, at what value; and limits of what counts as standing still."""

from __future__ import annotations

import numpy as np
import pytest
from circling_points import CirclingPoints

from conrod.exact.motion import Array
from conrod.models.tables.errors import TableComparison
from conrod.models.tables.stuck import _stuck_mask, drop_stuck, replace_stuck, stuck_rows, stuck_words

SCENE = CirclingPoints(speed=2.0)  # radii of 0.5 m and 2 m
TIMES = np.arange(100) * 0.05  # 1.6 revolutions
EXACT = SCENE.table(TIMES, "position", "velocity")


def compared(**columns: Array) -> TableComparison:
    named = {name.replace("_", ".") if name[0] in "PQ" else name: own for name, own in columns.items()}
    return TableComparison({**EXACT, **named}, SCENE)  # type: ignore[arg-type]


def with_value(column: str, rows: slice, value: float) -> Array:
    changed = EXACT[column].copy()
    changed[rows] = value
    return changed


def said(table: TableComparison) -> str:
    return stuck_words(table, stuck_rows(table))


LOW, HIGH = np.count_nonzero(EXACT["P.x"] <= -0.3), np.count_nonzero(EXACT["P.x"] >= 0.2)
NOISE = 1e-3 * (-1.0) ** np.arange(100)


@pytest.mark.parametrize(("columns", "words"), [
    ({}, ""),
    ({"P_x": np.full(100, 0.25)}, "P.x does not change: it is 0.25 m in all 100 rows"),
    ({"P_vy": np.full(100, -1.5)}, "P.vy does not change: it is -1.5 m/s in all 100 rows"),
    ({"P_x": 0.25 + NOISE}, "P.x does not change: it is 0.25 m but for 0.002 m in all 100 rows"),
    ({"P_x": with_value("P.x", slice(40, None), 0.1)}, "P.x is frozen at 0.1 m from 2 s on"),
    ({"Q_y": with_value("Q.y", slice(10, 30), 0.1)}, "Q.y stands still at 0.1 m from 0.5 to 1.45 s"),
    ({"P_x": with_value("P.x", slice(10, 30), 0.1) * 1.0 + 0.0, "Q_y": with_value("Q.y", slice(80, None), -1.0)},
     "P.x stands still at 0.1 m from 0.5 to 1.45 s; Q.y is frozen at -1 m from 4 s on"),
    ({"P_x": np.clip(EXACT["P.x"], -0.3, 1.0)}, f"P.x is cut off at -0.3 m, in {LOW} of 100 rows"),
    ({"P_x": np.clip(EXACT["P.x"], -0.3, 0.2)}, f"P.x is cut off at -0.3 m and 0.2 m, in {LOW + HIGH} of 100 rows"),
    ({"Q_x": np.where(TIMES < 1.5, with_value("Q.x", slice(5, 15), 0.1), with_value("Q.x", slice(45, 57), 0.5))},
     "Q.x stands still in 2 stretches, 22 of 100 rows"),
    ({"P_x": EXACT["P.x"][np.arange(100) // 25 * 25]},
     "P.x is held at one value for rows on end, in 100 of 100 rows"),
    ({"P_x": np.where(TIMES < 1.5, with_value("P.x", slice(20, 30), 0.1), with_value("P.x", slice(30, 40), 0.1001))},
     "P.x is held at one value for rows on end, in 20 of 100 rows"),
    # Noise from half of the rows on.
    ({"P_y": np.where(np.arange(100) < 50, EXACT["P.y"], 0.25 + NOISE)},
     "P.y is frozen at 0.25 m but for 0.002 m from 2.5 s on"),
    ({"crank_speed": np.zeros(100)}, "crank_speed does not change: it is 0 rad/s in all 100 rows"),
    ({"crank_angle": np.zeros(100)}, "crank_angle does not change: it is 0 rad in all 100 rows"),
])  # fmt: skip
def test_what_stands_still_is_said_with_its_value_and_place(columns: dict[str, Array], words: str) -> None:
    assert said(compared(**columns)) == words


def stuck_in(column: str, values: Array) -> list[int]:
    """Rows in which a column is stuck."""
    name = column.replace(".", "_") if column[0] in "PQ" else column
    return np.flatnonzero(stuck_rows(compared(**{name: values})).get(column, np.zeros(100))).tolist()


@pytest.mark.parametrize(("rows", "stuck"), [
    (slice(12, 16), False), (slice(12, 17), True),  # five rows of one value
    # About the dead centre at row 31.4 five rows move by 1.4 % of the travel, eight by 3.2 %.
    (slice(29, 34), False), (slice(28, 36), True),
])  # fmt: skip
def test_stretch_is_stuck_from_five_rows_and_two_per_cent_travel(rows: slice, stuck: bool) -> None:
    assert stuck_in("P.x", with_value("P.x", rows, 0.1)) == (list(range(100))[rows] if stuck else [])


def test_stretch_of_coarse_column_is_stuck_from_three_digits() -> None:
    coarse = np.round(EXACT["P.x"], 1)
    assert stuck_in("P.x", coarse) == []
    for last, stuck in ((19, False), (20, True)):
        changed = coarse.copy()
        changed[12:last] = 0.3
        # The exact values are 0.181 in row 12, -0.114 in row 18 and -0.162 in row 19.
        assert stuck_in("P.x", changed) == (list(range(12, last)) if stuck else [])


@pytest.mark.parametrize(("travel", "stuck"), [(0.75, False), (0.76, True)])
def test_stretch_is_stuck_beyond_three_digits_and_not_at_them(travel: float, stuck: bool) -> None:
    # A column in quarters that stands still in five rows, while the exact value travels by three quarters or more.
    exact = np.concatenate([np.arange(0.0, 8.0, 0.25), 8.0 + travel * np.linspace(0.0, 1.0, 5), np.arange(9.0, 16.0)])
    values = np.round(4.0 * exact) / 4.0
    values[32:37] = 8.0
    assert _stuck_mask(values, exact)[32:37].tolist() == [stuck] * 5


def test_what_stands_still_in_the_exact_motion_is_not_stuck() -> None:
    scene = CirclingPoints(radii={"P": 0.0, "Q": 2.0})
    table = scene.table(TIMES) | {"P.x": np.full(100, 0.25)}
    assert stuck_rows(TableComparison(table, scene)) == {}  # type: ignore[arg-type]


def test_noise_about_a_constant_is_small_and_has_no_memory() -> None:
    sign = (-1.0) ** np.arange(100)
    scatter = float(np.std(EXACT["P.x"]))
    assert stuck_in("P.x", 0.25 + 0.09 * scatter * sign) == list(range(100))
    # From the last rows on the exact values scatter less, and less noise is allowed.
    assert stuck_in("P.x", 0.25 + 0.15 * scatter * sign) == []
    assert stuck_in("P.x", 0.25 + 0.05 * scatter * np.sin(np.arange(100) / 3.0)) == []


def test_a_crank_that_stops_for_a_while_is_stuck_there() -> None:
    speed = np.full(100, 2.0)
    assert stuck_in("crank_speed", speed) == []
    speed[40:42] = 0.0
    assert stuck_in("crank_speed", speed) == [40, 41]


def test_stuck_values_are_replaced_by_exact_ones_alone() -> None:
    speed = np.full(100, 1.9)
    speed[40:42] = 0.0
    values = with_value("P.x", slice(12, 20), 0.1) + 1e-9 * np.arange(100)
    table = compared(P_x=values, crank_speed=speed)
    stuck = {"P.x": np.isin(np.arange(100), range(12, 20)), "crank_speed": speed == 0.0}
    found = replace_stuck(table, stuck).values
    assert found["P.x"][12:20] == pytest.approx(EXACT["P.x"][12:20], abs=1e-15)
    assert np.array_equal(np.delete(found["P.x"], range(12, 20)), np.delete(values, range(12, 20)))
    assert found["crank_speed"].tolist() == [1.9] * 40 + [2.0] * 2 + [1.9] * 58
    assert np.array_equal(found["Q.y"], EXACT["Q.y"])


def test_column_is_dropped_when_most_rows_are_stuck_else_rows() -> None:
    rows = np.arange(100)
    table = compared(crank_angle=2.0 * TIMES)
    found = drop_stuck(table, {"P.x": rows < 51, "P.y": rows < 50, "Q.x": (rows > 89) & (rows < 95)}).values
    assert set(table.values) - set(found) == {"P.x"}
    kept = np.array([*range(50, 90), *range(95, 100)])
    for name, values in found.items():
        assert np.array_equal(values, table.values[name][kept]), name
    # Where all stuck columns are dropped no row is.
    assert len(drop_stuck(table, {"P.x": rows < 51}).times) == 100
