"""Files that nobody wrote as conrod does end in one line: names that are no UTF-8, odd numbers, changed reports."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from command_line import conrod, refusal

from conrod.execution.baseline import read_baseline
from tests.report.test_frame import contents, study, write

ROOT = Path(__file__).parents[2]
NAMED = os.fsdecode(b"out\xff")  # what a file is called as whose name is no UTF-8
SAW = ROOT / "mjcf" / "saw-500rpm.xml"


def test_lint_writes_sarif_of_a_model_with_a_control_character(tmp_path: Path) -> None:
    (tmp_path / "esc.xml").write_text(SAW.read_text().replace('"slider"', '"sl\x1b[2Jider"'))
    done = conrod("lint", "esc.xml", "--format", "sarif", "--fail-on", "error", cwd=tmp_path)
    assert done.returncode in (0, 1), done.stderr
    assert json.loads(done.stdout)["version"] == "2.1.0"
    assert "\x1b" not in done.stdout


@pytest.mark.usefixtures("undrawn")
def test_outputs_may_have_names_that_are_no_utf_8(tmp_path: Path) -> None:
    shutil.copy(SAW, tmp_path / "saw.xml")
    table = f"{NAMED}.csv"
    for arguments in (
        ("show", "saw-500rpm", "--svg", f"{NAMED}.svg", "--json", f"{NAMED}.json"),
        ("export", "saw-500rpm", "--format", "csv", "-o", table),
        ("check", table, "--scene", "saw-500rpm", "--out", NAMED, "--json", f"a{NAMED}", "--html", f"b{NAMED}"),
        ("check", table, "--scene", "saw-500rpm", "--verification", f"c{NAMED}.html"),
        ("report", "--verify", f"c{NAMED}.html"),
        ("report", NAMED, "--html", f"d{NAMED}"),
        ("lint", "saw.xml", "--json", f"e{NAMED}"),
    ):
        done = conrod(*arguments, cwd=tmp_path)
        assert done.returncode == 0, (arguments, done.stderr)
    assert {os.fsencode(name)[:5] for name in os.listdir(tmp_path)} >= {b"out\xff.", b"out\xff", b"aout\xff"}


@pytest.mark.parametrize("verb", [["lint"], ["harden"], ["check", "--scene", "saw-500rpm"], ["check"]])
def test_a_model_whose_name_is_no_utf_8_is_refused(verb: list[str], tmp_path: Path) -> None:
    shutil.copy(SAW, tmp_path / f"{NAMED}.xml")
    said = conrod(verb[0], f"{NAMED}.xml", *verb[1:], cwd=tmp_path)
    assert said.returncode == 2
    assert said.stderr.count("\n") == 1


# -- baselines ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def baseline(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("baseline") / "saw.json"
    assert conrod(*JUDGED, "--baseline", str(file)).returncode == 1  # written for the first time
    return file


JUDGED = ("validate", "saw-500rpm", "--engine", "pymunk", "--preset", "tuned", "--steps-per-rev", "100")
NUMBERS: dict[str, Callable[[dict[str, Any]], object]] = {
    "negative band": lambda number: number.update(band=-1e-12),
    "band of 0": lambda number: number.update(band=0.0),
    "infinite band": lambda number: number.update(band=float("inf")),
    "band that is no number": lambda number: number.update(band=float("nan")),
    "infinite value": lambda number: number.update(value=float("inf")),
    "value that is no number": lambda number: number.update(value=float("nan")),
    "text": lambda number: number.update(value="x"),
}


@pytest.mark.parametrize("change", NUMBERS.values(), ids=NUMBERS)
def test_a_baseline_with_an_odd_number_is_refused(
    change: Callable[[dict[str, Any]], object], baseline: Path, tmp_path: Path
) -> None:
    # A band that is no number would hide every drift.
    document = json.loads(baseline.read_text())
    line = next(iter(document["results"].values()))
    change(line["numbers"]["position"])
    (tmp_path / "b.json").write_text(json.dumps(document))
    said = refusal(*JUDGED, "--baseline", "b.json", cwd=tmp_path)
    assert "b.json is a damaged baseline, delete it" in said


def test_a_baseline_as_it_was_written_is_read(baseline: Path, tmp_path: Path) -> None:
    # Negative control.
    assert read_baseline(baseline).results
    (tmp_path / "deep.json").write_text("[" * 100_000)
    assert "is no baseline" in refusal(*JUDGED, "--baseline", "deep.json", cwd=tmp_path)


# -- reports -----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("conrod.report.figure.Figure.svg", lambda figure: f"<svg>{figure.alt}</svg>")
        folder = tmp_path_factory.mktemp("report")
        write(folder, study("saw-40rpm"), study("cam-follower"))
    return folder


def of_part(document: dict[str, Any]) -> dict[str, Any]:
    part: dict[str, Any] = document["parts"]["saw-40rpm"]
    return part


CHANGES: dict[str, Callable[[dict[str, Any]], object]] = {
    "no environment": lambda document: document.pop("environment"),
    "environment is no table": lambda document: document.update(environment=7),
    "a version is no text": lambda document: document["environment"].update(python=7),
    "no command": lambda document: document.pop("command"),
    "command is a list": lambda document: document.update(command=["conrod"]),
    "no parts": lambda document: document.pop("parts"),
    "parts is a list": lambda document: document.update(parts=[1]),
    "a part has no title": lambda document: of_part(document).pop("title"),
    "a part has no command": lambda document: of_part(document).pop("command"),
    "a part's command is none": lambda document: of_part(document).update(command=None),
    "a part has no version": lambda document: of_part(document).pop("conrod"),
    "a part's page is a number": lambda document: of_part(document).update(page=1),
    "a part's data are elsewhere": lambda document: of_part(document).update(data="../data/x.json"),
    "a part's data are missing": lambda document: of_part(document).update(data="data/missing.json"),
    "a part's summary is a text": lambda document: of_part(document).update(summary="x"),
    "half a character": lambda document: of_part(document).update(title="\ud800"),
    "infinite": lambda document: of_part(document)["summary"].update(x=float("inf")),
    "unfinished is a text": lambda document: document.update(unfinished="x"),
    "unfinished of an odd shape": lambda document: document.update(unfinished={"data": 1, "before": {}}),
    "unfinished names a file elsewhere": lambda document: document.update(
        unfinished={"data": {}, "before": {**document, "files": ["../x.md"]}}
    ),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_report_with_a_changed_index_is_refused_in_a_line(
    change: Callable[[dict[str, Any]], object], report: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "report"
    shutil.copytree(report, folder)
    (results,) = folder.glob("*.json")
    document = json.loads(results.read_text())
    change(document)
    results.write_text(json.dumps(document))
    before = contents(folder)
    refusal("report", str(folder))
    refusal("report", str(folder), "--html", str(tmp_path / "page.html"))
    assert contents(folder) == before


@pytest.mark.usefixtures("undrawn")
def test_inconsistent_findings_are_refused_in_one_line(report: Path, tmp_path: Path) -> None:
    folder = tmp_path / "report"
    shutil.copytree(report, folder)
    data = folder / "data/saw-40rpm-motion.json"
    whole = json.loads(data.read_text())
    for key in whole["results"][0]:
        for value in (None, -1, "x", [], {}, 1e999, True, "\x1b[2J", 10**30):
            changed = json.loads(json.dumps(whole))
            changed["results"][0][key] = value
            data.write_text(json.dumps(changed))
            done = conrod("report", str(folder), "--out", str(tmp_path / "out"))
            assert done.returncode in (0, 2), done.stderr
            assert done.stderr.count("\n") == (done.returncode == 2)


@pytest.mark.usefixtures("undrawn")
def test_escape_characters_of_a_version_reach_no_page(report: Path, tmp_path: Path) -> None:
    folder = tmp_path / "report"
    shutil.copytree(report, folder)
    (results,) = folder.glob("*.json")
    document = json.loads(results.read_text())
    document["environment"]["python"] = of_part(document)["conrod"] = "3\x1b[2J\u202e"
    results.write_text(json.dumps(document))
    assert conrod("report", str(folder), "--html", str(tmp_path / "page.html")).returncode == 0
    assert conrod("report", str(folder)).returncode == 0
    for page in (tmp_path / "page.html", *folder.glob("*.md")):
        assert {"\x1b", "\u202e"}.isdisjoint(page.read_text())
