"""Reports of any kind: saved findings, folders that lose nobody's files, pages rendered again without an engine."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from committed_studies import ablation_study, limit_study
from handmade import handmade_sweep

from conrod.errors import InvalidInput
from conrod.execution.resolve_arguments import select_scenes
from conrod.execution.writing import write_together
from conrod.report.folder import ReportFolder, plain_findings, restore_findings
from conrod.report.kind import Reproduction, kind_named
from conrod.report.subreports import subreports
from conrod.report.table import ColouredCell, table
from conrod.report.template import table_text
from conrod.report.writer import render_again, report_batch
from conrod.scenes import SCENES, Scene
from conrod.studies.free_motion.report import FREE_MOTION_REPORT
from conrod.studies.free_motion.results import ExactSummary, MotionCurves, MotionResult, MotionStudy

COMMAND = Reproduction("conrod free {scene} --out reports")
BLOCKED = """
import sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("mujoco", "pymunk"):
            raise ImportError(f"{name} is not installed here")
sys.meta_path.insert(0, Blocked())
from conrod.__main__ import main
sys.argv = ["conrod", *sys.argv[1:]]
main()
"""


def study(name: str, error: float = 1e-9, curves: bool = True) -> MotionStudy:
    """Free motion that no engine made."""
    times = np.linspace(0.0, 1.0, 50)
    drawn = MotionCurves(times, np.full(50, error), np.full(50, error))
    sizes = {"max": error, "rms": error / 3.0, "final": error}
    scene = SCENES.get(name, SCENES["saw-40rpm"])
    result = MotionResult(
        scene=name, motion="free", engine="mujoco", engine_version="4.0.0", preset="hardened", step=1e-3, seconds=1.0,
        exact=ExactSummary(1e-13, "", 1.0),
        leaving=1e-6, tolerance={"position": 1e-8}, errors={scene.output: sizes}, energy=sizes,
        curves=drawn if curves else None, passed=True,
    )  # fmt: skip
    return MotionStudy(name, scene, (result,), "free", ())


def write(folder: Path, *studies: MotionStudy) -> None:
    write_together([report_batch(FREE_MOTION_REPORT, {s.name: s for s in studies}, folder, COMMAND)])


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


# -- findings --------------------------------------------------------------------------------------------------------


def test_findings_come_back_as_they_were_saved() -> None:
    one = study("saw-40rpm")
    back = restore_findings(MotionStudy, json.loads(json.dumps(plain_findings(one))))
    assert back.scene == one.scene
    assert back.results[0].errors == one.results[0].errors
    np.testing.assert_allclose(back.results[0].curves.error, np.full(50, 1e-9), rtol=1e-6)
    assert plain_findings(back) == plain_findings(one)


@pytest.mark.parametrize("name", ["cam-follower", "pendulum"])
def test_saved_scene_comes_back_with_its_parameters(name: str) -> None:
    scene = select_scenes([name], [])[name]
    assert restore_findings(Scene, json.loads(json.dumps(plain_findings(scene)))) == scene


def test_unfitting_or_unsavable_findings_are_refused() -> None:
    with pytest.raises(InvalidInput, match="do not fit MotionStudy"):
        restore_findings(MotionStudy, {"name": "x"})
    with pytest.raises(TypeError, match="is not plain"):
        plain_findings(lambda: None)


FINDINGS = {"sweep": handmade_sweep, "ablate": ablation_study, "limits": limit_study}


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("kind", FINDINGS)
def test_saved_findings_render_the_same_and_stay_beside_others(kind: str, tmp_path: Path) -> None:
    found: Any = FINDINGS[kind]()
    assert restore_findings(type(found), json.loads(json.dumps(plain_findings(found)))) == found
    batch = report_batch(kind_named(kind), {found.name: found}, tmp_path, COMMAND)
    write_together([batch])
    (again,) = render_again(tmp_path)
    assert again.files == batch.files
    # Every file that a page refers to is written.
    for name in (name for name in batch.files if name.endswith(".md")):
        assert set(re.findall(r"\]\(([^)#]+)\)", str(batch.files[name]))) <= set(batch.files)
    beside = report_batch(kind_named(kind), {"another": replace(found, name="another")}, tmp_path, COMMAND)
    assert f"{found.name}.md" not in beside.files
    assert set(json.loads(str(beside.files["results.json"]))["parts"]) == {found.name, "another"}
    assert f"{found.name}.md" in str(beside.files["README.md"])
    (other,) = set(FINDINGS) - {kind, "limits" if kind != "limits" else "sweep"}
    with pytest.raises(InvalidInput, match="another kind"):
        ReportFolder(tmp_path, kind_named(other))


# -- the folder ------------------------------------------------------------------------------------------------------


def test_parts_of_earlier_reports_stay_and_stale_files_go(tmp_path: Path) -> None:
    write(tmp_path, study("saw-40rpm"), study("saw-500rpm"))
    (tmp_path / "notes.md").write_text("mine")
    write(tmp_path, study("saw-500rpm", curves=False))
    assert (tmp_path / "figures/saw-40rpm-free-motion.svg").is_file()
    assert not (tmp_path / "figures/saw-500rpm-free-motion.svg").exists()
    index = (tmp_path / "motion.md").read_text()
    assert "saw-40rpm-motion.md" in index
    assert "not all measured by one command" in index
    assert (tmp_path / "notes.md").read_text() == "mine"


@pytest.mark.parametrize("name", ["saw-40rpm-motion.md", "motion.md", "figures/saw-40rpm-free-motion.svg"])
def test_report_never_replaces_a_file_of_the_user(tmp_path: Path, name: str) -> None:
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("mine")
    before = contents(tmp_path)
    with pytest.raises(InvalidInput, match="not of this report"):
        write(tmp_path, study("saw-40rpm"))
    assert contents(tmp_path) == before


def test_other_output_may_not_be_a_file_of_the_report(tmp_path: Path) -> None:
    write(tmp_path, study("saw-40rpm"))
    folder = ReportFolder(tmp_path, FREE_MOTION_REPORT)
    folder.check(["saw-40rpm"], tmp_path / "other.json")
    for name in ("motion.json", "MOTION.md", "saw-500rpm-motion.md", "data/x.json"):
        with pytest.raises(InvalidInput, match="cannot write"):
            folder.check(["saw-500rpm"], tmp_path / name)


# -- rendered again --------------------------------------------------------------------------------------------------


def render_without_engines(report: Path, out: Path) -> dict[str, bytes]:
    """Files of a report that is rendered again where no engine is installed."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(
        [sys.executable, "-c", BLOCKED, "report", str(report), "--out", str(out)],
        capture_output=True, text=True, check=False, env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return contents(out)


