"""What a verdict on a table rests on, and what its clock is allowed: columns that move, digits that are written."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from circling_points import CirclingPoints

from conrod.engines.numerics import phase_bound
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.models.tables.clock import clock_limits
from conrod.models.tables.columns import Column
from conrod.models.tables.coverage import (
    check_moving,
    exact_travels,
    limited_quantity,
    still_columns,
    unjudged_quantities,
)
from conrod.models.tables.errors import TableComparison
from conrod.models.tables.reading import Reading
from conrod.scenes import Saw

QUARTERS = np.arange(5) * np.pi / 4.0  # [s], of a turn in pi seconds


class Carried(CirclingPoints):
    """Points whose travel is given over a length of 1 m: twice their radius."""

    @property
    def lengths(self) -> dict[str, float]:
        return dict.fromkeys(self.radii, 1.0)


SCENE = Carried(radii={"A": 0.5, "B": 0.0, "C": 0.25})


def with_columns(*names: str, scene: CirclingPoints = SCENE) -> TableComparison:
    return TableComparison(dict.fromkeys(names, QUARTERS) | {"time": QUARTERS}, scene)  # type: ignore[arg-type]


# -- coverage --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("tolerance", "quantity"), [
    ("total", "position"), ("position", "position"), ("velocity", "velocity"), ("velocity_rms", "velocity"),
    ("acceleration", "acceleration"), ("phase", "phase"),
])  # fmt: skip
def test_a_tolerance_limits_a_quantity(tolerance: str, quantity: str) -> None:
    assert limited_quantity(tolerance) == quantity


def test_travel_is_the_range_of_position_and_size_of_rate() -> None:
    # In quarters of a turn: x from -r to r, velocities up to 2 r / s over omega L, accelerations 4 r over omega^2 L.
    assert exact_travels(with_columns(), "position") == pytest.approx(
        {"A.x": 1.0, "A.y": 1.0, "B.x": 0.0, "B.y": 0.0, "C.x": 0.5, "C.y": 0.5}
    )
    for quantity, letter in (("velocity", "v"), ("acceleration", "a")):
        assert exact_travels(with_columns(), quantity) == pytest.approx(
            {f"{point}.{letter}{axis}": radius for point, radius in SCENE.radii.items() for axis in "xy"}
        )
    # Half a turn, from the side on.
    half = TableComparison({"time": QUARTERS[:3]}, SCENE)  # type: ignore[arg-type]
    assert exact_travels(half, "position")["A.y"] == pytest.approx(0.5)


@pytest.mark.parametrize(("columns", "tolerance", "message"), [
    (("C.x",), {"position": 0.5}, "--tolerance position=0.5: it judges nothing, for the exact C.x moves by no more "
     "than that; give a column that moves: A.x, A.y"),
    (("C.x", "C.y"), {"total": 0.75}, "--tolerance total=0.75: it judges nothing, for the exact C.x, C.y move by no "
     "more than that; give a column that moves: A.x, A.y"),
    (("A.vx",), {"velocity_rms": 0.5},
     "--tolerance velocity_rms=0.5: it judges nothing, for the exact A.vx moves by no more than that"),
    (("A.x", "B.ay"), {"position": 0.1, "acceleration": 1e-3},
     "--tolerance acceleration=0.001: it judges nothing, for the exact B.ay moves by no more than that; "
     "give a column that moves: A.ax, A.ay, C.ax, C.ay"),
])  # fmt: skip
def test_a_tolerance_of_what_moves_no_further_is_refused(
    columns: tuple[str, ...], tolerance: dict[str, float], message: str
) -> None:
    with pytest.raises(InvalidInput) as refused:
        check_moving(with_columns(*columns), tolerance, tolerance)
    assert str(refused.value) == message


def test_tolerances_of_what_moves_are_not_refused() -> None:
    check_moving(with_columns("C.x"), {"position": 0.49}, ["position"])
    check_moving(with_columns("B.x", "C.y"), {"position": 0.49, "phase": 1.0}, ["position", "phase"])
    # What follows from another tolerance is not asked for.
    check_moving(with_columns("C.x"), {"position": 0.49, "total": 0.9}, ["position"])


def test_a_refusal_names_six_columns_of_each_kind() -> None:
    scene = Carried(radii=dict.fromkeys("ABCD", 0.5) | dict.fromkeys("EFGH", 0.0))
    with pytest.raises(InvalidInput) as refused:
        check_moving(
            with_columns(*(f"{p}.{a}" for p in "EFGH" for a in "xy"), scene=scene), {"position": 0.1}, ["position"]
        )
    assert str(refused.value) == (
        "--tolerance position=0.1: it judges nothing, for the exact E.x, E.y, F.x, F.y, G.x, G.y move by no more than "
        "that; give a column that moves: A.x, A.y, B.x, B.y, C.x, C.y"
    )


def test_columns_stand_still_where_all_of_their_quantity_do() -> None:
    assert still_columns(with_columns("B.x", "B.y", "A.vx"), 1e-6) == ["B.x", "B.y"]
    assert still_columns(with_columns("B.x", "A.y", "B.ax"), 1e-6) == ["B.ax"]
    assert still_columns(with_columns("C.vx"), 0.25) == ["C.vx"]
    assert still_columns(with_columns("C.vx"), 0.249) == []
    assert still_columns(with_columns(), 1.0) == []


@pytest.mark.parametrize(("columns", "tolerance", "unjudged"), [
    ((), {}, ()),
    (("A.x", "A.y", "C.x", "C.y", "crank_angle"), {"position": 0.1, "phase": 1.0}, ("velocity", "acceleration")),
    (("A.x", "A.y", "C.x", "C.y", "crank_angle"), {"position": 0.1}, ("velocity", "acceleration", "crank angle")),
    (("A.x", "A.y", "C.x", "C.y"), {"total": 0.1, "phase": 1.0}, ("velocity", "acceleration", "crank angle")),
    # C moves by 0.5, which is allowed; of A one component is missing.
    (("A.x", "crank_angle"), {"position": 0.5, "phase": 1.0}, ("position of A.y", "velocity", "acceleration")),
    (("A.x", "crank_angle"), {"position": 0.49, "phase": 1.0}, ("position of A.y, C", "velocity", "acceleration")),
    # The smallest tolerance of a quantity counts.
    (("A.x", "A.y", "crank_angle"), {"position": 0.6, "total": 0.49, "phase": 1.0},
     ("position of C", "velocity", "acceleration")),
    (("A.vx", "A.vy", "C.vx", "crank_angle"), {"velocity_rms": 0.1, "phase": 1.0},
     ("position", "velocity of C.vy", "acceleration")),
])  # fmt: skip
def test_what_a_verdict_leaves_out(
    columns: tuple[str, ...], tolerance: dict[str, float], unjudged: tuple[str, ...]
) -> None:
    assert unjudged_quantities(with_columns(*columns), tolerance) == unjudged


def test_a_column_that_moves_as_far_as_is_allowed_stands_still() -> None:
    # In half a turn from the side on, x travels twice as far as y.
    scene = Carried(radii={"A": 0.5})
    half = TableComparison(dict.fromkeys(("time", "A.y"), QUARTERS[:3]), scene)  # type: ignore[arg-type]
    limit = exact_travels(half, "position")["A.y"]
    assert unjudged_quantities(half, {"position": limit})[0] == "position of A (A.y stands still)"
    assert unjudged_quantities(half, {"position": 0.99 * limit})[0] == "position of A.x"


@pytest.mark.parametrize(("count", "words"), [
    (6, "position of A, B, C, D, E, F"), (7, "position of A, B, C, D, E, F and 1 more"),
    (8, "position of A, B, C, D, E, F and 2 more"),
])  # fmt: skip
def test_a_verdict_names_six_points_that_it_leaves_out(count: int, words: str) -> None:
    scene = Carried(radii=dict.fromkeys("ABCDEFGH"[:count], 0.5))
    assert unjudged_quantities(with_columns(scene=scene), {"position": 0.1})[0] == words


def test_a_point_whose_column_stands_still_is_not_judged() -> None:
    scene = Sliding(radii={"A": 0.5, "C": 0.25})
    found = unjudged_quantities(with_columns("A.y", "C.x", "C.y", scene=scene), {"position": 0.1})
    assert found[0] == "position of A (A.y stands still)"


class Sliding(Carried):
    """Points whose point A stays at the height of the shaft."""

    def motion(self, angle: Array, rate: Any, acceleration: Any = 0.0) -> Any:
        motion = super().motion(angle, rate, acceleration)

        def point(name: str) -> Any:
            there = motion.point(name)
            there.position[:, 1] *= name != "A"
            return there

        return SimpleNamespace(point=point)


# -- the clock -------------------------------------------------------------------------------------------------------

SPEED = 2.0
ANGLE_ROUNDING = 1e-13  # [rad], of angles of some turns in double precision


def limits(
    times: Array, angles: Array, asked: dict[str, float], factors: tuple[float, float] = (1.0, 1.0), scene: Any = None
) -> dict[str, float]:
    """Limits of a table with a time and a crank angle, SI, in columns with factors to SI."""
    values = {"time": times, "crank_angle": angles}
    columns = tuple(
        Column(name, k, name, "", factor, "heading")
        for k, (name, factor) in enumerate(zip(values, factors, strict=True))
    )
    reading = Reading(values, columns, (), "text")
    return clock_limits(TableComparison(values, scene or CirclingPoints(SPEED)), reading, asked)  # type: ignore[arg-type]


RANDOM = np.random.default_rng(3)
IRREGULAR = np.cumsum(RANDOM.integers(1, 10, 60))  # distances of which most are no multiple of the least


def test_clock_has_a_limit_when_angle_and_tolerance_are_given() -> None:
    times = np.arange(10) * 0.1
    assert limits(times, SPEED * times, {}) == {}
    assert limits(times, SPEED * times, {"total": 0.1}) == {}
    assert limits(times, SPEED * times, {"phase": 0.25}) == {"phase": 0.25}
    bare = TableComparison({"time": times}, CirclingPoints(SPEED))  # type: ignore[arg-type]
    reading = Reading({"time": times}, (Column("time", 0, "t", "s", 1.0, "heading"),), (), "text")
    assert clock_limits(bare, reading, {"velocity": 0.1}) == {}


def test_equally_spaced_times_and_angles_are_allowed_rounding() -> None:
    times = np.arange(10) * 0.1
    found = limits(times, SPEED * times, {"velocity": 0.1})
    assert list(found) == ["phase"]
    rounding = phase_bound(10, SPEED * 0.9 / (2.0 * math.pi))
    assert rounding <= found["phase"] < rounding + ANGLE_ROUNDING


@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_irregular_times_are_allowed_half_a_digit_in_their_unit(speed: float) -> None:
    # Written in ms to one decimal: 0.05 ms, at 2 rad/s.
    times = IRREGULAR * 0.1 * 1e-3
    found = limits(times, speed * times, {"velocity": 0.1}, (1e-3, 1.0), CirclingPoints(speed))
    assert found["phase"] == pytest.approx(2.0 * 0.05e-3, rel=1e-6)


def test_irregular_angles_are_allowed_half_a_digit_in_their_unit() -> None:
    # Written in degrees to two decimals, at times in full: 0.005 deg.
    degrees = IRREGULAR * 0.01
    times = np.radians(degrees) / SPEED
    found = limits(times, np.radians(degrees), {"velocity": 0.1}, (1.0, math.pi / 180.0))
    assert found["phase"] == pytest.approx(math.radians(0.005), rel=1e-6)


def test_single_precision_is_allowed_half_of_its_last_digit() -> None:
    times = np.cumsum(RANDOM.uniform(0.01, 0.1, 60)).astype(np.float32).astype(float)
    found = limits(times, SPEED * times + 1e-9 / 3.0, {"velocity": 0.1})
    assert found["phase"] == pytest.approx(SPEED * 2.0**-24 * times.max(), rel=1e-4)
    # Angles that are single precision too may be off by as much again.
    both = limits(times, SPEED * times, {"velocity": 0.1})
    assert both["phase"] == pytest.approx(2.0 * SPEED * 2.0**-24 * times.max(), rel=1e-4)


@pytest.mark.parametrize("factor", [1.0, 1e-3])
def test_times_are_exact_without_some_rows_when_far_above_digits(factor: float) -> None:
    # Written to 10 of its unit, whose half is 5; distances of 20 are more than three times that.
    kept = np.cumsum([0, 1, 3, 1, 4, 1, 3, 1, 1, 3, 1, 2, 1]) * 20.0 * factor
    found = limits(kept, SPEED * kept, {"velocity": 0.1}, (factor, 1.0))
    assert found["phase"] < phase_bound(13, SPEED * kept.max() / (2.0 * math.pi)) + 1e-11 * kept.max()
    # Distances of 10 are not: most of them are multiples of the last digit whatever they were.
    near = np.cumsum([0, 1, 3, 1, 4, 1, 3, 1, 1, 3, 1, 2, 1]) * 10.0 * factor
    assert limits(near, SPEED * near, {"velocity": 0.1}, (factor, 1.0))["phase"] > SPEED * 4.9 * factor


def test_a_crank_that_never_turns_has_no_digits() -> None:
    times = np.arange(5) * 0.1
    assert limits(times, np.zeros(5), {"velocity": 0.1})["phase"] < 1e-12


def test_the_total_is_allowed_what_the_phase_moves_a_point() -> None:
    scene = Saw(speed=SPEED)
    times = np.arange(10) * 0.1
    found = limits(times, SPEED * times, {"position": 1e-3, "phase": 1e-2}, scene=scene)
    turn = scene.motion(np.linspace(0.0, 2.0 * np.pi, 2000), 1.0)
    # The largest derivative by the angle, over all points, each over its L.
    largest = max(
        np.linalg.norm(turn.point(name).velocity, axis=1).max() / size for name, size in scene.lengths.items()
    )
    assert found["phase"] == 1e-2
    assert found["total"] == pytest.approx(1e-3 + 1e-2 * largest, rel=1e-3)
