"""Closed loops and free motion with a baseline: the same run is no drift, another one is."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mujoco
import pytest
from four_bars import four_bar

from conrod import InvalidInput, check_loops, free_motion
from conrod.execution.baseline import SPEED_FACTORS, read_baseline
from conrod.execution.runner import Runs

pytestmark = pytest.mark.usefixtures("at_once")
LAW = {"crank": "60rpm"}


@pytest.fixture(autouse=True)
def few_short_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
    monkeypatch.setattr("conrod.models.loops.study.FINER", ())
    monkeypatch.setattr("conrod.models.loops.study.COARSER", (2,))
    # Four take four times as long.
    monkeypatch.setattr("conrod.execution.baseline.SPEED_FACTORS", SPEED_FACTORS[:1])
    monkeypatch.setattr("conrod.studies.free_motion.api.STEP_FACTORS", SPEED_FACTORS[:1])


def judged(file: Path, text: str = four_bar(), **words: Any) -> Any:
    found = check_loops(mujoco.MjModel.from_xml_string(text), drives=LAW, seconds=0.02, baseline=file, **words)
    assert found.baseline is not None
    return found.baseline


def test_driven_loops_keep_to_their_baseline_or_drift(tmp_path: Path) -> None:
    file = tmp_path / "bar.json"
    assert judged(file).written
    assert judged(file).text == ""
    kept = read_baseline(file)
    assert kept.of["drive"] == ["crank=60rpm"]
    assert list(kept.results) == ["kinematics", "its own run", "driven, as it is", "driven, tuned", "driven, hardened"]
    # Negative control: another integrator makes other errors, and another drive is another request.
    other = four_bar().replace('timestep="0.001"', 'timestep="0.001" integrator="RK4"')
    assert other != four_bar()
    drifted = judged(file, other)
    assert not drifted.passed
    assert {"its own run", "driven, as it is"} <= {drift.result for drift in drifted.drifts}
    with pytest.raises(InvalidInput, match=r"the baseline is of something else: drive \[\"crank=60rpm\"\]"):
        check_loops(mujoco.MjModel.from_xml_string(four_bar()), drives={"crank": "50rpm"}, baseline=file)


@pytest.mark.slow
def test_own_run_that_goes_elsewhere_is_a_drift(tmp_path: Path) -> None:
    # Loops open as they did, to the last digits; the motor of the newer model is a thousandth stronger.
    def model(gear: float) -> str:
        motor = f'<actuator><motor name="motor" joint="crank" gear="{gear}"/></actuator>'
        return four_bar().replace("</mujoco>", f"{motor}</mujoco>")

    file = tmp_path / "bar.json"
    assert judged(file, model(0.1), controls={"motor": 1.0}).written
    assert judged(file, model(0.1), controls={"motor": 1.0}).text == ""
    drifts = judged(file, model(0.1001), controls={"motor": 1.0}).drifts
    (path,) = [drift for drift in drifts if drift.what == "path"]
    assert (path.result, path.better) == ("its own run", None)
    # A baseline that was written before paths were kept has none, and holds.
    values = json.loads(file.read_bytes())
    del values["results"]["its own run"]["numbers"]["path"]
    file.write_text(json.dumps(values), encoding="utf-8")
    assert judged(file, model(0.1), controls={"motor": 1.0}).passed


def test_free_motion_keeps_to_its_baseline_or_drifts(tmp_path: Path) -> None:
    file = tmp_path / "pendulum.json"

    def free() -> Any:
        runs = Runs(ledger=tmp_path / "ledger.sqlite", jobs=1)
        words: dict[str, Any] = {"engines": "mujoco", "preset": "hardened", "seconds": 0.1, "step": 1e-3}
        return free_motion("pendulum", **words, baseline=file, runs=runs).baseline

    assert free().written
    assert free().text == ""
    # Negative control: the same run against a number that is ten bands off.
    values = json.loads(file.read_bytes())
    number = values["results"]["mujoco hardened"]["numbers"]["energy"]
    number["value"] += 10.0 * number["band"] + 1e-11
    file.write_text(json.dumps(values), encoding="utf-8")
    drifted = free()
    assert (drifted.passed, drifted.drifts[0].what) == (False, "energy")
