"""Reports that the repository makes of itself: `conrod report` renders them, and says where it cannot."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import conrod

from conrod import InvalidInput
from conrod.report import kind as kinds
from conrod.report.kind import REPOSITORY_KINDS, Reproduction, kind_named
from conrod.report.subreports import subreports
from conrod.report.writer import render_again, report_batch
from conrod.studies.validation.results import DefectVerdict, Qualification
from docs.studies.detection_report import DETECTION_REPORT
from docs.studies.detection_results import Detection, FalseAlarm, MachineDetection, PresetDetection

REPORTS = Path(__file__).parents[2] / "reports"
MARKED = {"verification"}  # sealed pages, which nothing renders again


@pytest.mark.parametrize("place", ["audit", "cams", "batch"])
def test_report_of_the_repository_is_rendered_with_its_bytes(place: str) -> None:
    batches = render_again(REPORTS / place)
    assert batches
    for batch in batches:
        for name, text in batch.files.items():
            if name.endswith((".md", ".json")):
                assert (REPORTS / place / name).read_text(encoding="utf-8") == text, name


@pytest.mark.slow
@pytest.mark.parametrize("place", sorted(one.name for one in REPORTS.iterdir() if (one / "data").is_dir()))
def test_each_committed_report_is_rendered_with_its_bytes(place: str, tmp_path: Path) -> None:
    done = conrod("report", str(REPORTS / place), "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    for file in tmp_path.rglob("*"):
        if file.is_file():
            assert file.read_bytes() == (REPORTS / place / file.relative_to(tmp_path)).read_bytes(), file.name


def test_report_of_the_repository_is_explained_without_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(kinds.KINDS, "documents", "no_such_package.REPORT")
    with pytest.raises(InvalidInput, match="'documents' can be rendered where conrod is installed from its repository"):
        render_again(REPORTS / "audit", tmp_path)
    # A report above it is rendered, and names it.
    assert "audit" in {one.name for one in subreports(REPORTS)}


def test_kind_of_conrod_itself_that_is_missing_is_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "validation" not in REPOSITORY_KINDS
    monkeypatch.setitem(kinds.KINDS, "validation", "no_such_package.REPORT")
    with pytest.raises(ModuleNotFoundError):
        kind_named("validation")


def detection(alarms: tuple[FalseAlarm, ...] = (), allowed: float = 1.05e-6) -> Detection:
    found = (DefectVerdict("time step", "%", "", 1e-3, ("position",), 6.54321e-13),)
    qualified = Qualification(found, ())
    preset = PresetDetection("mujoco", "tuned", "", qualified, {"position": (1e-6, allowed)}, 4, alarms)
    return Detection((MachineDetection("saw-500rpm", (preset,)),))


def test_detection_report_keeps_sizes_at_rounding(tmp_path: Path) -> None:
    (text,) = [
        text
        for name, text in report_batch(
            DETECTION_REPORT, {"detection": detection()}, tmp_path, Reproduction("make detection")
        ).files.items()
        if name == "data/detection.json"
    ]
    (preset,) = json.loads(text)["machines"][0]["presets"]
    assert preset["qualified"]["motion"][0]["smallest"] == 6.54e-13


def test_detection_report_names_alarms_and_loose_tolerances() -> None:
    verdict = DETECTION_REPORT.verdict
    assert verdict(detection()).startswith("0 false alarms in 4 healthy runs; 0 tolerances of 1 are more than 10")
    alarm = FalseAlarm(200, 3.0, "", {"position": (2e-6, 1e-6)})
    worse = detection((alarm,), allowed=2e-5)
    assert verdict(worse).startswith("1 false alarms in 4 healthy runs; 1 tolerances of 1 are more than 10")
    lines = [str(one) for one in DETECTION_REPORT.printed([worse]) if isinstance(one, str)]
    assert lines[0] == "saw-500rpm, MuJoCo tuned, 200 steps, speed 3 rad/s: position 2 times its tolerance"
