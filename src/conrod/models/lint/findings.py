"""Findings of lint as plain values, and as SARIF 2.1.0. Imports no engine."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from importlib.metadata import version
from pathlib import Path
from typing import Any
from xml.parsers import expat

from conrod.comparison.plain_values import json_document, plain_values
from conrod.errors import COMMANDING_CHARACTERS
from conrod.report.notebook import NotebookResult
from conrod.report.table import Table, table
from conrod.system import file_address

SARIF = "https://json.schemastore.org/sarif-2.1.0.json"


Value = float | int | str


class Severity(Enum):
    """Severity of a finding: an error makes the motion wrong; a note costs time, or would hide a failure."""

    ERROR = "error"
    NOTE = "note"


@dataclass(frozen=True, kw_only=True)
class Finding:
    """Something that the motion does not need, or that causes trouble.

    Attributes:
        edits: sections of MJCF that mend it where they come last in the file; empty where words must do.
        change: largest change of the observed positions without it, over the travel; None where nothing was run.
    """

    rule: str = ""  # name of the rule that found it
    subjects: tuple[str, ...] = ()  # names of the elements concerned; numbers of those without a name
    what: str  # the finding, in a sentence
    severity: Severity
    evidence: dict[str, Value]  # numbers that show it; the same in every run on one computer
    why: str  # why it is harmful
    fix: str  # what mends it, in words
    edits: tuple[str, ...] = ()
    safe: bool = False  # whether the edits keep the machine and its observed motion
    change: float | None = None


@dataclass(frozen=True)
class FixedModel:
    """A model with the safe edits made."""

    text: bytes = b""  # content of the file; empty where no safe edit applies
    edits: tuple[str, ...] = ()
    change: float = 0.0  # largest change of the observed positions, over the travel


@dataclass(frozen=True)
class Report(NotebookResult):
    """Findings of lint in a model."""

    model: str  # path of the file
    run: str  # description of the run, in a sentence
    findings: tuple[Finding, ...]  # the most harmful first
    notes: tuple[str, ...] = ()  # how a step or a solver that is wrong changed the judging of the rest
    fixed: FixedModel | None = None  # None unless it was asked for

    @property
    def verdict(self) -> str:
        """The number of findings by severity: '3 findings: 1 error, 2 notes'."""
        found = [finding.severity for finding in self.findings]
        number, counts = len(found), [(one.value, found.count(one)) for one in Severity]
        parts = ", ".join(f"{count} {name}{'' if count == 1 else 's'}" for name, count in counts if count)
        return f"{number or 'no'} finding{'' if number == 1 else 's'}" + (f": {parts}" if parts else "")

    def tables(self) -> list[Table]:
        """A row for each finding, the most harmful first; no table without findings."""
        rows = [(one.severity.value, one.rule, one.what, one.fix) for one in self.findings]
        return [table(("severity", "rule", "finding", "fix"), rows)] if rows else []

    def document(self) -> dict[str, Any]:
        """All but the text of the fixed model as plain values."""
        values: dict[str, Any] = {
            name: plain_values(getattr(self, name)) for name in ("model", "run", "findings", "notes")
        }
        fixed = None if self.fixed is None else {"edits": list(self.fixed.edits), "change": self.fixed.change}
        return values | {"fixed": fixed}


# -- for build servers -------------------------------------------------------------------------------------------------


def sarif(reports: Sequence[Report]) -> str:
    """A SARIF log with a run for each model, as code scanning of GitHub, GitLab, Azure and editors read it."""
    log = {"$schema": SARIF, "version": "2.1.0", "runs": [_sarif_run(report) for report in reports]}
    return json_document(without_commanding_characters(log))


def _sarif_run(report: Report) -> dict[str, Any]:
    """The findings of one model as a run of a SARIF log."""
    path, lines = Path(report.model), _element_lines(Path(report.model))
    uri = file_address(path)
    rules = {one.rule: one.why for one in report.findings}
    results = [
        {
            "ruleId": one.rule,
            "level": one.severity.value,
            "message": {"text": "\n".join((one.what, one.why, f"fix: {one.fix}", *one.edits))},
            "locations": [
                {
                    "physicalLocation": {
                        "artifactLocation": {"uri": uri},
                        "region": {"startLine": _line_of_finding(one, lines)},
                    }
                }
            ],
        }
        for one in report.findings
    ]
    described: list[Any] = [{"id": rule, "shortDescription": {"text": why}} for rule, why in rules.items()]
    tool = {"driver": {"name": "conrod lint", "version": version("conrod"), "rules": described}}
    return {"automationDetails": {"id": f"conrod lint/{uri}"}, "tool": tool, "results": results}


def without_commanding_characters(values: Any) -> Any:
    """A SARIF log whose texts hold no characters that command a terminal or reader."""
    match values:
        case str():
            return "\r\n".join(line.translate(COMMANDING_CHARACTERS) for line in values.split("\r\n"))
        case dict():
            return {key: without_commanding_characters(value) for key, value in values.items()}
        case list() | tuple():
            return [without_commanding_characters(value) for value in values]
        case _:
            return values


def _element_lines(path: Path) -> dict[str, int]:
    """First line of each name and of each element tag, as `<option`; of the file itself, not of includes."""
    parser, lines = expat.ParserCreate(), dict[str, int]()

    def begin(tag: str, attributes: Mapping[str, str]) -> None:
        for key in (f"<{tag}", attributes.get("name", "")):
            lines.setdefault(key, parser.CurrentLineNumber)

    parser.StartElementHandler = begin
    # MuJoCo reads what is no XML to others: lines are then those up to there.
    with suppress(expat.ExpatError, ValueError, LookupError):
        parser.Parse(path.read_bytes(), True)
    return lines


def _line_of_finding(finding: Finding, lines: Mapping[str, int]) -> int:
    """Line of a finding's subject in the file; of `<mujoco` if it is not in the file."""
    sections = [section[0] for edit in finding.edits if (section := re.match(r"<\w+", edit))]
    return next((lines[key] for key in (*finding.subjects, *sections, "<mujoco") if key in lines), 1)
