"""Files of a report of limits, merged with what a folder already holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput
from conrod.report.folder import ReportFolder
from conrod.report.limits.report import KIND
from conrod.report.reproduction import Reproduction
from conrod.report.saved import restore
from conrod.report.writer import document_text, report_batch
from conrod.studies.frame.files import Batch, single
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.results import PARTS, LimitStudy

TOPIC = ("engine", "preset", "axis", "x_axis", "y_axis", "iterations")  # of a part of a study, besides the scene


def report_batches(
    studies: Sequence[LimitStudy], folder: Path | None, file: Path | None, command: Reproduction | None
) -> list[Batch]:
    """Return the files of a report and of a JSON document, rendered and not yet written.

    What a study did not look at stays in the report of a folder; the document holds the studies alone, unrounded.
    """
    found = {study.name: study for study in studies}
    batches = [single(file, document_text(KIND, found))] if file else []
    if folder and command:
        whole, earlier = with_earlier(found, folder)
        commands = {name: list(dict.fromkeys([*earlier.get(name, ()), command.of(name)])) for name in found}
        batches.append(report_batch(KIND, whole, folder, command, {"commands": commands}))
    return batches


def with_earlier(studies: Mapping[str, LimitStudy], folder: Path) -> tuple[dict[str, LimitStudy], dict[str, list[str]]]:
    """Return studies with what a folder's report has of the same machines besides, and the commands that found that."""
    before, whole, commands = ReportFolder(folder, KIND), dict(studies), dict[str, list[str]]()
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
        # New parts stand where earlier ones about the same stood.
        parts[name] = tuple(chain.from_iterable((_by_topic(kept) | _by_topic(getattr(new, name))).values()))
    order = list(AXES), list(engines)
    walks = sorted(parts["walks"], key=lambda walk: (order[0].index(walk.axis), order[1].index(walk.engine)))
    return replace(new, **{**parts, "engines": engines, "walks": tuple(walks)})


def _by_topic(parts: Sequence[Any]) -> dict[tuple[Any, ...], list[Any]]:
    found: dict[tuple[Any, ...], list[Any]] = {}
    for part in parts:
        found.setdefault(tuple(getattr(part, name, None) for name in TOPIC), []).append(part)
    return found
