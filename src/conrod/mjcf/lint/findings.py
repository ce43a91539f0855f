"""A look at a model as plain values: what it is asked and what it found. Imports no engine."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from conrod.own.models.request import Controls
from conrod.runs.plain import plain


@dataclass(frozen=True)
class Request:
    """Run that is asked for.

    Attributes:
        keyframe: name or number of the keyframe that it starts from; None for the first, or the model's own pose.
    """

    keyframe: str | None = None
    seconds: float | None = None  # how long [s]; None for so many steps
    ignored: tuple[str, ...] = ()  # names of rules that are left out
    fix_folder: str | None = None  # where a fixed model will be; None where none is asked for
    controls: Controls = ()  # inputs of actuators in place of the keyframe's


Value = float | int | str


class Severity(Enum):
    """Severities of findings, the worst first: it makes this motion wrong; or it costs, or would hide a failure."""

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
    subjects: tuple[str, ...] = ()  # what it is about, by name, or by number where it has none
    what: str  # in a sentence
    severity: Severity
    evidence: dict[str, Value]  # what it rests on; the same in every run on one machine
    why: str  # it is harmful
    fix: str  # in words
    edits: tuple[str, ...] = ()
    safe: bool = False  # whether the edits keep the machine and its observed motion
    change: float | None = None


@dataclass(frozen=True)
class Fixed:
    """A model with the safe edits made."""

    text: bytes = b""  # of the file; empty where there was nothing to do safely
    edits: tuple[str, ...] = ()
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
        """All but the text of the fixed model as plain values."""
        values: dict[str, Any] = {name: plain(getattr(self, name)) for name in ("model", "run", "findings", "notes")}
        fixed = None if self.fixed is None else {"edits": list(self.fixed.edits), "change": self.fixed.change}
        return values | {"fixed": fixed}