def test_report_is_rendered_again_byte_for_byte_without_engines(tmp_path: Path) -> None:
    write(tmp_path / "first", study("saw-40rpm"), study("cam-follower"))
    assert render_without_engines(tmp_path / "first", tmp_path / "second") == contents(tmp_path / "first")


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["", "sweep", "ablate", "limits"])
def test_committed_reports_follow_from_their_saved_findings(folder: str, tmp_path: Path) -> None:
    committed = Path(__file__).parents[2] / "reports" / folder
    for one in subreports(committed):  # which the first page lists
        (tmp_path / one.name).mkdir()
        for file in (committed / one.page, *(committed / one.name).glob("*.json")):
            shutil.copy(file, tmp_path / one.name)
    rendered = render_without_engines(committed, tmp_path)
    assert rendered == {name: (committed / name).read_bytes() for name in rendered}


def test_pages_follow_the_saved_numbers_and_lost_pages_come_back(tmp_path: Path) -> None:
    write(tmp_path, study("saw-40rpm"))
    before = contents(tmp_path)
    shutil.rmtree(tmp_path / "figures")
    (tmp_path / "saw-40rpm-motion.md").unlink()
    write_together(render_again(tmp_path))
    assert contents(tmp_path) == before
    data = tmp_path / "data/saw-40rpm-motion.json"
    data.write_text(data.read_text().replace('{"max": 1e-09', '{"max": 7e-05'))
    write_together(render_again(tmp_path))
    assert "7.0e-5" in (tmp_path / "saw-40rpm-motion.md").read_text()


def test_table_escapes_bars_and_marks_out_of_tolerance_bold() -> None:
    text = table_text(table(("a", "b"), [("x|y", ColouredCell("no", "bad"))], right=("b",)))
    assert text.splitlines() == ["| a | b |", "| --- | ---: |", "| x\\|y | **no** |"]
    assert table_text(table(("a",), [])) == ""
    with pytest.raises(ValueError, match="do not fit"):
        table(("a",), [("1", "2")])
