"""JUnit XML and SARIF of findings: one case a verdict, failures with their words, nothing unsafe in them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

import conrod
from conrod import Findings, Runs
from conrod.report.build_servers import JUNIT, build_verdicts, junit_text, results_text, sarif_text
from conrod.studies.validation.results import SceneStudy


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Findings[SceneStudy]:
    runs = Runs(ledger=tmp_path_factory.mktemp("runs") / "ledger.sqlite", jobs=1)
    return conrod.validate(
        "saw-500rpm", engines="mujoco", steps_per_rev=200, revolutions=1, tolerance={"position": 1e-5}, runs=runs
    )


def test_each_verdict_is_a_case_of_junit_with_its_words(found: Findings[SceneStudy]) -> None:
    suite = ElementTree.fromstring(junit_text(found))[0]
    cases = {case.get("name"): case for case in suite}
    assert suite.get("tests") == str(len(cases)) == str(len(found["saw-500rpm"].results))
    assert {case.get("classname") for case in suite} == {"saw-500rpm"}
    failed = [name for name, case in cases.items() if case.find("failure") is not None]
    passed = [one.name for one in build_verdicts(found) if one.passed]
    assert suite.get("failures") == str(len(failed))
    assert "MuJoCo stock" in failed
    assert "MuJoCo hardened" in passed
    words = cases["MuJoCo stock"].find("failure").get("message")  # type: ignore[union-attr]
    assert words is not None
    assert words.startswith("OUT OF TOLERANCE: position")


def test_sarif_names_what_is_out_of_tolerance_alone(found: Findings[SceneStudy]) -> None:
    log = json.loads(sarif_text(found))
    said = [one["message"]["text"] for one in log["runs"][0]["results"]]
    assert log["version"] == "2.1.0"
    assert len(said) == sum(one.passed is False for one in build_verdicts(found)) >= 1
    assert any(text.startswith("saw-500rpm, MuJoCo stock: OUT OF TOLERANCE") for text in said)


def test_names_with_control_characters_and_markup_do_no_harm(found: Findings[SceneStudy]) -> None:
    hostile = 'a<b>&"\x1b[2J\u202e\x00.xml'
    named = replace(found, parts={hostile: found["saw-500rpm"]})
    text = junit_text(named)
    assert not set(text) & {"\x1b", "\u202e", "\x00"}
    assert ElementTree.fromstring(text)[0][0].get("classname", "").startswith('a<b>&"')
    assert not set(sarif_text(named)) & {"\x1b", "\u202e", "\x00"}


def test_ending_of_the_file_chooses_the_form(found: Findings[SceneStudy]) -> None:
    assert results_text(Path(f"a{JUNIT}"), found).startswith("<?xml")
    assert json.loads(results_text(Path("a.SARIF"), found))["version"] == "2.1.0"
    assert results_text(Path("a.json"), found) == found.json
