"""Findings of `conrod lint` for build servers: GitHub's workflow commands, and SARIF 2.1.0."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote
from xml.parsers import expat

from conrod.mjcf.lint.findings import Finding, Report, SetOption, Severity
from conrod.runs.plain import json_document

SARIF = "https://json.schemastore.org/sarif-2.1.0.json"
GITHUB = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.NOTE: "notice"}


def github(report: Report) -> str:
    """A workflow command for each finding, which GitHub shows beside the line of the model."""
    lines = _lines_of(Path(report.model))
    return "".join(
        f"::{GITHUB[one.harm.severity]} file={_property(report.model)},line={_line(one, lines)},"
        f"title={_property(f'conrod lint: {one.rule}')}::{_data(_message(one))}\n"
        for one in report.findings
    )


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")


def sarif(report: Report) -> str:
    """A SARIF log of one run, as code scanning of GitHub, GitLab, Azure and editors read it."""
    path, lines = Path(report.model), _lines_of(Path(report.model))
    uri = path.as_uri() if path.is_absolute() else quote(path.as_posix())
    rules = {one.rule: one.why for one in report.findings}
    results = [
        {
            "ruleId": one.rule,
            "level": one.harm.severity.value,
            "message": {"text": _message(one)},
            "locations": [
                {"physicalLocation": {"artifactLocation": {"uri": uri}, "region": {"startLine": _line(one, lines)}}}
            ],
        }
        for one in report.findings
    ]
    described: list[Any] = [{"id": rule, "shortDescription": {"text": why}} for rule, why in rules.items()]
    tool = {"driver": {"name": "conrod lint", "version": version("conrod"), "rules": described}}
    return json_document({"$schema": SARIF, "version": "2.1.0", "runs": [{"tool": tool, "results": results}]})


def _message(finding: Finding) -> str:
    edits = "".join(f"\n  {edit.words}" for edit in finding.edits)
    return f"{finding.what}\n{finding.harm.meaning}: {finding.why}\nfix: {finding.fix}{edits}"


def _lines_of(path: Path) -> dict[str, int]:
    """Line of the first element of each name, and of each kind, as `<option`; of the file itself, not of includes."""
    parser, lines = expat.ParserCreate(), dict[str, int]()

    def begin(tag: str, attributes: Mapping[str, str]) -> None:
        for key in (f"<{tag}", attributes.get("name", "")):
            lines.setdefault(key, parser.CurrentLineNumber)

    parser.StartElementHandler = begin
    parser.Parse(path.read_bytes(), True)
    return lines


def _line(finding: Finding, lines: Mapping[str, int]) -> int:
    """Line of what a finding is about; of the model where that stands nowhere in the file."""
    sections = [f"<{edit.path[0]}" for edit in finding.edits if isinstance(edit, SetOption)]
    return next((lines[key] for key in (*finding.subjects, *sections, "<mujoco") if key in lines), 1)
