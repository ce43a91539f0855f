"""A look at a model as plain values: what it is asked, the edits that fix it, and what it found. Imports no engine.

Findings as JSON, and for build servers: GitHub's workflow commands, and SARIF 2.1.0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote
from xml.parsers import expat

from conrod.own.models.request import Controls, Place
from conrod.runs.plain import json_document, plain

SARIF = "https://json.schemastore.org/sarif-2.1.0.json"


@dataclass(frozen=True)
class Request:
    """Run that is asked for, and what is observed in it.

    Attributes:
        keyframe: name or number of the keyframe that it starts from; None for the first, or the model's own pose.
    """

    keyframe: str | None = None
    seconds: float | None = None  # how long [s]; None for so many steps
    crank: str | None = None  # hinge that is driven; needs a speed
    speed: float | None = None  # of the crank [rad/s]; None for a free run
    points: tuple[Place, ...] = ()  # what is observed; every body where there is none
    ignored: tuple[str, ...] = ()  # names of rules that are left out
    fix_folder: str | None = None  # where a fixed model will be; None where none is asked for
    controls: Controls = ()  # inputs of actuators in place of the keyframe's


# -- edits -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Change:
    """Give an attribute of an element a value, or take the element out where no attribute is named."""

    kind: str  # of element, as MuJoCo names it: geom, joint, equality, sensor, key, body
    index: int  # of the element in the compiled model
    name: str  # how to speak of it
    attribute: str = ""
    value: str = ""

    @property
    def words(self) -> str:
        """In words; an element without a name goes by its kind and number already."""
        spoken = self.name if self.name.startswith(f"{self.kind} ") else f"{self.kind} {self.name}"
        return f'{spoken}: {self.attribute}="{self.value}"' if self.attribute else f"{spoken}: removed"


@dataclass(frozen=True)
class SetOption:
    """Give an attribute of a section a value, wherever the file has the section."""

    path: tuple[str, ...]  # the section and what is in it: ("option", "flag")
    attribute: str
    value: str

    @property
    def words(self) -> str:
        """In words."""
        inner = f'<{self.path[-1]} {self.attribute}="{self.value}"/>'
        return f"<{self.path[0]}>{inner}</{self.path[0]}>" if len(self.path) > 1 else inner


@dataclass(frozen=True)
class Exclude:
    """Let the geoms of two bodies not collide: indices in the compiled model, and how to speak of them."""

    indices: tuple[int, int]
    names: tuple[str, str]

    @property
    def words(self) -> str:
        """In words."""
        return f'<contact><exclude body1="{self.names[0]}" body2="{self.names[1]}"/></contact>'


Edit = Change | SetOption | Exclude


# -- what is found ---------------------------------------------------------------------------------------------------

Value = float | int | str


class Severity(Enum):
    """Severities of findings, the worst first."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"

    @property
    def and_worse(self) -> tuple[Severity, ...]:
        """It and all that are worse."""
        every = tuple(Severity)
        return every[: every.index(self) + 1]


class Harm(Enum):
    """Kinds of harm that a finding does, the worst first, each with its severity and its meaning."""

    WRONG = ("wrong", Severity.ERROR, "makes this motion wrong")
    LATENT = ("latent", Severity.WARNING, "will cause trouble")
    HIDES = ("hides", Severity.NOTE, "would hide a run that fails")
    WASTE = ("waste", Severity.NOTE, "costs, and gives nothing")

    severity: Severity
    meaning: str

    def __new__(cls, value: str, severity: Severity, meaning: str) -> Harm:
        made = object.__new__(cls)
        made._value_, made.severity, made.meaning = value, severity, meaning
        return made


@dataclass(frozen=True, kw_only=True)
class Finding:
    """Something that the motion does not need, or that causes trouble.

    Attributes:
        change: largest change of the observed positions without it, over the travel; None where nothing was run.
    """

    rule: str = ""  # name of the rule that found it; it and `why` are the rule's
    subjects: tuple[str, ...] = ()  # what it is about, by name, or by number where it has none
    what: str  # in a sentence
    harm: Harm
    evidence: dict[str, Value]  # what it rests on; the same in every run on one machine
    why: str = ""  # it is harmful
    fix: str  # in words
    edits: tuple[Edit, ...] = ()  # the same for the model file; empty where words must do
    safe: bool = False  # whether the edits keep the machine and its observed motion
    change: float | None = None


@dataclass(frozen=True)
class Fixed:
    """A model with the safe edits made."""

    text: str = ""  # of the file; empty where there was nothing to do safely
    edits: tuple[Edit, ...] = ()
    change: float = 0.0  # largest change of the observed positions, over the travel


@dataclass(frozen=True)
class Report:
    """All that was found in a model."""

    model: str  # the file
    run: str  # what was run, in a sentence
    findings: tuple[Finding, ...]  # the most harmful first
    notes: tuple[str, ...] = ()  # how a step or a solver that is wrong changed the judging of the rest
    fixed: Fixed | None = None  # None unless it was asked for

    def document(self) -> dict[str, Any]:
        """All but the text of the fixed model as plain values, edits in words."""
        values: dict[str, Any] = plain(self)
        for written, finding in zip(values["findings"], self.findings, strict=True):
            written["severity"] = finding.harm.severity.value
            written["edits"] = [edit.words for edit in finding.edits]
        if self.fixed is not None:
            values["fixed"]["edits"] = [edit.words for edit in self.fixed.edits]
            del values["fixed"]["text"]
        return values


# -- for build servers -------------------------------------------------------------------------------------------------

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
