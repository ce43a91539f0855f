"""Files of a report of limits: findings rounded, merged with those that a folder already holds, and rendered."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput
from conrod.report import numbers
from conrod.report.folder import ReportFolder
from conrod.report.kind import kind_named
from conrod.report.reproduction import Reproduction
from conrod.report.saved import restore
from conrod.report.writer import document_text, report_batch
from conrod.studies.frame.files import Batch, single
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.results import LimitStudy

PARTS = ("walks", "long_runs", "maps", "needs", "determinism", "floats")

# -- what is kept ----------------------------------------------------------------------------------------------------

# Inputs are kept as they are; everything else that is a fraction was measured.
INPUTS = {
    "parameters",
    "value",
    "last_good",
    "first_bad",
    "good_again",
    "x",
    "y",
    "revolutions",
    "speed",
    "held",
    "flown",
}
# Flights are compared with exact ones: a small difference of the two is what counts.
COMPARED = {"exact", "measured"}
MEASURED_DIGITS, COMPARED_DIGITS = 4, 8


def rounded(value: Any, digits: int | None = MEASURED_DIGITS) -> Any:
    """Return findings with what was measured in few significant digits."""
    match value:
        case float():
            return value if digits is None or not math.isfinite(value) else numbers.rounded(value, digits)
        case tuple() if hasattr(value, "_fields"):
            return type(value)(*(rounded(part, digits) for part in value))
        case tuple() | list():
            return tuple(rounded(part, digits) for part in value)
        case Mapping():
            return {name: rounded(part, digits) for name, part in value.items()}
        case _ if is_dataclass(value) and not isinstance(value, type):
            parts = {f.name: getattr(value, f.name) for f in fields(value)}
            return replace(value, **{name: rounded(part, _digits(name, digits)) for name, part in parts.items()})
        case _:
            return value


def _digits(name: str, digits: int | None) -> int | None:
    return None if digits is None or name in INPUTS else COMPARED_DIGITS if name in COMPARED else digits


# -- files -----------------------------------------------------------------------------------------------------------


def report_batches(
    studies: Sequence[LimitStudy], folder: Path | None, file: Path | None, command: Reproduction | None
) -> list[Batch]:
    """Return the files of a report and of a JSON document, rendered and not yet written.

    What a study did not look at stays in the report of a folder; the document holds the studies alone, unrounded.
    """
    found = {study.name: study for study in studies}
    batches = (
        [single(file, document_text(replace(kind_named("limits"), kept=lambda study: study), found))] if file else []
    )
    if folder and command:
        whole, earlier = with_earlier(found, folder)
        commands = {name: list(dict.fromkeys([*earlier.get(name, ()), command.of(name)])) for name in found}
        batches.append(report_batch(kind_named("limits"), whole, folder, command, {"commands": commands}))
    return batches


# -- studies that add to a report ------------------------------------------------------------------------------------


def with_earlier(studies: Mapping[str, LimitStudy], folder: Path) -> tuple[dict[str, LimitStudy], dict[str, list[str]]]:
    """Return studies with what a folder's report has of the same machines besides, and the commands that found that."""
    before, whole, commands = ReportFolder(folder, kind_named("limits")), dict(studies), dict[str, list[str]]()
    for name in studies.keys() & before.entries.keys():
        try:
            earlier = restore(LimitStudy, before.values(name))
        except InvalidInput:
            continue
        whole[name] = merged(earlier, studies[name])
        if whole[name] != studies[name]:
            entry = before.entries[name]
            commands[name] = entry["options"].get("commands", {}).get(name, [entry["command"]])
    return whole, commands


def merged(earlier: LimitStudy, new: LimitStudy) -> LimitStudy:
    """Return the earlier study with all that the new one studied again replaced, and with what it adds.

    Nothing is kept of another machine, or of another version of an engine: figures that no run would give again.
    """
    if (earlier.kind, dict(earlier.parameters)) != (new.kind, dict(new.parameters)):
        return new
    changed = {name for name, version in new.engines.items() if earlier.engines.get(name, version) != version}
    engines = {**earlier.engines, **new.engines}
    parts: dict[str, Any] = {}
    for name in PARTS:
        kept = [part for part in getattr(earlier, name) if part.engine not in changed]
        parts[name] = _replaced(kept, getattr(new, name))
    order = list(AXES), list(engines)
    walks = sorted(parts["walks"], key=lambda walk: (order[0].index(walk.axis), order[1].index(walk.engine)))
    return replace(new, **{**parts, "engines": engines, "walks": tuple(walks)})


def _topic(part: Any) -> tuple[Any, ...]:
    """Topic of a part of a study, besides the scene."""
    about = ("engine", "preset", "axis", "x_axis", "y_axis", "iterations")
    return tuple(getattr(part, name, None) for name in about)


def _replaced(earlier: Sequence[Any], new: Sequence[Any]) -> tuple[Any, ...]:
    """New parts stand where the first earlier one about the same stood; those about something else at the end."""
    ahead: dict[tuple[Any, ...], list[Any]] = {}
    for part in new:
        ahead.setdefault(_topic(part), []).append(part)
    about = set(ahead)
    found: list[Any] = []
    for part in earlier:
        found += ahead.pop(_topic(part), []) if _topic(part) in about else [part]
    return (*found, *(part for parts in ahead.values() for part in parts))
