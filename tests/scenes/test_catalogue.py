"""The catalogue: machines that ship as files are first-class scenes, from their names to a page in a report."""

from __future__ import annotations

import itertools
import runpy
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

from conrod.engines import ENGINES, engine_named
from conrod.errors import InvalidInput
from conrod.execution.resolve_arguments import arguments_of_files, select_scene, select_scenes
from conrod.execution.result import Plan
from conrod.scenes import (
    CHAIN,
    SCENES,
    catalogue_names,
    catalogue_scene,
    catalogue_tables,
    catalogue_text,
    dynamics_names,
    scene_named,
)
from conrod.studies.validation.kinematic_mode import validate_kinematic
from conrod.studies.validation.study import validation_study

NAMES = catalogue_names()
QUICK_MACHINES = ("slider-crank", "swinging-four-bar")


def test_machine_has_the_name_of_its_file() -> None:
    assert NAMES
    assert {name: catalogue_tables(name)["name"] for name in NAMES} == {n: n for n in NAMES}
    assert not set(NAMES) & set(SCENES)


def test_every_machine_states_source_and_assumptions() -> None:
    for name in NAMES:
        tables = catalogue_tables(name)
        assert tables["title"]
        assert tables["source"]
        assert tables["assumptions"], name
        assert all(isinstance(text, str) and text.strip() for text in tables["assumptions"])


@pytest.mark.parametrize("name", NAMES)
def test_every_machine_makes_its_turn_or_pass(name: str) -> None:
    scene = catalogue_scene(name)
    assert scene.kind == name
    angles = np.linspace(*scene.kinematics.span, 37)
    assert all(np.isfinite(p.position).all() for p in scene.motion(angles, scene.speed).points.values())


def test_scene_named_finds_shipped_names_and_suggests_nearest() -> None:
    assert scene_named("slider-crank") is catalogue_scene("slider-crank")
    assert scene_named("saw-40rpm") is SCENES["saw-40rpm"]
    with pytest.raises(InvalidInput, match=r"did you mean 'slider-crank'.*all: conrod show"):
        scene_named("slidercrank")


def test_word_catalogue_means_all_machines() -> None:
    assert list(select_scenes(["catalogue"], [])) == list(NAMES)
    with pytest.raises(InvalidInput, match="stands for many machines"):
        select_scene("catalogue", [])


def test_changed_copy_may_not_run_beside_its_original(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text(catalogue_text("slider-crank").replace("560 mm", "600 mm"))
    alone = select_scenes([str(own)], [])["slider-crank"]
    assert alone.parameters_text != catalogue_scene("slider-crank").parameters_text
    assert arguments_of_files([str(own), "saw-40rpm"]) == {"slider-crank": str(own)}
    for both in itertools.permutations([str(own), "slider-crank"]):
        with pytest.raises(InvalidInput, match=r"own\.toml.*another"):
            select_scenes(both, [])


def test_catalogue_page_matches_its_files() -> None:
    docs = Path(__file__).parents[2] / "docs"
    page = runpy.run_path(str(docs / "catalogue.py"))["page"]
    assert (docs / "catalogue.md").read_text(encoding="utf-8") == page(), "python docs/catalogue.py > docs/catalogue.md"


@pytest.mark.slow
def test_wheel_contains_mechanism_files(tmp_path: Path) -> None:
    import subprocess
    import sys

    root = Path(__file__).parents[2]
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path), str(root)]
    subprocess.run(build, check=True, capture_output=True)
    (wheel,) = tmp_path.glob(f"conrod-{version('conrod')}-*.whl")
    inside = zipfile.ZipFile(wheel).namelist()
    assert {f"conrod/scenes/catalogue/{name}.toml" for name in NAMES} <= set(inside)
    files = {name for name in dynamics_names() if not name.startswith(CHAIN)}
    assert {f"conrod/scenes/dynamics/{name}.toml" for name in files} <= set(inside)
    assert {str(file.relative_to(root / "src")) for file in (root / "src").rglob("*.jinja")} <= set(inside)


def check_met(name: str, engine: str, presets: tuple[str, ...], plan: Plan) -> None:
    for case in next(validation_study({name: catalogue_scene(name)}, [engine_named(engine)], {engine: presets}, plan)):
        result = case.perform()
        assert result.passed is not False, (name, engine, case.preset, result.reason, result.out_of_tolerance())
        assert result.outcome != "unsupported" or result.reason


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", QUICK_MACHINES)
def test_few_machines_meet_tolerances_with_few_steps(name: str, engine: str) -> None:
    check_met(name, engine, ("tuned",), Plan(200, 1.0))


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", NAMES)
def test_every_machine_meets_tolerances_or_is_refused(name: str, engine: str) -> None:
    check_met(name, engine, tuple(engine_named(engine).presets), Plan())


@pytest.mark.parametrize("engine", ENGINES)
def test_kinematic_mode_detects_wrong_length(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, judged = catalogue_scene("slider-crank"), engine_named(engine)
    longer, solve = scene.with_parameters(**{"bodies.rod.points.B.x": 0.56 * 1.0001}), judged.solve_kinematics
    assert validate_kinematic("slider-crank", scene, judged).passed
    monkeypatch.setattr(judged, "solve_kinematics", lambda _, angle: solve(longer, angle))
    found = validate_kinematic("slider-crank", scene, judged)
    assert found.passed is False
    assert (found.largest("position") or 0.0) > 1e-5
