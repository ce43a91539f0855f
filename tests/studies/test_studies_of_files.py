"""Sweeps, recommendations, limits and exports take mechanism files where they take scenes."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import conrod
from described import CATALOGUE, changed

from conrod.engines import engine_named
from conrod.scenes import catalogue_scene
from conrod.scenes.described_scene import DescribedScene, scene_of
from conrod.studies.frame.run import RunCase, as_run, measure
from conrod.studies.frame.timing import time_run

PASS, TURNS = CATALOGUE / "swinging-four-bar.toml", CATALOGUE / "slider-crank.toml"


def read(path: Path, place: str = "", value: Any = None) -> DescribedScene:
    return scene_of(changed(path, place, value)) if place else catalogue_scene(path.stem)


def cell(scene: DescribedScene, steps: int = 200, engine: str = "mujoco", preset: str = "tuned") -> RunCase:
    return RunCase(scene.kind, scene, engine_named(engine).presets[preset](scene, steps))


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_what_is_run_of_a_pass_is_the_pass(engine: str) -> None:
    asked = cell(read(PASS), engine=engine)
    run, span = as_run(asked), asked.scene.kinematics.span
    assert run.start_angle == span[0]
    assert run.revolutions == pytest.approx((span[1] - span[0]) / (2.0 * np.pi), abs=1.0 / 200)
    measured = measure(asked)
    assert measured.outcome == "completed"
    assert (measured.largest("position") or 1.0) < 0.01
    # Negative control: what turns is run as it was asked for.
    turning = cell(read(TURNS))
    assert as_run(turning) is turning


def test_a_cost_is_that_of_steps_within_the_pass() -> None:
    scene, engine = read(PASS), engine_named("pymunk")
    settings = engine.presets["tuned"](scene, 200)
    made: list[int] = []

    class Counting:
        def __init__(self) -> None:
            self.place = len(made)
            made.append(0)

        def __call__(self, steps: int) -> None:
            made[self.place] += steps

    class Fake:
        def stepper(self, *_: object) -> Counting:
            return Counting()

        def reference_loop(self) -> Any:
            return lambda _: None

    ticks = iter(range(0, 10**12, 1_000_000))
    timed = time_run(Fake(), scene, settings, clock=lambda: next(ticks))  # type: ignore[arg-type]  # a stand-in
    assert timed is not None
    assert max(made) <= as_run(cell(scene)).revolutions * 200 + 0.5
    # Negative control: a machine that turns goes on and on.
    made.clear()
    time_run(Fake(), read(TURNS), replace(settings), clock=lambda: next(ticks))  # type: ignore[arg-type]
    assert max(made) > 200


@pytest.mark.slow
def test_a_sweep_of_a_file_goes_on_and_an_edited_file_is_another_machine(tmp_path: Path) -> None:
    path, ledger = tmp_path / "own.toml", tmp_path / "ledger.db"
    text = PASS.read_text(encoding="utf-8")
    path.write_text(text.replace('name = "swinging-four-bar"', 'name = "own"'), encoding="utf-8")
    sweep = ("sweep", str(path), "--grid", "coarse", "--engine", "pymunk", "--jobs", "1")
    first, again = conrod(*sweep, ledger=ledger), conrod(*sweep, ledger=ledger)
    assert (first.returncode, again.returncode) == (0, 0), first.stderr
    assert "runs: 0 to do" in again.stderr
    assert "runs: 0 to do" not in first.stderr
    # The same machine in other words is the same; another length is another one.
    path.write_text(path.read_text(encoding="utf-8").replace('title = "', 'title = "My '), encoding="utf-8")
    assert "runs: 0 to do" in conrod(*sweep, ledger=ledger).stderr
    found = conrod("results", "--ledger", str(ledger))
    rows = list(csv.DictReader(io.StringIO(found.stdout)))
    assert rows
    assert {row["scene"] for row in rows} == {"own"}
    assert all('"bodies"' in row["parameter.mechanism"] for row in rows)
    longer = catalogue_scene(PASS.stem)
    name = next(name for name in longer.parameters if name.endswith("mass"))
    other = longer.with_parameters(**{name: 1.01 * longer.parameters[name]})
    assert cell(other).key != cell(longer).key
