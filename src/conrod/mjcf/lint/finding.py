"""What a look at a model is asked to do. Imports no engine.

What a look at a model came to. Imports no engine.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import IntEnum
from typing import Any

from conrod.mjcf.lint.edits import Edit
from conrod.own.models.request import Place
from conrod.studies.frame.paired_timing import PairedCost

DEFAULT_STEPS = 2000  # two revolutions of a machine that takes 1000 steps for one
MOST_STEPS = 1_000_000


@dataclass(frozen=True)
class Request:
    """How a model is run and what of it is observed.

    Attributes:
        keyframe: name or number of the keyframe that it starts from; None for the first, or the model's own pose.
        seconds: how long [s]; None for so many steps.
        crank: hinge that is driven; needs a speed.
        speed: of the crank [rad/s]; None for a free run.
        points: what is observed; every body where there is none.
        ignored: names of rules that are not asked.
        fix_folder: where a fixed model will be; None where none is asked for.
    """

    keyframe: str | None = None
    seconds: float | None = None
    crank: str | None = None
    speed: float | None = None
    points: tuple[Place, ...] = ()
    ignored: tuple[str, ...] = ()
    fix_folder: str | None = None


Value = float | int | str


class Harm(IntEnum):
    """What a finding does, the worst first."""

    WRONG = 0
    LATENT = 1
    WASTE = 2

    @property
    def meaning(self) -> str:
        """In words."""
        return ("it makes this motion wrong", "it will bite", "it costs and gives nothing")[self]


@dataclass(frozen=True)
class Finding:
    """Something that the motion does not need, or that bites.

    Attributes:
        rule: name of the rule that found it.
        subjects: what it is about, by name, or by number where it has none.
        what: in a sentence.
        harm: of what kind.
        evidence: what it rests on; the same in every run on one machine.
        why: it bites.
        fix: in words.
        edits: the same for the model file; empty where words must do.
        safe: whether the edits leave the machine and its observed motion what they are meant to be; see `safe_because`.
        change: largest change of the observed positions without it, over the travel; None where nothing was run.
        cost: of a step with it over one without it, measured; None where it has none.
    """

    rule: str
    subjects: tuple[str, ...]
    what: str
    harm: Harm
    evidence: tuple[tuple[str, Value], ...]
    why: str
    fix: str
    edits: tuple[Edit, ...] = ()
    safe: bool = False
    change: float | None = None
    cost: PairedCost | None = None


@dataclass(frozen=True)
class Note:
    """Something that is good to know, and no finding."""

    rule: str
    what: str
    cost: PairedCost | None = None


@dataclass(frozen=True)
class Fixed:
    """A model with the safe edits made.

    Attributes:
        text: of the file; empty where there was nothing to do safely.
        edits: that it has.
        change: largest change of the observed positions, over the travel.
        cost: of a step of the original over one of it.
    """

    text: str
    edits: tuple[Edit, ...]
    change: float
    cost: PairedCost | None


@dataclass(frozen=True)
class Report:
    """All that was found in a model.

    Attributes:
        model: the file.
        run: what was run, in a sentence.
        findings: the most harmful first.
        fixed: None unless it was asked for.
    """

    model: str
    run: str
    findings: tuple[Finding, ...]
    notes: tuple[Note, ...]
    fixed: Fixed | None = None

    def as_dict(self) -> dict[str, Any]:
        """All but the text of the fixed model as plain values."""
        fixed = None if self.fixed is None else asdict(self.fixed) | {"edits": _told(self.fixed.edits)}
        if fixed is not None:
            del fixed["text"]
        return {
            "model": self.model,
            "run": self.run,
            "findings": [
                asdict(finding)
                | {
                    "harm": finding.harm.name.lower(),
                    "evidence": dict(finding.evidence),
                    "edits": _told(finding.edits),
                }
                for finding in self.findings
            ],
            "notes": [asdict(note) for note in self.notes],
            "fixed": fixed,
        }


def _told(edits: tuple[Edit, ...]) -> list[str]:
    return [edit.told for edit in edits]
