"""The report of limits as files: whole, the same every time, rendered from its own JSON, merged with what is there."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from limit_walks import SCENE, detected, limit_study, of_axis

from conrod.report.kind import Reproduction
from conrod.report.limits.report import KIND, merged
from conrod.report.saved import restored, shortened
from conrod.report.writer import report_batch
from conrod.studies.frame.writing import Batch, write_together
from conrod.studies.limits.results import LimitStudy

COMMAND = Reproduction("conrod limits {scene} --out reports/limits")


@pytest.fixture(scope="module")
def study() -> LimitStudy:
    return limit_study()


def rendered(study: LimitStudy, folder: Path, command: Reproduction = COMMAND) -> Batch:
    return report_batch(KIND, {study.name: study}, folder, command)


def kept(batch: Batch, scene: str = SCENE) -> LimitStudy:
    return restored(LimitStudy, json.loads(str(batch.files[f"data/{scene}.json"])))


@pytest.fixture(scope="module")
def batch(study: LimitStudy, tmp_path_factory: pytest.TempPathFactory) -> Batch:
    """The whole report, rendered once."""
    return rendered(study, tmp_path_factory.mktemp("limits"))


# -- the files ---------------------------------------------------------------------------------------------------------


def test_the_report_is_whole(study: LimitStudy, batch: Batch) -> None:
    drawings = {name: str(text) for name, text in batch.files.items() if name.endswith(".svg")}
    for name in ("README.md", f"{SCENE}.md"):
        links = re.findall(r"\]\(([^)]+)\)", str(batch.files[name]))
        assert links
        assert not [link for link in links if link not in batch.files]
    assert {name for name in drawings if name not in str(batch.files[f"{SCENE}.md"])} == set()
    for text in drawings.values():
        ElementTree.fromstring(text)
    for axis in {walk.axis for walk in study.walks if walk.probes}:
        assert f"figures/{SCENE}-{axis}.svg" in drawings


@pytest.mark.usefixtures("undrawn")
def test_undetected_runs_come_before_anything_else(study: LimitStudy, tmp_path: Path) -> None:
    files = rendered(study, tmp_path).files
    for name in ("README.md", f"{SCENE}.md"):
        text = str(files[name])
        assert text.index("**Wrong and undetected: ") < text.index("## "), name
    page = str(files[f"{SCENE}.md"])
    assert "199 .. 31 steps" in page
    runs = study.maps[0].runs
    assert f"On the maps: {sum(run.undetected for run in runs)} of {len(runs)} runs" in page
    # Negative control: nothing is said where nothing is.
    calm = str(rendered(replace(study, walks=tuple(detected(study.walks)), maps=()), tmp_path).files[f"{SCENE}.md"])
    assert "No run was wrong and undetected" in calm
    assert "On the maps" not in calm


def test_values_are_kept_as_they_are_and_measurements_rounded(study: LimitStudy, batch: Batch) -> None:
    found = kept(batch)
    assert [[p.value for p in w.probes] for w in found.walks] == [[p.value for p in w.probes] for w in study.walks]
    assert [walk.boundaries for walk in found.walks] == [walk.boundaries for walk in study.walks]
    assert found.determinism == study.determinism
    both = {"torque": 0.123456789, "value": 0.123456789}
    assert shortened(both, KIND.digits, KIND.digits_of) == {"torque": 0.1235, "value": 0.123456789}


# -- into a folder that holds a report already -------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_one_axis_alone_replaces_that_axis_alone(study: LimitStudy, tmp_path: Path) -> None:
    write_together([rendered(study, tmp_path)])
    again = of_axis(study, "mass-ratio")
    walks = (replace(w, probes=tuple(replace(p, reason="new") for p in w.probes)) for w in again.walks)
    command = Reproduction("conrod limits {scene} --axis mass-ratio --out reports/limits")
    batch = rendered(replace(again, walks=tuple(walks)), tmp_path, command)
    write_together([batch])
    found = kept(batch)
    assert [(w.axis, w.engine, w.preset) for w in found.walks] == [(w.axis, w.engine, w.preset) for w in study.walks]
    assert {w.axis for w in found.walks if any(p.reason == "new" for p in w.probes)} == {"mass-ratio"}
    assert found.determinism == study.determinism
    assert f"`{COMMAND.of(SCENE)}; {command.of(SCENE)}`" in str(batch.files[f"{SCENE}.md"])
    # The same study whole again: nothing of the two remains.
    assert command.of(SCENE) not in str(rendered(study, tmp_path).files[f"{SCENE}.md"])


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
