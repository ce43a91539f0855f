"""Faults of sensors are named with their size where undoing them leaves an error within tolerance, and only there."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from synthetic import longer_rod, synthetic_trajectory
from table_files import ROWS, Columns, exact_table, judge_columns

from conrod.exact.motion import Array
from conrod.models.tables.errors import TableComparison
from conrod.models.tables.sensors import _crank_speed, _offset, _speed_error
from conrod.models.tables.study import TableStudy
from conrod.scenes import Saw, scene_named

SAW = Saw(speed=4.0 * math.pi / 3.0)
ALL = ("position", "velocity", "acceleration")
COUNT = 2 * ROWS + 1
TOLERANCE = {"position": 1e-4, "velocity": 1e-4, "acceleration": 1e-4}


def changed(*parts: str, by: float | Array = 0.0, gain: float = 1.0, crank: bool = False) -> Columns:
    """The saw's exact table, columns whose name ends so times a gain and with something added."""
    table = exact_table(SAW, ALL, crank=crank)
    return {n: v * gain + by if n.endswith(parts) and n != "time" else v for n, v in table.items()}


def study_of(table: Columns, folder: Path, **tolerance: float) -> TableStudy:
    return judge_columns(table, SAW, folder, tolerance=tolerance or TOLERANCE)


TIMES = exact_table(SAW)["time"]
ROW = np.eye(1, COUNT, 77)[0]
NOISE = np.random.default_rng(5).normal(0.0, 1e-7, COUNT)
FAULTS: dict[str, tuple[Columns, str, str]] = {
    "one row": (changed("M.y", by=0.05 * ROW), "outlier",
                f"1 of {COUNT} rows (at {TIMES[77]:.6g} s) is off: M.y by 50 mm"),
    "one row, noise in all": (changed("M.y", by=0.05 * ROW + NOISE), "outlier", "is off: M.y by 50 mm"),
    "three rows": (changed("C.x", by=0.01 * (ROW + np.roll(ROW, 9) - np.roll(ROW, 40))), "outlier",
                   f"3 of {COUNT} rows (the first at {TIMES[77]:.6g} s) are off: C.x by 10 mm"),
    "one row of a velocity": (changed("C.vx", by=0.3 * ROW), "outlier", "is off: C.vx by 0.3 m/s"),
    "one row of the encoder": (changed("crank_angle", by=0.1 * ROW, crank=True), "outlier", "crank_angle by 0.1 rad"),
    "a gain": (changed(".x", ".y", gain=1.01), "gain",
               "C.x, M.x, M.y are each 1.01 times what it should be (a gain, or a machine of another size)"),
    "a gain of one sensor": (changed("M.y", gain=0.97), "gain", "M.y is 0.97 times what it should be (a gain)"),
    "a gain of one sensor, noise": (changed("M.y", gain=0.97, by=NOISE), "gain", "M.y is 0.97 times"),
    "a gain of velocities": (changed("vx", "vy", gain=1.02), "gain", "are each 1.02 times what it should be (a gain)"),
    "a drift": (changed(".x", by=1e-3 * TIMES), "drift", "C.x by 1 mm a second, M.x by 1 mm a second"),
    "a drift of one sensor": (changed("C.x", by=-2e-3 * TIMES), "drift", "columns drift: C.x by -2 mm a second"),
    "an offset of one sensor": (changed("C.x", by=0.01), "offset", "columns are offset: C.x by 10 mm"),
    "an offset of a velocity": (changed("M.vy", by=0.02), "offset", "columns are offset: M.vy by 0.02 m/s"),
    "gravity": (changed(".ay", by=9.81), "gravity", "gravity is left in the accelerations"),
    "gravity along x": (changed(".ax", by=-9.81), "gravity", "as an accelerometer has it: C.ax by -9.81 m/s^2"),
    "an offset of accelerations that is no gravity": (changed(".ay", by=5.0), "offset", "C.ay by 5 m/s^2"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_sensor_fault_is_the_only_cause_and_has_its_size(name: str, tmp_path: Path) -> None:
    table, kind, words = FAULTS[name]
    study = study_of(table, tmp_path)
    assert study.passed is False
    assert [cause.kind for cause in study.causes] == [kind], [cause.text for cause in study.causes]
    assert words in study.causes[0].text
    explained = study.causes[0].explains
    # "total" of a crank that says its own angle is another's; all that is out of tolerance is explained.
    assert set(study.exceeded) - {"phase"} <= set(explained)
    assert all(after <= 1e-4 for _, after in explained.values())


def test_positions_off_by_another_origin_are_no_sensors_fault() -> None:
    apart = TableComparison(changed("C.x", by=0.01), SAW)
    assert [kind for kind, *_ in _offset(apart, "position")] == ["offset"]
    together = TableComparison(changed(".x", by=0.01), SAW)
    assert list(_offset(together, "position")) == []
    # Of velocities no origin is known.
    assert [kind for kind, *_ in _offset(TableComparison(changed("vx", by=0.01), SAW), "velocity")] == ["offset"]


def other_speed() -> Columns:
    return exact_table(Saw(speed=1.025 * SAW.speed), ("position",), crank=True)


@pytest.mark.parametrize(("factor", "quantity", "crank", "share"), [
    (1.025, "position", True, 0.025), (1.025, "position", False, 0.025),
    (1.3, "position", True, 0.3),  # beyond a fifth it is another unit
    (3.0, "position", False, 0.0),  # too far for positions
    (1.025, "velocity", False, 0.0),  # neither angle nor positions
])  # fmt: skip
def test_speed_of_the_crank_is_that_of_its_angle_or_positions(
    factor: float, quantity: str, crank: bool, share: float
) -> None:
    table = TableComparison(exact_table(Saw(speed=factor * SAW.speed), (quantity,), crank=crank), SAW)
    assert _speed_error(table) == pytest.approx(share * SAW.speed, rel=1e-6, abs=0.0)
    assert len(list(_crank_speed(table))) == (0.0 < share < 0.2)


def test_no_speed_is_fitted_where_the_linkage_does_not_go() -> None:
    scene, times = scene_named("swinging-four-bar"), np.linspace(0.0, 1.0, 50)
    begin, end = scene.kinematics.mechanism.driver.span or (0.0, 0.0)
    table = exact_table(scene, times=(begin + (end - begin) * times) / scene.speed)
    assert _speed_error(TableComparison(table, scene)) == pytest.approx(0.0, abs=1e-9)
    # Later than the pass ends by half a turn.
    late = table | {"time": table["time"] + 0.5 * scene.period}
    assert _speed_error(TableComparison(late, scene)) == 0.0


def test_a_crank_at_another_speed_is_named_with_both(tmp_path: Path) -> None:
    study = judge_columns(other_speed(), SAW, tmp_path, tolerance={"position": 1e-4})
    assert [cause.kind for cause in study.causes] == ["crank speed"]
    assert "the crank turns at 41 rpm, not at 40 rpm" in study.causes[0].text
    # As fast as it should be, and late: no other speed.
    late = exact_table(SAW, crank=True)
    late |= {"time": late["time"] + 0.005}
    assert "crank speed" not in [
        cause.kind for cause in judge_columns(late, SAW, tmp_path, tolerance={"position": 1e-4}).causes
    ]


# -- negative controls -------------------------------------------------------------------------------------------------


def rod() -> Columns:
    """A machine with a longer rod, seen by sensors without a fault."""
    tracks = {p: own.position for p, own in synthetic_trajectory(SAW, longer_rod(SAW)).points.items()}
    table = {"time": next(iter(tracks.values())).instants.times}
    return table | {f"{p}.{a}": t.values[:, k] for p, t in tracks.items() for k, a in enumerate("xy")}


UNKNOWN = {
    "white noise": changed("C.x", "M.x", by=1e-3 * np.random.default_rng(6).normal(size=COUNT)),
    "a random walk": changed("C.x", by=1e-4 * np.random.default_rng(7).normal(size=COUNT).cumsum()),
    "a bent drift": changed("C.x", by=1e-3 * TIMES**2),
    "a jump half way": changed("C.x", by=np.where(np.arange(COUNT) > COUNT // 2, 0.01, 0.0)),
    "a dozen rows in a hundred": changed("C.x", by=0.01 * (np.arange(COUNT) % 9 == 0)),
    "a gain that grows": changed("M.y", gain=1.0) | {"M.y": changed("M.y")["M.y"] * (1.0 + 0.01 * TIMES)},
    "an outlier and a gain": changed("M.y", gain=1.01, by=0.002 * ROW),
    "a longer rod": rod(),
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_cause_is_unknown_when_no_sensor_fault_explains_it(name: str, tmp_path: Path) -> None:
    study = study_of(UNKNOWN[name], tmp_path, position=1e-5)
    assert study.passed is False
    assert study.causes == ()


def test_sensor_fault_is_not_claimed_when_error_remains(tmp_path: Path) -> None:
    noisy = changed("M.y", gain=0.97, by=300.0 * NOISE)  # 0.03 mm of noise beside 2.7 mm
    assert [cause.kind for cause in study_of(noisy, tmp_path, position=1e-2).causes] == ["gain"]
    assert study_of(noisy, tmp_path, position=1e-4).causes == ()


def test_a_part_of_a_turn_tells_no_drift_from_a_wrong_machine(tmp_path: Path) -> None:
    table = {name: values[:45] for name, values in rod().items()}
    assert judge_columns(table, SAW, tmp_path, tolerance={"position": 1e-5}).causes == ()


def test_few_rows_have_no_outlier(tmp_path: Path) -> None:
    few = {name: values[::30] for name, values in changed("M.y").items()}
    few["M.y"] = few["M.y"] + 0.05 * np.eye(1, len(few["time"]), 3)[0]
    assert study_of(few, tmp_path, position=1e-4).causes == ()


def test_outlier_is_found_in_more_rows_than_the_search_uses(tmp_path: Path) -> None:
    table = exact_table(SAW, rows=6000)
    table["C.x"] = table["C.x"] + 0.02 * np.eye(1, len(table["time"]), 3001)[0]
    study = study_of(table, tmp_path, position=1e-4)
    assert [cause.kind for cause in study.causes] == ["outlier"]
    assert "C.x by 20 mm" in study.causes[0].text
