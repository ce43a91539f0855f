"""Sweeps, recommendations, limits and exports take mechanism files where they take scenes."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from command_line import conrod
from described import CATALOGUE, changed

from conrod.engines import engine_named
from conrod.engines.mujoco.standalone import standalone_mjcf
from conrod.scenes.catalogue import catalogue_scene
from conrod.scenes.described_scene import DescribedScene, scene_of
from conrod.studies.ablate.study import COMPARED, change
from conrod.studies.frame.run import LEAST_STEPS, RunCase, as_run, measure
from conrod.studies.frame.timing import time_run
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.case import Setup
from conrod.studies.limits.stream_run import stream_run

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


def test_ingredients_of_a_pass_are_looked_at_in_the_pass() -> None:
    scene, settings = read(PASS), cell(read(PASS)).settings
    coarse, fine = (
        measure(RunCase("a", scene, one, signed_angles=COMPARED)) for one in (settings, cell(read(PASS), 400).settings)
    )
    assert coarse.outcome == "completed"
    assert (coarse.largest("total") or 1.0) < 0.01
    assert change(coarse, coarse) == {"position": 0.0, "velocity": 0.0, "acceleration": 0.0}
    # Negative control: twice the steps in a revolution make another motion, over the same pass.
    other = change(coarse, fine)
    assert other is not None
    assert 0.0 < other["position"] < 0.01


def test_the_steps_of_a_pass_are_walked_to_where_it_has_three() -> None:
    for axis in (AXES["steps"], AXES["speed"]):
        case = Setup("a", read(PASS), "pymunk", "tuned")
        ((_, last),) = axis.spans(case)
        coarsest = axis.case(case, last)
        assert round(as_run(coarsest).revolutions * coarsest.settings.steps_per_revolution) == LEAST_STEPS
        assert stream_run(coarsest).outcome != "unsupported"
        # Negative control: of what turns, two steps in a turn are run.
        ((_, last),) = axis.spans(Setup("a", read(TURNS), "pymunk", "tuned"))
        assert axis.case(Setup("a", read(TURNS), "pymunk", "tuned"), last).settings.steps_per_revolution == 2


@pytest.mark.parametrize("path", [PASS, TURNS, CATALOGUE / "inverted-slider-crank.toml"])
def test_an_exported_model_runs_on_its_own(path: Path) -> None:
    scene = read(path)
    model = mujoco.MjModel.from_xml_string(standalone_mjcf(path.stem, scene))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    run = as_run(cell(scene, round(scene.period / model.opt.timestep)))
    places = []
    for _ in range(round(run.revolutions * run.settings.steps_per_revolution) + 1):
        mujoco.mj_kinematics(model, data)
        places.append(data.site(scene.output).xpos[:2].copy())
        mujoco.mj_step(model, data)
    angle = run.start_angle + scene.speed * model.opt.timestep * np.arange(len(places))
    exact = scene.motion(np.clip(angle, *scene.kinematics.span) if scene.span else angle, scene.speed)
    off = np.linalg.norm(np.array(places) - exact.point(scene.output).position, axis=1).max()
    assert off < 1e-5 * scene.lengths[scene.output]


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
    shown = conrod("results", "--ledger", str(ledger), "--where", "scene = 'another'").stdout
    assert len(shown.splitlines()) <= 1
    longer = catalogue_scene(PASS.stem)
    name = next(name for name in longer.parameters if name.endswith("mass"))
    other = longer.with_parameters(**{name: 1.01 * longer.parameters[name]})
    assert cell(other).key != cell(longer).key
