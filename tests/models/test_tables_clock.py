"""A wrong clock of a table is out of tolerance, whichever rows are missing or repeated."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from table_files import Columns, exact_table, judge_columns

from conrod.exact.motion import Array
from conrod.models.tables.study import TableStudy
from conrod.scenes import Saw

STEP, ROWS = 0.002, 301  # [s], so that times are whole milliseconds
SAW = Saw(speed=2.0 * math.pi / (100.0 * STEP))
TIMES = np.arange(ROWS) * STEP
RANDOM = np.random.default_rng(7)

# How late [s] the clock is at each row.
CLOCKS: dict[str, Array] = {
    "offset": np.full(ROWS, 0.25 * STEP),
    "drift": np.asarray(1e-3 * TIMES),
    "jitter": 0.1 * STEP * RANDOM.uniform(-1.0, 1.0, ROWS),
    "one late row": 0.2 * STEP * (np.arange(ROWS) == 200),
}
# Rows that are left of the table; a row that stands there twice is repeated.
KEPT = {
    "whole": np.arange(ROWS),
    "one row missing": np.delete(np.arange(ROWS), 150),
    "50 rows missing": np.delete(np.arange(ROWS), slice(80, 130)),
    "most of a turn missing": np.delete(np.arange(ROWS), slice(60, 150)),
    "50 single rows missing": np.delete(np.arange(ROWS), RANDOM.choice(np.arange(10, 199), 50, replace=False)),
    "begin missing": np.arange(40, ROWS),
    "end missing": np.arange(ROWS - 40),
    "rows repeated": np.sort(np.append(np.arange(ROWS), [3, 77, 150])),
}


def study_of(late: Array, kept: Array, folder: Path, angles: str = "continuous") -> TableStudy:
    """A saw's table whose times say whole milliseconds, and whose motion belongs so much later."""
    table: Columns = exact_table(SAW, times=TIMES + late, crank=True)
    if angles == "0 to 360 deg":
        table["crank_angle"] = np.mod(table["crank_angle"], 2.0 * np.pi)
    table["time"] = np.round(TIMES, 3)
    table = {name: column[kept.astype(int)] for name, column in table.items()}
    return judge_columns(table, SAW, folder, tolerance={"position": 1e-6})


@pytest.mark.parametrize("angles", ["continuous", "0 to 360 deg"])
@pytest.mark.parametrize("missing", KEPT)
def test_wrong_clock_is_out_of_tolerance_for_any_missing_rows(missing: str, angles: str, tmp_path: Path) -> None:
    right = study_of(np.zeros(ROWS), KEPT[missing], tmp_path, angles)
    assert right.passed is True
    assert right.tolerance["phase"] < 1e-10
    for clock, late in CLOCKS.items():
        found = study_of(late, KEPT[missing], tmp_path, angles)
        assert set(found.exceeded) == {"phase", "total"}, clock
        kept = KEPT[missing].astype(int)
        assert found.largest("phase") == pytest.approx(SAW.speed * np.abs(late[kept]).max(), rel=1e-6), clock


def test_unequal_times_are_allowed_half_their_last_digit(tmp_path: Path) -> None:
    # Instants of a solver that chooses its steps, written to a millisecond: nothing finer can be known of them.
    at = np.cumsum(RANDOM.uniform(2e-3, 9e-3, 200))
    table = exact_table(SAW, times=at, crank=True)
    rounded = table | {"time": np.round(at, 3)}
    found = judge_columns(rounded, SAW, tmp_path, tolerance={"position": 1e-6})
    assert found.passed is True
    assert found.tolerance["phase"] == pytest.approx(SAW.speed * 0.5e-3, rel=1e-6)
    late = table | {"time": np.round(at, 3) + 1e-3}
    assert judge_columns(late, SAW, tmp_path, tolerance={"position": 1e-6}).passed is False


def test_half_of_rows_are_exact_when_far_coarser_than_digits(tmp_path: Path) -> None:
    # Written to 10 ms, all distances are multiples of 20 ms: that is no chance.
    kept = np.sort(RANDOM.choice(np.arange(0, ROWS, 10), 18, replace=False)).astype(float)
    assert study_of(np.zeros(ROWS), kept, tmp_path).passed is True
    assert set(study_of(CLOCKS["offset"], kept, tmp_path).exceeded) == {"phase", "total"}


def test_rows_one_digit_apart_are_exact_when_few_are_missing(tmp_path: Path) -> None:
    times = np.arange(ROWS) * 1e-3
    table = exact_table(SAW, times=times + 0.4e-3, crank=True) | {"time": np.round(times, 3)}
    for missing in ([150], list(range(40, 90)), [20, 90, 200, 201]):
        few = {name: np.delete(column, missing) for name, column in table.items()}
        assert set(judge_columns(few, SAW, tmp_path, tolerance={"position": 1e-6}).exceeded) == {"phase", "total"}


def test_few_digits_make_any_times_multiples_of_the_last_one(tmp_path: Path) -> None:
    random = np.random.default_rng(8)
    written = np.cumsum(random.integers(1, 4, ROWS)) * 1e-3
    at = written + random.uniform(-0.45e-3, 0.45e-3, ROWS)
    table = exact_table(SAW, times=at, crank=True) | {"time": np.round(written, 3)}
    study = judge_columns(table, SAW, tmp_path, tolerance={"position": 1e-6})
    assert (study.passed, study.tolerance["phase"]) == (True, pytest.approx(SAW.speed * 0.5e-3, rel=1e-6))
