"""Why a table is off is said where undoing the slip makes the difference go away, and only there."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from conrod.own.tables.study import TableStudy
from conrod.scenes import Saw, Scene, ShearPress
from tests.support.synthetic import longer_rod, synthetic_trajectory
from tests.support.table_files import ROWS, Columns, exact_table, judged

ALL = ("position", "velocity", "acceleration")
SAW, PRESS = Saw(speed=20.0), ShearPress(speed=-5.0)
SCENES = [SAW, PRESS]
NOTHING = ("total", *ALL)


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


def later(scene: Scene, by: float, quantities: tuple[str, ...] = ALL) -> Columns:
    """Quantities that belong so much later than their rows say [s]."""
    table = exact_table(scene, ALL)
    shifted = exact_table(scene, ALL, times=table["time"] + by)
    letters = {"position": "", "velocity": "v", "acceleration": "a"}
    for quantity in quantities:
        for point in scene.lengths:
            for axis in "xy":
                name = f"{point}.{letters[quantity]}{axis}"
                table[name] = shifted[name]
    return table


@pytest.mark.parametrize(("scene", "steps"), [(SAW, 0.3), (PRESS, -0.5), (SAW, 4.0)])
def test_a_time_offset_of_a_fraction_of_a_step_is_named(scene: Scene, steps: float, tmp_path: Path) -> None:
    step = scene.period / ROWS
    study = judged(later(scene, steps * step), scene, tmp_path)
    words = f"({abs(steps):.3g} of a step) {'later' if steps > 0 else 'earlier'}"
    only_cause(study, "time offset", NOTHING, words)


@pytest.mark.parametrize(
    ("scene", "factor", "slip"),
    [(SAW, 1e3, "mm taken for m"), (PRESS, 1e-3, "m taken for mm"), (SAW, 1.0 / 0.0254, "inches taken for m")],
)
def test_a_length_in_another_unit_is_named(scene: Scene, factor: float, slip: str, tmp_path: Path) -> None:
    table = {n: c * factor if "." in n else c for n, c in exact_table(scene, ALL).items()}
    only_cause(judged(table, scene, tmp_path), "length unit", NOTHING, slip)


@pytest.mark.parametrize(
    ("scene", "factor", "slip"),
    [
        (SAW, 180.0 / math.pi, "degrees taken for radians"),
        (PRESS, math.pi / 180.0, "radians taken for degrees"),
        (SAW, 0.5 / math.pi, "turns taken for radians"),
    ],
)
def test_an_angle_in_another_unit_is_named(scene: Scene, factor: float, slip: str, tmp_path: Path) -> None:
    table = exact_table(scene, crank=True)
    table["crank_angle"] = table["crank_angle"] * factor
    only_cause(judged(table, scene, tmp_path), "angle unit", ("position",), slip)


@pytest.mark.parametrize("scene", SCENES)
def test_a_speed_in_degrees_is_named(scene: Scene, tmp_path: Path) -> None:
    table = exact_table(scene)
    slow = scene.motion(math.radians(scene.speed) * table["time"], scene.speed)
    for point in scene.lengths:
        table[f"{point}.x"], table[f"{point}.y"] = slow.point(point).position.T
    only_cause(judged(table, scene, tmp_path), "speed unit", ("total", "position"), "rad/s taken for deg/s")


@pytest.mark.parametrize("scene", SCENES)
def test_the_opposite_sense_is_named(scene: Scene, tmp_path: Path) -> None:
    table = exact_table(scene.with_parameters(speed=-scene.speed), ALL)
    only_cause(judged(table, scene, tmp_path), "opposite sense", NOTHING, "opposite sense")


@pytest.mark.parametrize("scene", SCENES)
def test_swapped_axes_are_named(scene: Scene, tmp_path: Path) -> None:
    table = exact_table(scene, ALL)
    for name in list(table):
        if name.endswith("x"):
            other = f"{name[:-1]}y"
            table[name], table[other] = table[other], table[name]
    only_cause(judged(table, scene, tmp_path), "axes swapped", NOTHING, "x and y are swapped")


@pytest.mark.parametrize(("scene", "steps"), [(SAW, 0.5), (PRESS, -0.5)])
def test_velocities_stamped_half_a_step_off_are_named(scene: Scene, steps: float, tmp_path: Path) -> None:
    study = judged(later(scene, steps * scene.period / ROWS, ("velocity",)), scene, tmp_path)
    words = f"(0.5 of a step) {'later' if steps > 0 else 'earlier'}"
    only_cause(study, "velocity stamp", ("velocity",), words)


@pytest.mark.parametrize(("scene", "upward"), [(SAW, 9.81), (PRESS, -9.80665)])
def test_gravity_left_in_an_acceleration_is_named(scene: Scene, upward: float, tmp_path: Path) -> None:
    table = exact_table(scene, ALL)
    for point in scene.lengths:
        table[f"{point}.ay"] = table[f"{point}.ay"] + upward
    study = judged(table, scene, tmp_path)
    only_cause(study, "gravity", ("acceleration",), f"{math.copysign(90.0, upward):.0f} deg from x")


def test_another_constant_in_an_acceleration_is_not_gravity(tmp_path: Path) -> None:
    table = exact_table(SCENES[0], ALL)
    for point in SCENES[0].lengths:
        table[f"{point}.ay"] = table[f"{point}.ay"] + 7.0
    assert kinds(judged(table, SCENES[0], tmp_path)) == []


@pytest.mark.parametrize("scene", SCENES)
def test_an_offset_of_the_frame_is_named(scene: Scene, tmp_path: Path) -> None:
    table = exact_table(scene, ALL)
    for point in scene.lengths:
        table[f"{point}.x"] = table[f"{point}.x"] + 0.25
    only_cause(judged(table, scene, tmp_path), "frame", ("total", "position"), "offset by (250, ")


@pytest.mark.parametrize("scene", SCENES)
def test_another_zero_of_the_crank_is_named(scene: Scene, tmp_path: Path) -> None:
    table = exact_table(scene, ALL, crank=True)
    table["crank_angle"] = table["crank_angle"] - math.radians(30.0)
    only_cause(judged(table, scene, tmp_path), "crank zero", ALL, "0 where the scene's is 30 deg")


# -- negative controls -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("plant", ["longer rod", "noise", "drift", "one row"])
def test_what_no_slip_reproduces_is_not_explained(scene: Scene, plant: str, tmp_path: Path) -> None:
    table = exact_table(scene)
    size = 1e-3 * min(scene.lengths.values())
    if plant == "longer rod":
        motion = synthetic_trajectory(scene, longer_rod(scene))
        track = {point: tracks.position for point, tracks in motion.points.items()}
        table = {"time": next(iter(track.values())).instants.times}
        for point, own in track.items():
            table |= {f"{point}.x": own.values[:, 0], f"{point}.y": own.values[:, 1]}
    for point in scene.lengths if plant != "longer rod" else ():
        count = len(table["time"])
        noise = {
            "noise": np.random.default_rng(3).normal(size=count),
            "drift": np.linspace(0.0, 1.0, count),
            "one row": np.eye(1, count, 100)[0],
        }[plant]
        table[f"{point}.x"] = table[f"{point}.x"] + size * noise
    study = judged(table, scene, tmp_path)
    assert (study.largest("total") or 0.0) > 1e-5
    assert kinds(study) == []


def test_where_one_slip_explains_all_a_poorer_one_is_not_named(tmp_path: Path) -> None:
    # Lengths so small stand all but still, and so they do where the crank hardly turns.
    scene = Saw(speed=20.0)
    table = exact_table(scene)
    table = {name: table[name] * (1.0 if name == "time" else 1e-3) for name in ("time", "C.x", "C.y")}
    only_cause(judged(table, scene, tmp_path), "length unit", ("total", "position"), "m taken for mm")


def test_half_an_explanation_is_none(tmp_path: Path) -> None:
    # A frame that is off and a rod that is too long: the offset takes much of the difference away, not all.
    scene = SCENES[0]
    motion = synthetic_trajectory(scene, longer_rod(scene))
    table: Columns = {}
    for point, tracks in motion.points.items():
        table["time"] = tracks.position.instants.times
        for k, axis in enumerate("xy"):
            table[f"{point}.{axis}"] = tracks.position.values[:, k] + 2e-4 * scene.lengths[point] * (1 - k)
    study = judged(table, scene, tmp_path)
    assert kinds(study) == []


def test_within_tolerance_nobody_asks_why(tmp_path: Path) -> None:
    scene = SCENES[0]
    table = later(scene, 0.3 * scene.period / ROWS)
    loose, strict = {"position": 0.1}, {"position": 1e-6}
    assert judged(table, scene, tmp_path, tolerance=loose).causes == ()
    assert kinds(judged(table, scene, tmp_path, tolerance=strict)) == ["time offset"]
