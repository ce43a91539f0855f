"""`conrod lint --format`: what build servers read stands at the line of the model, and no text breaks out of it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from urllib.parse import unquote

import jsonschema
import pytest
from command_line import conrod

from conrod.mjcf.lint.findings import Change, Finding, Harm, Report, SetOption, github, sarif

MODEL = """<mujoco>
 <option/>
 <!-- name="pin" -->
 <worldbody/>
 <equality>
  <connect
    name="pin"/>
 </equality>
</mujoco>"""
HOSTILE = "100 % off:\r\n::error::planted, by a name"


def finding(harm: Harm, what: str, subject: str = "", *edits: Change | SetOption) -> Finding:
    return Finding(rule=f"rule-{harm.value}", what=what, why="so", harm=harm, evidence={}, fix="none",
                   subjects=(subject,) if subject else (), edits=edits)  # fmt: skip


FOUND = (
    finding(Harm.WRONG, "opens", "pin", Change("equality", 0, "pin", "solref", "0.01 1")),
    finding(Harm.LATENT, HOSTILE, "elsewhere"),
    finding(Harm.HIDES, "resets", "", SetOption(("option", "flag"), "autoreset", "disable")),
)
LINES, LEVELS = [6, 1, 2], ["error", "warning", "note"]

# The part of the schema of SARIF 2.1.0 (oasis-tcs/sarif-spec) that this is written in, with all that it requires there.
TEXT = {"type": "object", "required": ["text"], "properties": {"text": {"type": "string"}}}
RESULT = {
    "type": "object",
    "required": ["message"],
    "additionalProperties": False,
    "properties": {
        "ruleId": {"type": "string"},
        "level": {"enum": ["none", "note", "warning", "error"]},
        "message": TEXT,
        "locations": {"items": {"properties": {"physicalLocation": {"required": ["artifactLocation"], "properties": {
            "artifactLocation": {"properties": {"uri": {"type": "string", "pattern": "^[^ ]+$"}}},
            "region": {"properties": {"startLine": {"type": "integer", "minimum": 1}}},
        }}}}},
    },
}  # fmt: skip
DRIVER = {"required": ["name"], "properties": {"rules": {"items": {"required": ["id"], "properties": {
    "shortDescription": TEXT}}}}}  # fmt: skip
SCHEMA = {
    "required": ["version", "runs"],
    "properties": {
        "version": {"const": "2.1.0"},
        "runs": {"items": {"required": ["tool"], "properties": {
            "tool": {"required": ["driver"], "properties": {"driver": DRIVER}}, "results": {"items": RESULT}}}},
    },
}  # fmt: skip


@pytest.fixture
def report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Report:
    monkeypatch.chdir(tmp_path)
    name = "my saw, 100%: é.xml"
    Path(name).write_text(MODEL, encoding="utf-8")
    return Report(name, "a free run", FOUND, ())


def test_github_shows_each_finding_at_its_line_and_no_text_is_a_command_of_its_own(report: Report) -> None:
    commands = github(report).splitlines()
    assert len(commands) == len(FOUND)
    for command, line, level in zip(commands, LINES, ["error", "warning", "notice"], strict=True):
        parts = re.fullmatch(r"::(\w+) file=([^:,]+),line=(\d+),title=([^:,]+)::(.*)", command)
        assert parts
        assert (parts[1], unquote(parts[2]), int(parts[3])) == (level, report.model, line)
    assert unquote(commands[1].partition("::")[2].partition("::")[2]).startswith(HOSTILE)


def test_sarif_has_all_that_its_schema_requires(report: Report) -> None:
    log = json.loads(sarif(report))
    jsonschema.validate(log, SCHEMA)
    (run,) = log["runs"]
    places = [one["locations"][0]["physicalLocation"] for one in run["results"]]
    assert [one["level"] for one in run["results"]] == LEVELS
    assert [one["region"]["startLine"] for one in places] == LINES
    assert {unquote(one["artifactLocation"]["uri"]) for one in places} == {report.model}
    assert {one["ruleId"] for one in run["results"]} == {one["id"] for one in run["tool"]["driver"]["rules"]}
    # Negative control: GitHub's word for a note is none of SARIF's.
    run["results"][0]["level"] = "notice"
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(log, SCHEMA)


def test_the_command_prints_nothing_else_and_ends_as_ever(report: Report, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conrod.studies.execution.isolation.confined", lambda task, *given: report)
    for form, text in (("github", github(report)), ("sarif", sarif(report))):
        done = conrod("lint", report.model, "--format", form, "--fail-on", "error")
        assert (done.returncode, done.stdout) == (1, text)
    done = conrod("lint", report.model, "--format", "xml")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
