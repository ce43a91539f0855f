"""What a folder's report of limits keeps, replaces and refuses when another one is written into it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from limit_studies import limit_study, of_axis, renamed
from limit_walks import SCENE

from conrod.errors import InvalidInput
from conrod.report.limits import writer
from conrod.report.limits.document import check_limits_folder, earlier_limits, merged
from conrod.report.limits.writer import limits_report_batch
from conrod.report.reproduction import Reproduction
from conrod.studies.frame.files import write_together
from conrod.studies.limits.results import LimitStudy

COMMAND = Reproduction("conrod limits {scene} --out reports/limits")


@pytest.fixture(scope="module")
def study() -> LimitStudy:
    return limit_study()


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures by name alone: drawing them is what takes long."""
    monkeypatch.setattr(writer, "limits_figures", lambda study: {w.axis: "<svg/>" for w in study.walks if w.probes})


@pytest.mark.usefixtures("undrawn")
def test_scenes_of_an_earlier_report_stay(study: LimitStudy, tmp_path: Path) -> None:
    write_together([limits_report_batch([study], tmp_path, COMMAND)])
    batch = limits_report_batch([renamed(study, "saw-40rpm")], (), tmp_path, COMMAND)
    index = str(batch.files["README.md"])
    assert f"[{SCENE}]({SCENE}.md)" in index
    assert f"{SCENE}.md" not in batch.files
    assert set(json.loads(str(batch.files["results.json"]))["limits"]) == {SCENE, "saw-40rpm"}
    assert f"`{COMMAND.of('saw-40rpm', SCENE)}`" in index


@pytest.mark.usefixtures("undrawn")
def test_one_axis_alone_replaces_that_axis_alone(study: LimitStudy, tmp_path: Path) -> None:
    write_together([limits_report_batch([study], tmp_path, COMMAND)])
    again = of_axis(study, "mass-ratio")
    walks = (replace(w, probes=tuple(replace(p, key="new") for p in w.probes)) for w in again.walks)
    alone = replace(again, walks=tuple(walks))
    command = Reproduction("conrod limits {scene} --axis mass-ratio --out reports/limits")
    write_together([limits_report_batch([alone], (), tmp_path, command)])
    entry = earlier_limits(tmp_path)[SCENE]
    kept = LimitStudy.of(entry["study"])
    assert [(w.axis, w.engine, w.preset) for w in kept.walks] == [(w.axis, w.engine, w.preset) for w in study.walks]
    assert {w.axis for w in kept.walks if any(p.key == "new" for p in w.probes)} == {"mass-ratio"}
    assert {w.axis for w in kept.walks if any(p.key != "new" for p in w.probes)} == {
        walk.axis for walk in study.walks if walk.probes
    } - {"mass-ratio"}
    assert kept.determinism == study.determinism
    assert len(entry["commands"]) == 2
    # The same study whole again: nothing of the two remains.
    write_together([limits_report_batch([study], (), tmp_path, COMMAND)])
    assert earlier_limits(tmp_path)[SCENE]["commands"] == [COMMAND.of(SCENE)]


def test_nothing_is_kept_of_another_machine_or_another_engine(study: LimitStudy) -> None:
    steps = of_axis(study, "steps")
    assert merged(study, steps) == study
    assert merged(study, replace(steps, parameters={**study.parameters, "rod": 9.0})).walks == steps.walks
    newer = merged(study, replace(steps, engines={**study.engines, "pymunk": "8.0.0"}))
    assert {walk.axis for walk in newer.walks if walk.engine == "pymunk"} == {"steps"}
    assert {walk.axis for walk in newer.walks if walk.engine == "mujoco"} == {walk.axis for walk in study.walks}
    # One engine alone leaves the other one's walks.
    mujoco = tuple(walk for walk in steps.walks if walk.engine == "mujoco")
    one = merged(study, replace(steps, walks=mujoco, engines={"mujoco": "4.0.0"}))
    assert one.walks == study.walks
    assert dict(one.engines) == dict(study.engines)


@pytest.mark.usefixtures("undrawn")
def test_a_figure_that_is_no_longer_shown_goes(study: LimitStudy, tmp_path: Path) -> None:
    write_together([limits_report_batch([study], tmp_path, COMMAND)])
    assert limits_report_batch([study], tmp_path, COMMAND).obsolete == ()
    other = replace(of_axis(study, "steps"), parameters={**study.parameters, "rod": 9.0})
    gone = limits_report_batch([other], (), tmp_path, COMMAND).obsolete
    assert f"figures/{SCENE}-nearness.svg" in gone
    assert f"figures/{SCENE}-steps.svg" not in gone


@pytest.mark.usefixtures("undrawn")
def test_a_folder_of_something_else_is_refused(study: LimitStudy, tmp_path: Path) -> None:
    check_limits_folder(tmp_path, [SCENE])
    write_together([limits_report_batch([study], (), tmp_path / "limits", COMMAND)])
    check_limits_folder(tmp_path / "limits", [SCENE])
    (tmp_path / "results.json").write_text('{"schema": 1, "sweeps": {}}')
    with pytest.raises(InvalidInput, match="not a report of limits"):
        check_limits_folder(tmp_path, [SCENE])
    (tmp_path / "limits" / "README.md").unlink()
    (tmp_path / "limits" / "README.md").mkdir()
    with pytest.raises(InvalidInput, match="not a regular file"):
        check_limits_folder(tmp_path / "limits", [SCENE])


def test_an_entry_of_another_version_is_not_taken_over(tmp_path: Path) -> None:
    document = {"schema": 1, "limits": {SCENE: {"study": {"walks": []}, "commands": []}}, "gallery": []}
    (tmp_path / "results.json").write_text(json.dumps(document))
    assert earlier_limits(tmp_path) == {}
