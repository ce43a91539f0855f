"""A sensor that stands still is named as such, and nothing else is that stands still with it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from table_files import ROWS, Columns, exact_table, judge_columns

from conrod.exact.motion import Array
from conrod.models.tables.causes import likely_causes
from conrod.models.tables.errors import TableComparison
from conrod.models.tables.study import TableStudy
from conrod.scenes import Saw, Scene, scene_named

SAW = Saw(speed=20.0)
EXACT = exact_table(SAW, ("position", "velocity", "acceleration"), crank=True)
EXACT["crank_speed"] = np.full(2 * ROWS + 1, SAW.speed)
POSITION, VELOCITY = {"position": 1e-4}, {"velocity": 1e-4}
ALL = ("C.x", "C.y", "M.x", "M.y")
NOISE = np.random.default_rng(5).normal(size=2 * ROWS + 1)


def frozen(column: Array, row: int = 100) -> Array:
    return np.where(np.arange(len(column)) >= row, column[row], column)


def dropped(column: Array) -> Array:
    return np.where((np.arange(len(column)) // 10) == 5, 0.0, column)


def held(column: Array) -> Array:
    return column[np.arange(len(column)) // 12 * 12]


# What becomes of a column, of which columns beside which others, and what is said of it.
DEAD: dict[str, tuple[Callable[[Array], Array], tuple[str, ...], tuple[str, ...], str]] = {
    "zeros, alone": (np.zeros_like, ("C.x",), (), "C.x does not change: it is 0 m in all 241 rows"),
    "zeros of a point": (np.zeros_like, ("C.x",), ("C.y",), "C.x does not change: it is 0 m"),
    "zeros beside others": (np.zeros_like, ("C.x",), ("C.y", "M.x", "M.y"), "C.x does not change"),
    "zeros with a crank angle": (np.zeros_like, ("C.x",), ("C.y", "crank_angle"), "C.x does not change"),
    "a constant": (lambda c: 0.0 * c + 0.1, ("C.x",), (), "C.x does not change: it is 0.1 m in all 241 rows"),
    "a constant with noise": (
        lambda c: 0.1 + 1e-4 * NOISE,
        ("C.x",),
        (),
        "C.x does not change: it is 0.09999 m but for 0.00052 m in",
    ),
    "frozen": (frozen, ("M.y",), ("M.x",), "M.y is frozen at -0.0883 m from 0.261799 s on"),
    "frozen with noise": (lambda c: frozen(c) + 1e-4 * NOISE, ("M.y",), ("M.x",), "M.y is frozen at"),
    "all frozen": (frozen, ("C.x", "M.x", "M.y"), ("C.y",), "M.x is frozen at 0.1149 m from 0.261799 s on; M.y is"),
    "saturated": (lambda c: np.clip(c, -0.03, 0.0), ("C.x",), ("M.x",), "C.x is cut off at -0.03 m"),
    "dropped out": (dropped, ("M.x",), ("M.y",), "M.x stands still at 0 m from"),
    "held": (held, ("C.x",), ("M.x", "M.y"), "C.x is held at one value for rows on end"),
    "crank angle": (np.zeros_like, ("crank_angle",), ALL, "crank_angle does not change: it is 0 rad"),
    "crank angle frozen": (frozen, ("crank_angle",), ALL, "crank_angle is frozen at 5.236 rad"),
    "velocity": (np.zeros_like, ("C.vx",), ("C.x",), "C.vx does not change: it is 0 m/s"),
    "velocity frozen": (lambda c: frozen(c, 80), ("C.vx",), ("C.x",), "C.vx is frozen at 2.46 m/s"),
    "crank speed": (np.zeros_like, ("crank_speed",), ("C.vx", "crank_angle"), "crank_speed does not change: it is 0"),
}


@pytest.mark.parametrize("case", DEAD)
def test_a_sensor_that_stands_still_is_named_and_nothing_else(case: str, tmp_path: Path) -> None:
    change, columns, others, said = DEAD[case]
    table: Columns = {name: EXACT[name] for name in ("time", *columns, *others)}
    table |= {name: change(EXACT[name]) for name in columns}
    of_velocity = any(name.endswith(".vx") for name in table) and "C.x" not in columns
    study = judge_columns(table, SAW, tmp_path, tolerance=VELOCITY if of_velocity else POSITION)
    assert [cause.kind for cause in study.causes] == ["dead sensor"]
    assert said in study.causes[0].text
    for before, after in study.causes[0].explains.values():
        assert after <= 0.05 * before


def test_what_else_is_wrong_is_named_beside_a_dead_sensor(tmp_path: Path) -> None:
    table = {name: EXACT[name] for name in ("time", *ALL)}
    table |= {"C.x": np.zeros_like(EXACT["C.x"]), "time": table["time"] + 0.3 * SAW.period / ROWS}
    study = judge_columns(table, SAW, tmp_path, tolerance=POSITION)
    assert [cause.kind for cause in study.causes] == ["dead sensor", "time offset"]
    assert "(0.3 of a step) earlier" in study.causes[1].text


def test_sensors_that_leave_no_row_are_all_of_the_error() -> None:
    table, row = exact_table(SAW, rows=9), np.arange(19)
    for name, begin, end in (("M.x", 0, 8), ("M.y", 6, 13), ("C.x", 11, 19)):
        table[name] = np.where((begin <= row) & (row < end), 0.0123, table[name])
    (cause,) = likely_causes(TableComparison(table, SAW), ["position"])
    assert cause.kind == "dead sensor"
    assert [left for _, left in cause.explains.values()] == [0.0]


@pytest.mark.parametrize(("share", "named"), [(0.4, True), (0.6, False)])
def test_a_dead_sensor_beside_an_unknown_cause_halves_the_error(share: float, named: bool) -> None:
    frozen_column, size = frozen(EXACT["C.x"], 230), SAW.lengths["M"] / SAW.lengths["C"]
    largest = float(np.abs(frozen_column - EXACT["C.x"]).max())
    strange = share * size * largest * np.sin(37.0 * np.arange(2 * ROWS + 1) ** 2)
    table = {name: EXACT[name] for name in ("time", *ALL)} | {"C.x": frozen_column, "M.y": EXACT["M.y"] + strange}
    comparison = TableComparison(table, SAW)
    kinds = [cause.kind for cause in likely_causes(comparison, ["position"])]
    assert kinds == (["dead sensor"] if named else [])


def kinds(study: TableStudy) -> list[str]:
    return [cause.kind for cause in study.causes]


@pytest.mark.parametrize(("share", "named"), [(0.3, ["dead sensor"]), (0.7, [])])
def test_dead_sensor_is_named_when_it_explains_half_of_an_error(share: float, named: list[str], tmp_path: Path) -> None:
    """Beside noise, in another column, of a share of what the dead sensor is off by."""
    table = {name: EXACT[name][::4] for name in ("time", "C.x", "M.y")}
    dead = table["C.x"].copy()
    dead[25:32] = dead[25]
    noise = np.random.default_rng(3).uniform(-1.0, 1.0, len(dead)) * np.abs(dead - table["C.x"]).max()
    table |= {"C.x": dead, "M.y": table["M.y"] + share * noise}
    assert kinds(judge_columns(table, SAW, tmp_path, tolerance=POSITION)) == named


@pytest.mark.parametrize(
    "name",
    [
        "cam-follower",  # at rest for a third of its turn, as the other cam
        "saw-40rpm",
        "shear-press",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("cam-3-4-5", "whitworth")),
    ],
)
def test_dwell_or_few_digits_are_no_dead_sensor(name: str, tmp_path: Path) -> None:
    scene: Scene = scene_named(name)
    table = exact_table(scene, rows=360)
    # Late, so that the dwell lies elsewhere; in mm; and in three digits.
    late = table | {"time": table["time"] + 0.01 * scene.period}
    assert kinds(judge_columns(late, scene, tmp_path, tolerance=POSITION)) == ["time offset"]
    large = {column: 1e3 * values if "." in column else values for column, values in table.items()}
    assert kinds(judge_columns(large, scene, tmp_path, tolerance=POSITION)) == ["length unit"]
    coarse = {column: np.round(values, 3) if "." in column else values for column, values in table.items()}
    assert "dead sensor" not in kinds(judge_columns(coarse, scene, tmp_path, tolerance={"position": 1e-6}))
    noisy = {column: values + 1e-3 * np.random.default_rng(2).normal(size=len(values)) if "." in column else values
             for column, values in table.items()}  # fmt: skip
    assert "dead sensor" not in kinds(judge_columns(noisy, scene, tmp_path, tolerance={"position": 1e-6}))


def test_the_dwell_of_one_pass_is_no_dead_sensor(tmp_path: Path) -> None:
    scene = scene_named("geneva")
    first, last = (angle / scene.speed for angle in scene.mechanism().driver.span or ())
    table = exact_table(scene, times=np.linspace(0.95 * first, 0.9 * last, 300))
    late = table | {"time": table["time"] + 0.01 * (last - first)}
    assert kinds(judge_columns(late, scene, tmp_path, tolerance=POSITION)) == []
    assert judge_columns(table, scene, tmp_path, tolerance=POSITION).passed is True


def test_too_few_rows_of_zeros_show_no_slip(tmp_path: Path) -> None:
    # Swapped, zeros would be the y of a slider along x: that stands still whatever it is.
    table = {"time": EXACT["time"][:4], "C.x": np.zeros(4)}
    assert kinds(judge_columns(table, SAW, tmp_path, tolerance=POSITION)) == []
