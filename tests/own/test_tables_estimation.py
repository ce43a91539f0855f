"""What is unknown of a table is worked out where asked for, with its standard error; what cannot be told is said."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from table_files import Columns, exact_table, judged

from conrod import InvalidInput
from conrod.own.tables.estimation import Estimation, estimate, parse_estimate
from conrod.own.tables.samples import Observed, Samples
from conrod.own.tables.study import TableStudy
from conrod.scenes import SCENES, CamFollower, Saw, Scene, ShearPress

TURN = 2.0 * math.pi
LINKAGES = [Saw(speed=20.0), ShearPress(speed=-5.0)]


def moved(table: Columns, offset: tuple[float, float], rotation: float) -> Columns:
    """Positions as another frame has them."""
    c, s = math.cos(rotation), math.sin(rotation)
    other = dict(table)
    for point in {name.split(".")[0] for name in table if name.endswith(".x")}:
        x, y = table[f"{point}.x"], table[f"{point}.y"]
        other[f"{point}.x"], other[f"{point}.y"] = c * x - s * y + offset[0], s * x + c * y + offset[1]
    return other


def estimated(study: TableStudy) -> Estimation:
    assert study.estimation is not None
    return study.estimation


def values(study: TableStudy) -> dict[str, float]:
    return {one.name: one.value for one in estimated(study).estimates}


@pytest.mark.parametrize(
    ("name", "share"), [("saw-500rpm", 0.37), ("cam-follower", 0.37), ("shear-press", -0.004), ("saw-40rpm", 1e-7)]
)
def test_a_time_offset_is_found(name: str, share: float, tmp_path: Path) -> None:
    scene = SCENES[name]
    table = exact_table(scene)
    table["time"] = table["time"] + share * scene.period
    study = judged(table, scene, tmp_path, ["time"])
    assert values(study)["time"] == pytest.approx(share * scene.period, rel=1e-7, abs=1e-14 * scene.period)
    assert (study.largest("total") or 0.0) < 1e-11
    # Negative control: it is not taken off unasked.
    assert (judged(table, scene, tmp_path).largest("total") or 0.0) > 1e-8


@pytest.mark.parametrize("scene", LINKAGES)
def test_sense_phase_and_frame_are_found_together(scene: Scene, tmp_path: Path) -> None:
    table = exact_table(scene)
    motion = scene.motion(-scene.speed * table["time"] + 1.1, -scene.speed)
    for point in scene.lengths:
        table[f"{point}.x"], table[f"{point}.y"] = motion.point(point).position.T
    offset, rotation = (0.25, -0.04), 2.2
    study = judged(moved(table, offset, rotation), scene, tmp_path, ["phase", "sense", "frame"])
    sense = estimated(study).sense
    assert sense is not None
    assert sense[0] == -1
    assert sense[2] > 0.01
    expected = {"phase": 1.1, "x": offset[0], "y": offset[1], "rotation": rotation}
    assert values(study) == pytest.approx(expected, abs=1e-10)
    assert (study.largest("total") or 0.0) < 1e-11


def test_the_sense_of_a_symmetric_cam_cannot_be_told(tmp_path: Path) -> None:
    scene = CamFollower()
    estimation = estimated(judged(exact_table(scene), scene, tmp_path, ["sense"]))
    assert estimation.sense is None
    assert any("sense cannot be determined" in text for text in estimation.undetermined)


@pytest.mark.parametrize("asked", [["time", "phase"], ["phase", "time"]])
def test_time_and_phase_cannot_be_told_apart_at_constant_speed(asked: list[str], tmp_path: Path) -> None:
    scene = Saw(speed=20.0)
    table = exact_table(scene)
    table["time"] = table["time"] - 0.003
    study = judged(table, scene, tmp_path, asked)
    assert values(study) == {asked[0]: pytest.approx(-0.003 if asked[0] == "time" else 0.06, rel=1e-9)}
    assert estimated(study).undetermined == (
        f"time and phase cannot be separated at constant speed: {asked[0]} stands for both, {asked[1]} is kept at 0",
    )


def test_with_a_crank_angle_the_clock_and_the_crank_are_told_apart(tmp_path: Path) -> None:
    scene = Saw(speed=20.0)
    table = exact_table(scene, crank=True)
    # The encoder's zero is 0.3 rad ahead of the scene's, and its clock 2 ms.
    table["crank_angle"] = table["crank_angle"] - 0.3
    table["time"] = table["time"] + 0.002
    study = judged(table, scene, tmp_path, ["time", "phase"])
    assert values(study) == {"zero": pytest.approx(0.3, abs=1e-12), "time": pytest.approx(0.002, abs=1e-13)}
    assert (study.largest("total") or 0.0) < 1e-11
    assert (study.largest("position") or 0.0) < 1e-11


def test_of_one_component_along_a_line_no_rotation_can_be_told(tmp_path: Path) -> None:
    scene = Saw(speed=20.0)
    table = exact_table(scene)
    study = judged({name: table[name] for name in ("time", "C.x")}, scene, tmp_path, ["frame"])
    # x of a point that moves along x tells of an offset in x alone.
    assert list(values(study)) == ["x"]
    assert len(estimated(study).undetermined) == 2
    assert all("cannot be determined" in text for text in estimated(study).undetermined)


def test_an_encoder_log_tells_its_time_offset(tmp_path: Path) -> None:
    scene = Saw(speed=5.0)
    times = np.linspace(0.0, 3.0, 300)
    table = {"time": times, "crank_angle": np.mod(5.0 * (times - 0.05), TURN)}
    study = judged(table, scene, tmp_path, ["time"])
    assert values(study)["time"] == pytest.approx(0.05, abs=1e-12)
    assert (study.largest("phase") or 0.0) < 1e-12
    with pytest.raises(InvalidInput, match="--estimate frame: the table has no positions"):
        judged(table, scene, tmp_path, ["frame"])


def test_standard_errors_are_the_scatter_of_estimates() -> None:
    scene = Saw(speed=20.0)
    generator = np.random.default_rng(20)
    times = np.arange(0.0, 2.0 * scene.period, scene.period / 30)
    motion = scene.reference(times)
    noise = 1e-3
    found, told = [], []
    for _ in range(40):
        points = {}
        for name, length in scene.lengths.items():
            exact = motion.point(name).position + np.array([0.01, -0.02])
            points[name] = {"position": Samples(exact + noise * length * generator.normal(size=exact.shape), (0, 1))}
        estimation = estimate(Observed(times + 0.01, None, None, None, points), scene, ["time", "frame"])
        found.append([one.value for one in estimation.estimates])
        told.append([one.error for one in estimation.estimates])
        assert estimation.remaining == pytest.approx(noise * math.sqrt(2.0), rel=0.2)
    names = [one.name for one in estimation.estimates]
    assert names == ["time", "x", "y", "rotation"]
    truth = np.array([0.01, 0.01, -0.02, 0.0])
    error = np.mean(told, axis=0)
    # Of 40 estimates the scatter is known to 1/sqrt(78) = 11 %, their mean to 1/sqrt(40) = 16 % of it.
    assert np.std(found, axis=0) == pytest.approx(error, rel=0.35)
    assert np.all(np.abs(np.mean(found, axis=0) - truth) < 4.0 * error / math.sqrt(40.0))


def test_what_is_asked_for_is_checked_and_too_few_rows_are_refused(tmp_path: Path) -> None:
    assert parse_estimate("time, frame,time") == ("time", "frame")
    with pytest.raises(InvalidInput, match="'fase': did you mean 'frame' or 'phase'"):
        parse_estimate("fase")
    scene = CamFollower()
    table = {name: column[:2] for name, column in exact_table(scene).items()}
    with pytest.raises(InvalidInput, match="4 numbers are too few to estimate time, x, y, rotation from"):
        judged(table, scene, tmp_path, ["time", "frame"])
