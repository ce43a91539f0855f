"""Errors of tables on points that circle: each is what a hand computes, at the angle and with the rates it is of."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from circling_points import CirclingPoints

from conrod.errors import InvalidInput
from conrod.models.tables.errors import MAX_CURVE_SPANS, TableComparison
from conrod.models.tables.estimation import Estimate, align_clock, best_crank_shift, check_estimated, estimate

SCENE = CirclingPoints()  # at 2 rad/s; L of P is 1 m, of Q 4 m
TIMES = np.linspace(0.0, 3.0, 31)
ALL = ("position", "velocity", "acceleration")


def compared(scene: CirclingPoints = SCENE, turn: Any = 0.0, **columns: Any) -> TableComparison:
    """A table of columns, as P_x for P.x."""
    named = {name if name.startswith("crank") else name.replace("_", "."): own for name, own in columns.items()}
    return TableComparison({"time": TIMES, **named}, scene, turn)  # type: ignore[arg-type]


# -- columns and rows ------------------------------------------------------------------------------------------------


def test_named_columns_alone_are_changed() -> None:
    table = compared(P_x=np.ones(31), P_y=np.full(31, 2.0))
    assert table.scale_columns(3.0, "P.x", "Q.x").values["P.x"].tolist() == [3.0] * 31
    assert table.scale_columns(3.0, "P.x").values["P.y"].tolist() == [2.0] * 31
    assert table.change_columns(lambda column: column - 5.0, "P.y").values["P.y"].tolist() == [-3.0] * 31


@pytest.mark.parametrize(("most", "rows"), [
    (31, list(range(31))), (32, list(range(31))), (4, [0, 10, 20, 30]), (2, [0, 30]),
])  # fmt: skip
def test_rows_are_thinned_evenly_from_the_first_to_the_last(most: int, rows: list[int]) -> None:
    found = compared(P_x=np.arange(31.0)).thin_rows(most).values
    assert found["P.x"].tolist() == rows
    assert found["time"].tolist() == TIMES[rows].tolist()


def test_a_time_shift_takes_the_crank_along() -> None:
    shifted = compared(crank_angle=2.0 * TIMES).shift_time(0.5)
    assert shifted.times == pytest.approx(TIMES + 0.5)
    assert compared().shift_time(0.5).values.keys() == {"time"}
    table = TableComparison({"time": TIMES, "crank_angle": 2.0 * TIMES}, SCENE)
    assert table.shift_time(0.5).values["crank_angle"] == pytest.approx(2.0 * TIMES + 1.0)
    # A crank that has another speed turns by another angle.
    table = TableComparison({**table.values, "crank_speed": np.full(31, 3.0)}, SCENE)
    assert table.shift_time(0.5).values["crank_angle"] == pytest.approx(2.0 * TIMES + 1.5)
    assert table.shift_time(TIMES).values["crank_angle"] == pytest.approx(5.0 * TIMES)


# -- the crank -------------------------------------------------------------------------------------------------------


def test_angles_are_nominal_when_crank_angle_is_missing() -> None:
    table = compared(turn=0.25)
    assert table.nominal_angle == pytest.approx(2.0 * TIMES + 0.25)
    assert table.angle == pytest.approx(2.0 * TIMES + 0.25)
    assert table.phase is None
    own = TableComparison({"time": TIMES, "crank_angle": 2.0 * TIMES + 0.1}, SCENE, 0.25)
    assert own.angle == pytest.approx(2.0 * TIMES + 0.35)
    assert own.phase == pytest.approx(0.1)


def test_phases_lose_whole_turns_and_jumps_by_a_turn() -> None:
    off = 0.2 * np.sin(TIMES)
    for turns in (0.0, 1.0, -3.0):
        angle = np.mod(2.0 * TIMES + off, 2.0 * np.pi) + 2.0 * np.pi * turns
        table = TableComparison({"time": TIMES, "crank_angle": angle}, SCENE)
        assert table.phases == pytest.approx(off, abs=1e-12)
        assert table.phase == pytest.approx(np.abs(off).max())
    late = TableComparison({"time": TIMES, "crank_angle": 2.0 * TIMES - 0.3}, SCENE)
    assert late.phases == pytest.approx(np.full(31, -0.3))
    assert late.phase == pytest.approx(0.3)


def test_exact_motion_is_that_of_the_crank_of_the_table() -> None:
    angle, rate, acceleration = 2.0 * TIMES + 0.1, np.full(31, 2.5), np.full(31, 0.7)
    columns = {"time": TIMES, "crank_angle": angle, "crank_speed": rate, "crank_acceleration": acceleration}
    expected = SCENE.motion(angle, rate, acceleration).point("P")
    table = TableComparison(columns, SCENE)
    for quantity in ALL:
        assert getattr(table.motion_at_own_crank.point("P"), quantity) == pytest.approx(getattr(expected, quantity))
    nominal = SCENE.motion(2.0 * TIMES, 2.0).point("P")
    for quantity in ALL:
        assert getattr(table.motion_at_nominal_crank.point("P"), quantity) == pytest.approx(getattr(nominal, quantity))
    # What the table does not say is nominal.
    rates = TableComparison({"time": TIMES, "crank_speed": rate}, SCENE).motion_at_own_crank.point("P")
    expected = SCENE.motion(2.0 * TIMES, 2.5, 0.0).point("P")
    assert rates.acceleration == pytest.approx(expected.acceleration)
    angles = TableComparison({"time": TIMES, "crank_angle": angle}, SCENE).motion_at_own_crank.point("P")
    assert angles.velocity == pytest.approx(SCENE.motion(angle, 2.0).point("P").velocity)
    bare = compared()
    assert bare.motion_at_own_crank is bare.motion_at_nominal_crank


# -- errors ----------------------------------------------------------------------------------------------------------


def test_columns_of_an_error_are_found_by_point_and_component() -> None:
    table = TableComparison(dict.fromkeys(("time", "P.y", "Q.x", "Q.y", "P.vx", "Q.ay"), TIMES), SCENE)
    for name in ("position", "total"):
        assert table.axes(name, "P") == {1: "P.y"}
        assert table.axes(name, "Q") == {0: "Q.x", 1: "Q.y"}
        assert table.points(name) == ["P", "Q"]
    assert table.axes("velocity", "P") == {0: "P.vx"}
    assert (table.points("velocity"), table.points("acceleration")) == (["P"], ["Q"])
    assert table.axes("acceleration", "P") == {}


@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_errors_are_divided_by_l_and_powers_of_the_speed(speed: float) -> None:
    scene = CirclingPoints(speed)
    assert [scene_size for name in ("total", *ALL) for scene_size in [compared(scene).normalising_size(name, "Q")]] == [
        4.0, 4.0, 8.0, 16.0,
    ]  # fmt: skip
    table = scene.table(TIMES, *ALL)
    table["Q.x"][7] += 0.3
    table["Q.y"][7] -= 0.4
    table["P.vy"][4] += 0.1
    table["P.ax"][30] -= 0.2
    found = TableComparison(table, scene)
    assert found.largest("position") == pytest.approx(0.5 / 4.0)
    assert found.largest("total") == pytest.approx(0.5 / 4.0)
    assert found.largest("velocity") == pytest.approx(0.1 / 2.0)
    assert found.largest("acceleration") == pytest.approx(0.2 / 4.0)
    assert found.difference("position", "Q")[7] == pytest.approx([0.3, -0.4])
    assert found.normalised_differences("velocity")[4] == pytest.approx([0.0, 0.05, 0.0, 0.0])
    assert compared(scene).largest("position") is None


def test_total_is_at_nominal_time_and_position_at_table_angle() -> None:
    angle = 2.0 * TIMES + 0.01
    table = SCENE.table(TIMES + 0.005) | {"time": TIMES, "crank_angle": angle}
    found = TableComparison(table, SCENE)
    assert found.largest("position") == pytest.approx(0.0, abs=1e-14)
    # A chord of 0.01 rad at a radius of L / 2.
    assert found.largest("total") == pytest.approx(math.sin(0.005), rel=1e-9)


def test_error_curves_keep_the_largest_error_of_each_span() -> None:
    count = 2 * MAX_CURVE_SPANS + 1
    times = np.linspace(0.0, 3.0 * SCENE.period, count) + 0.25
    table = SCENE.table(times)
    off = np.zeros(count)
    off[[10, 11, 800]] = 0.1, 0.2, -0.4
    table["P.y"] = table["P.y"] + off
    curve = TableComparison(table, SCENE).errors["P"]["position"]
    assert (curve.size.max, curve.size.final) == (pytest.approx(0.4), pytest.approx(0.4))
    assert curve.size.rms == pytest.approx(math.sqrt((0.01 + 0.04 + 0.16) / count))
    assert len(curve.at) == len(curve.largest) == MAX_CURVE_SPANS
    assert curve.largest[5] == pytest.approx(0.2)
    assert curve.largest[-1] == pytest.approx(0.4)
    assert curve.at[:2] == pytest.approx([0.0, 3.0 * 2 / (count - 1)])
    few = TableComparison(SCENE.table(TIMES, "position", "velocity"), SCENE).errors
    assert list(few) == ["P", "Q"]
    assert list(few["P"]) == ["total", "position", "velocity"]
    assert few["Q"]["velocity"].at == pytest.approx(TIMES / SCENE.period)


def test_angle_derivatives_are_those_of_the_differences() -> None:
    table = SCENE.table(TIMES) | {"crank_angle": 2.0 * TIMES + 0.1}
    del table["Q.x"]
    for name, angle in (("total", 2.0 * TIMES + 0.3), ("position", 2.0 * TIMES + 0.4)):
        found = TableComparison(table, SCENE, 0.3).angle_derivatives(name)
        # d/da of r (cos a, sin a) over L = 2 r; the table stays as it is.
        expected = -0.5 * np.column_stack([-np.sin(angle), np.cos(angle), np.cos(angle)])
        assert found == pytest.approx(expected)


# -- estimates -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("by", [0.3, -2.5, 3.1])
def test_a_shift_of_the_crank_is_found_with_its_standard_error(by: float) -> None:
    # Radii that are off in turns by d say nothing of the angle: they stay as what is left.
    d, sign = 1e-3, (-1.0) ** np.arange(31)
    table = {"time": TIMES}
    for point, radius in SCENE.radii.items():
        for axis, wave in (("x", np.cos), ("y", np.sin)):
            table[f"{point}.{axis}"] = (radius + d * 2.0 * radius * sign) * wave(2.0 * TIMES + by)
    shift, error, left = best_crank_shift(TableComparison(table, SCENE), "total")
    assert shift == pytest.approx(by, abs=1e-9)
    # Of 124 numbers: s^2 = 62 d^2 / 123, and J^T J = 62 / 4, since each point moves by L / 2 a radian.
    assert error == pytest.approx(math.sqrt(62.0 * d**2 / 123.0 / (62.0 / 4.0)), rel=1e-6)
    assert left == pytest.approx(d, rel=1e-6)


def test_a_shift_that_nothing_depends_on_has_no_finite_error() -> None:
    table = TableComparison({"time": TIMES, "P.x": np.zeros(31)}, _Still())  # type: ignore[arg-type]
    shift, error, left = best_crank_shift(table, "total")
    assert math.isinf(error)
    assert (shift, left) == (0.0, 0.0)
    with pytest.raises(InvalidInput, match=r"^--estimate phase: phase cannot be determined: nothing in this table "):
        estimate(table, ["phase"])


class _Still(CirclingPoints):
    """Points that stay at the shaft, however the crank turns."""

    def motion(self, angle: Any, rate: Any, acceleration: Any = 0.0) -> Any:
        zeros = np.zeros((len(angle), 2))
        return SimpleNamespace(point=lambda name: SimpleNamespace(position=zeros, velocity=zeros, acceleration=zeros))


class _Jittering(CirclingPoints):
    """Points that move by far less than what is taken for their travel."""

    @property
    def lengths(self) -> dict[str, float]:
        return dict.fromkeys(self.radii, 1.0)


@pytest.mark.parametrize(("radius", "known"), [(0.9e-7, False), (2e-7, True)])
def test_shift_is_unknown_when_slope_is_below_1e_7_per_radian(radius: float, known: bool) -> None:
    # The root mean square of both components' derivatives is the radius over the root of 2.
    scene = _Jittering(radii={"P": radius})
    shift, error, _ = best_crank_shift(TableComparison(scene.table(TIMES) | {"time": TIMES - 0.1}, scene), "total")
    assert shift == pytest.approx(0.2, abs=1e-6)
    assert math.isfinite(error) is known


@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_clock_is_estimated_from_positions_or_else_from_crank(speed: float) -> None:
    scene = CirclingPoints(speed)
    late = TableComparison(scene.table(TIMES) | {"time": TIMES + 0.1}, scene)
    (found,) = estimate(late, ["time"])
    assert (found.name, found.value) == ("time", pytest.approx(0.1))
    (found,) = estimate(late, ["phase"])
    assert (found.name, found.value) == ("phase", pytest.approx(-0.1 * speed))
    # By the crank alone: the mean of its deviations, whose standard error is that of a mean.
    off = np.where(np.arange(31) % 2 == 0, 0.201, 0.199)
    spread = float(np.sum((off - off.mean()) ** 2))
    crank = TableComparison({"time": TIMES, "crank_angle": speed * TIMES + off}, scene)
    (found,) = estimate(crank, ["phase"])
    assert found.value == pytest.approx(off.mean())
    assert found.error == pytest.approx(math.sqrt(spread / 30.0 / 31.0))
    assert found.remaining == pytest.approx(math.sqrt(spread / 31.0))
    (found,) = estimate(crank, ["time"])
    assert found.value == pytest.approx(-off.mean() / speed)
    assert found.error == pytest.approx(math.sqrt(spread / 30.0 / 31.0) / 2.0)
    assert found.remaining == pytest.approx(math.sqrt(spread / 31.0))


def test_the_zero_of_an_encoder_comes_before_the_clock() -> None:
    table = SCENE.table(TIMES) | {"time": TIMES + 0.1, "crank_angle": 2.0 * TIMES - 0.4}
    found = estimate(TableComparison(table, SCENE), ["time", "phase"])
    assert [(one.name, one.value) for one in found] == [
        ("zero", pytest.approx(0.4)), ("time", pytest.approx(0.1)),
    ]  # fmt: skip
    assert [one.name for one in estimate(TableComparison(table, SCENE), ["phase"])] == ["zero", "phase"]
    assert [one.name for one in estimate(TableComparison(table, SCENE), ["time"])] == ["time"]


def test_estimates_are_taken_off_the_clock_and_the_crank() -> None:
    table = TableComparison({"time": TIMES, "crank_angle": TIMES}, SCENE)

    def aligned(*estimates: tuple[str, float]) -> tuple[Any, Any]:
        found = align_clock(table, [Estimate(name, value, 0.0, 0.0) for name, value in estimates]).values
        return found["time"] - TIMES, found["crank_angle"] - TIMES

    for estimates, time, angle in (
        ([("time", 0.1)], -0.1, 0.0),
        ([("phase", 0.1)], 0.05, 0.0),  # at 2 rad/s
        ([("zero", 0.4)], 0.0, 0.4),
        ([("zero", 0.4), ("time", 0.1)], -0.1, 0.4),
        ([], 0.0, 0.0),
    ):
        by, turned = aligned(*estimates)
        assert by == pytest.approx(np.full(31, time), abs=1e-12)
        assert turned == pytest.approx(np.full(31, angle), abs=1e-12)


@pytest.mark.parametrize(
    ("columns", "span", "asked", "message"),
    [
        (("P.vx",), None, ["time"], "--estimate time: the table has no positions to estimate it from"),
        (
            ("P.x",), (0.0, 1.0), ["time"],
            "--estimate time: it would be looked for anywhere in a turn, and the input makes one pass",
        ),
        *(
            (columns, None, ["time", "phase"],
             "--estimate time,phase: at constant speed one looks like the other in this table: ask for one of them")
            for columns in (("P.x",), ("crank_angle",))
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_estimated_is_refused(
    columns: tuple[str, ...], span: tuple[float, float] | None, asked: list[str], message: str
) -> None:
    table = TableComparison({"time": TIMES, **dict.fromkeys(columns, TIMES)}, CirclingPoints(span=span))  # type: ignore[arg-type]
    with pytest.raises(InvalidInput) as refused:
        estimate(table, asked)
    assert str(refused.value) == message


def test_names_of_estimates_are_checked_and_kept_once() -> None:
    assert check_estimated(["phase", "time", "phase"]) == ("phase", "time")
    with pytest.raises(InvalidInput) as refused:
        check_estimated(["time", "speed"])
    assert str(refused.value) == "unknown thing to estimate 'speed': choose from phase, time"
