"""Why a table is off is said where undoing the slip makes the difference go away, and only there."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from circling_points import CirclingPoints
from synthetic import longer_rod, synthetic_trajectory
from table_files import ROWS, Columns, exact_table, judge_columns

from conrod.models.tables.causes import _fit_stamp, _reproducing_causes
from conrod.models.tables.errors import TableComparison
from conrod.models.tables.study import TableStudy
from conrod.scenes import Saw, Scene, ShearPress, scene_named

ALL = ("position", "velocity", "acceleration")
SAW, PRESS = Saw(speed=20.0), ShearPress(speed=-5.0)
NOTHING = ("total", *ALL)
TIMES = np.linspace(0.0, math.radians(2.0 * PRESS.period), 2 * ROWS + 1)  # of a crank that turns at deg/s


def kinds(study: TableStudy) -> list[str]:
    return [cause.kind for cause in study.causes]


def only_cause(study: TableStudy, kind: str, explains: tuple[str, ...], words: str) -> None:
    assert kinds(study) == [kind], [cause.text for cause in study.causes]
    cause = study.causes[0]
    assert words in cause.text
    assert tuple(cause.explains) == explains
    for name, (before, after) in cause.explains.items():
        assert before == pytest.approx(study.largest(name), rel=0.02)
        assert after < 0.05 * before


def steps(scene: Scene, count: float, quantities: tuple[str, ...] = ALL) -> Columns:
    """Quantities that belong so many steps later than their rows say."""
    table = exact_table(scene, ALL)
    late = exact_table(scene, ALL, times=table["time"] + count * scene.period / ROWS)
    return table | {name: late[name] for name in exact_table(scene, quantities) if name != "time"}


def scaled(table: Columns, factor: float, part: str) -> Columns:
    return {name: column * factor if part in name else column for name, column in table.items()}


def moved(table: Columns, part: str, by: float) -> Columns:
    return {name: column + by if part in name else column for name, column in table.items()}


def swapped(table: Columns) -> Columns:
    letters = str.maketrans("xy", "yx")
    return {name[:-1] + name[-1].translate(letters) if "." in name else name: table[name] for name in table}


def turned(table: Columns) -> Columns:
    """In a frame that is turned by 20 deg about another origin."""
    turn = complex(np.exp(1j * math.radians(20.0)))
    for name in [name[:-1] for name in table if name.endswith("x")]:
        both = (table[f"{name}x"] + 1j * table[f"{name}y"]) * turn + (0.1 if name.endswith(".") else 0.0)
        table |= {f"{name}x": both.real, f"{name}y": both.imag}
    return table


def of_longer_rod(scene: Scene) -> Columns:
    tracks = {point: own.position for point, own in synthetic_trajectory(scene, longer_rod(scene)).points.items()}
    table = {"time": next(iter(tracks.values())).instants.times}
    for point, track in tracks.items():
        table |= {f"{point}.x": track.values[:, 0], f"{point}.y": track.values[:, 1]}
    return table


POSITION = ("total", "position")
# What is planted, and the kind, the errors that it explains and words of the one cause that is to be named.
SLIPS = [
    (steps(SAW, 0.3), SAW, "time offset", NOTHING, "(0.3 of a step) later"),
    (scaled(exact_table(SAW, ALL), 1e3, "."), SAW, "length unit", NOTHING, "mm taken for m"),
    (scaled(exact_table(SAW, crank=True), 180.0 / math.pi, "crank"), SAW, "angle unit", ("position",),
     "degrees taken for radians"),
    (scaled(exact_table(PRESS, times=TIMES), 180.0 / math.pi, "time"), PRESS, "speed unit", POSITION,
     "rad/s taken for deg/s"),
    (exact_table(Saw(speed=-20.0), ALL), SAW, "opposite sense", NOTHING, "opposite sense"),
    (swapped(exact_table(PRESS, ALL)), PRESS, "axes swapped", NOTHING, "x and y are swapped"),
    (steps(SAW, 0.5, ("velocity",)), SAW, "velocity stamp", ("velocity",), "(0.5 of a step) later"),
    (steps(SAW, 0.5, ("acceleration",)), SAW, "acceleration stamp", ("acceleration",), "(0.5 of a step) later"),
    (moved(exact_table(PRESS, ALL), ".x", 0.25), PRESS, "frame", POSITION, "offset by (250, "),
    (turned(exact_table(SAW, ALL)), SAW, "frame", NOTHING, "and turned by 20 deg"),
    (moved(exact_table(SAW, ALL, crank=True), "crank", -math.pi / 6.0), SAW, "crank zero", ALL,
     "0 where the scene's is 30 deg"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("table", "scene", "kind", "explains", "words"), SLIPS, ids=[f"{slip[2]}-{k}" for k, slip in enumerate(SLIPS)]
)
def test_a_slip_is_named_with_its_size_and_nothing_else_is(
    table: Columns, scene: Scene, kind: str, explains: tuple[str, ...], words: str, tmp_path: Path
) -> None:
    only_cause(judge_columns(table, scene, tmp_path), kind, explains, words)


# -- negative controls -------------------------------------------------------------------------------------------------


RANDOM = np.random.default_rng(3)
# A drift and a single row are faults of sensors (test_tables_sensors.py); a bent drift and a dozen rows are not known.
SHAPES = {"noise": RANDOM.normal(size=2 * ROWS + 1), "bent drift": np.linspace(0.0, 1.0, 2 * ROWS + 1) ** 2}
SHAPES |= {"longer rod": np.zeros(1), "a dozen rows": 1.0 * (np.arange(2 * ROWS + 1) % 19 == 3)}
# An offset takes much of the difference away, not all.
SHAPES |= {"longer rod in another frame": np.full(1, 0.2)}


@pytest.mark.parametrize("plant", SHAPES)
def test_what_no_slip_reproduces_is_not_explained(plant: str, tmp_path: Path) -> None:
    scene = SAW
    table = of_longer_rod(scene) if "longer rod" in plant else exact_table(scene)
    for point in scene.lengths:
        table[f"{point}.x"] = table[f"{point}.x"] + 1e-3 * min(scene.lengths.values()) * SHAPES[plant]
    study = judge_columns(table, scene, tmp_path)
    assert (study.largest("total") or 0.0) > 1e-5
    assert kinds(study) == []


def test_where_one_slip_explains_all_a_poorer_one_is_not_named(tmp_path: Path) -> None:
    # Lengths so small stand all but still, and so they do where the crank hardly turns.
    table = exact_table(SAW)
    table = {name: table[name] * (1.0 if name == "time" else 1e-3) for name in ("time", "C.x", "C.y")}
    only_cause(judge_columns(table, SAW, tmp_path), "length unit", POSITION, "m taken for mm")
    # An estimate of a table that is far off does not run away.
    bar = scene_named("six-bar")
    study = judge_columns(scaled(exact_table(bar, rows=60), 1e3, "."), bar, tmp_path, ["time"])
    assert kinds(study) == ["length unit"]


def test_within_tolerance_nobody_asks_why(tmp_path: Path) -> None:
    table = steps(SAW, 0.3)
    assert judge_columns(table, SAW, tmp_path, tolerance={"position": 0.1}).causes == ()
    assert kinds(judge_columns(table, SAW, tmp_path, tolerance={"position": 1e-6})) == ["time offset"]


@pytest.mark.parametrize("noise", [0.0, 1e-4, 1e-3])
def test_of_one_kind_the_simplest_that_explains_is_named(noise: float, tmp_path: Path) -> None:
    # A turn besides leaves a little less of the noise, a thousandth of nothing without any; it is not there.
    table = moved(exact_table(PRESS, ALL), ".x", 0.25)
    for name in (name for name in table if name != "time" and name[-2] == "."):
        table[name] = table[name] + noise * PRESS.lengths[name[0]] * RANDOM.normal(size=2 * ROWS + 1)
    study = judge_columns(table, PRESS, tmp_path, tolerance={"position": 1e-6})
    assert kinds(study) == ["frame"]
    assert "offset by (2" in study.causes[0].text
    assert "turned" not in study.causes[0].text


def test_a_turn_is_named_where_the_offset_alone_leaves_far_more(tmp_path: Path) -> None:
    table = turned(exact_table(SAW, ("position",)))
    for name in (name for name in table if name != "time"):
        table[name] = table[name] + 1e-5 * SAW.lengths[name[0]] * RANDOM.normal(size=2 * ROWS + 1)
    study = judge_columns(table, SAW, tmp_path, tolerance={"position": 1e-6})
    assert kinds(study) == ["frame"]
    assert "and turned by 20" in study.causes[0].text


def test_causes_that_explain_as_much_stand_by_what_they_leave(tmp_path: Path) -> None:
    # Half a step of a velocity is explained in full, and next to it nothing that leaves a twentieth.
    study = judge_columns(steps(SAW, 0.5, ("velocity",)), SAW, tmp_path)
    for cause in study.causes:
        for before, after in cause.explains.values():
            assert after <= 0.05 * min(before, 1.0)
    lefts = [max(after / before for before, after in cause.explains.values()) for cause in study.causes]
    assert lefts == sorted(lefts)


@pytest.mark.parametrize(("noise", "named"), [(0.04, ["length unit"]), (0.06, [])])
def test_large_error_is_explained_up_to_a_twentieth_of_length(noise: float, named: list[str], tmp_path: Path) -> None:
    # A thousand times too long, a table is off by a thousand L; what remains is compared with L.
    table, random = exact_table(SAW), np.random.default_rng(4)
    for name in (name for name in table if name != "time"):
        table[name] = table[name] + noise / math.sqrt(2.0) * SAW.lengths[name[0]] * random.choice(
            [-1.0, 1.0], 2 * ROWS + 1
        )
    study = judge_columns(scaled(table, 1e3, "."), SAW, tmp_path)
    assert (study.largest("total") or 0.0) > 100.0
    assert kinds(study) == named


def test_cause_of_more_errors_is_named_first(tmp_path: Path) -> None:
    table = moved(steps(SAW, 0.5, ("velocity",)), ".x", 0.25)
    study = judge_columns(table, SAW, tmp_path)
    assert [(cause.kind, tuple(cause.explains)) for cause in study.causes] == [
        ("frame", POSITION), ("velocity stamp", ("velocity",)),
    ]  # fmt: skip


@pytest.mark.parametrize(("factor", "text"), [(0.1, "simple"), (0.099, "involved")])
def test_simpler_cause_stays_unless_another_leaves_far_less(factor: float, text: str) -> None:
    def undone(remaining: float) -> Any:
        return SimpleNamespace(largest=lambda name: remaining, points=lambda name: ())

    tried = [
        ("frame", "simple", undone(0.03125), ("total",)),
        ("frame", "involved", undone(factor * 0.03125), ("total",)),
    ]
    (found,) = _reproducing_causes(tried, undone(1.0), {"total": 1.0}, {})
    assert found.text == text


@pytest.mark.parametrize(("turns", "found"), [(0.3, True), (-0.49, True), (0.498, False), (-0.498, False)])
def test_a_stamp_is_not_looked_for_at_half_a_turn(turns: float, found: bool) -> None:
    # There later is as near as earlier.
    scene: Any = CirclingPoints()
    times = np.linspace(0.0, 2.0 * scene.period, 81)
    late = scene.table(times + turns * scene.period, "velocity") | {"time": times}
    expected = pytest.approx(turns * scene.period, rel=1e-9) if found else None
    assert _fit_stamp("velocity", TableComparison(late, scene)) == expected
