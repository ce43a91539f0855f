"""What is unknown of a table is worked out where asked for, with its standard error; what cannot be told is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from table_files import Columns, exact_table, judged

from conrod import InvalidInput
from conrod.own.tables.estimation import estimate, parse_estimate
from conrod.own.tables.samples import Observed, Samples
from conrod.own.tables.study import TableStudy
from conrod.scenes import SCENES, CamFollower, Saw, Scene, ShearPress

TURN = 2.0 * math.pi


def values(study: TableStudy) -> dict[str, float]:
    assert study.estimation is not None
    return {one.name: one.value for one in study.estimation.estimates}


@pytest.mark.parametrize(("name", "share"), [("saw-500rpm", 0.37), ("cam-follower", 0.37), ("saw-40rpm", 1e-7)])
def test_a_time_offset_is_found(name: str, share: float, tmp_path: Path) -> None:
    scene = SCENES[name]
    table = exact_table(scene)
    table["time"] = table["time"] + share * scene.period
    study = judged(table, scene, tmp_path, ["time"])
    assert values(study)["time"] == pytest.approx(share * scene.period, rel=1e-7, abs=1e-14 * scene.period)
    assert (study.largest("total") or 0.0) < 1e-11
    # Negative control: it is not taken off unasked.
    assert (judged(table, scene, tmp_path).largest("total") or 0.0) > 1e-8


@pytest.mark.parametrize("scene", [Saw(speed=20.0), ShearPress(speed=-5.0)])
def test_a_phase_is_found(scene: Scene, tmp_path: Path) -> None:
    table = exact_table(scene)
    motion = scene.motion(scene.speed * table["time"] + 1.1, scene.speed)
    for point in scene.lengths:
        table[f"{point}.x"], table[f"{point}.y"] = motion.point(point).position.T
    study = judged(table, scene, tmp_path, ["phase"])
    assert values(study) == {"phase": pytest.approx(1.1, abs=1e-12)}
    assert (study.largest("total") or 0.0) < 1e-11


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


def test_an_encoder_log_tells_its_time_offset(tmp_path: Path) -> None:
    scene = Saw(speed=5.0)
    times = np.linspace(0.0, 3.0, 300)
    table = {"time": times, "crank_angle": np.mod(5.0 * (times - 0.05), TURN)}
    study = judged(table, scene, tmp_path, ["time"])
    assert values(study)["time"] == pytest.approx(0.05, abs=1e-12)
    assert (study.largest("phase") or 0.0) < 1e-12


def test_standard_errors_are_the_scatter_of_estimates() -> None:
    scene = Saw(speed=20.0)
    generator, noise = np.random.default_rng(20), 1e-3
    times = np.arange(0.0, 2.0 * scene.period, scene.period / 30)
    motion = scene.reference(times)
    found, told = [], []
    for _ in range(40):
        points = {}
        for name, length in scene.lengths.items():
            exact = motion.point(name).position
            points[name] = {"position": Samples(exact + noise * length * generator.normal(size=exact.shape), (0, 1))}
        estimation = estimate(Observed(times + 0.01, None, None, None, points), scene, ["time"])
        found.append(estimation.estimates[0].value)
        told.append(estimation.estimates[0].error)
        assert estimation.remaining == pytest.approx(noise * math.sqrt(2.0), rel=0.2)
    error = np.mean(told)
    # Of 40 estimates the scatter is known to 1/sqrt(78) = 11 %, their mean to 1/sqrt(40) = 16 % of it.
    assert np.std(found) == pytest.approx(error, rel=0.35)
    assert abs(np.mean(found) - 0.01) < 4.0 * error / math.sqrt(40.0)


def only(table: Columns, *names: str) -> Columns:
    return {name: table[name] for name in names}


def test_what_cannot_be_told_is_refused(tmp_path: Path) -> None:
    assert parse_estimate("time, phase,time") == ("time", "phase")
    with pytest.raises(InvalidInput, match="'fase': did you mean 'phase'"):
        parse_estimate("fase")
    scene = CamFollower()
    table = exact_table(scene)
    with pytest.raises(InvalidInput, match="at constant speed one looks like the other"):
        judged(table, scene, tmp_path, ["time", "phase"])
    # A follower that moves along y tells nothing by its x.
    with pytest.raises(InvalidInput, match="time cannot be determined: nothing in this table depends on it"):
        judged(only(table, "time", "roller.x"), scene, tmp_path, ["time"])
    speed = {"time": table["time"], "crank_speed": table["time"]}
    with pytest.raises(InvalidInput, match="the table has no positions"):
        judged(speed, scene, tmp_path, ["time"])
