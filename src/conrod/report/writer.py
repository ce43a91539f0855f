"""Write reports of every kind, or render them again from their saved findings."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib.metadata import version
from itertools import repeat
from pathlib import Path
from typing import Any

from conrod.crash import error_text
from conrod.engines import engine_packages, environment
from conrod.errors import InvalidInput
from conrod.execution.writing import Batch
from conrod.report.folder import (
    EXACT_FIELDS,
    ReportFolder,
    json_text,
    plain_findings,
    read_document,
    restore_findings,
    round_findings,
)
from conrod.report.kept_digits import keep_earlier_digits
from conrod.report.kind import KINDS, F, Index, Kind, Part, Reproduction, kind_named
from conrod.report.subreports import subreports
from conrod.report.template import Page

Draw = Callable[..., Iterable[Any]]
COMMAND_SEPARATOR = "; "  # between commands
SEVERAL_COMMANDS = "The parts were not all measured by one command: each page names its own."


def report_batch(
    kind: Kind[F],
    findings: Mapping[str, F],
    folder: Path,
    command: Reproduction,
    draw: Draw = map,
) -> Batch:
    """Render all files of a report without writing any: an error leaves the folder as it was.

    Other parts of a report of the kind in the folder stay. Earlier findings of a part are merged with the new ones, if
    the kind can merge.

    Args:
        kind: kind of the report.
        findings: findings by part.
        folder: folder of the report.
        command: command that reproduces the report.
        draw: `map`, or an executor's `map` to make several pages at a time.

    Raises:
        InvalidInput: a file in the folder is in the way.
    """
    before = ReportFolder(folder, kind)
    merged = {name: _merge_with_earlier(before, name, one, command.command_for(name)) for name, one in findings.items()}
    entries = {
        name: {"title": kind.title(one), "command": commands, "conrod": version("conrod")}
        for name, (one, commands) in merged.items()
    }
    saved = {name: _saved_values(before, name, *one) for name, one in merged.items()}
    alone = all(commands == command.command_for(name) for name, (_, commands) in merged.items())
    whole = alone and before.entries.keys() <= findings.keys()
    head = _document_head(kind) | {"command": command.command_for_all(findings) if whole else None}
    if _found_again(before, head, entries, saved):
        head["environment"] = before.document["environment"]
    return _render_parts(before, head, before.entries | entries, saved, draw)


def _merge_with_earlier(before: ReportFolder, name: str, new: F, command: str) -> tuple[F, str]:
    """Merge findings with the part's earlier ones, and join the commands of both."""
    kind = before.kind
    if kind.merge is None or name not in before.entries:
        return new, command
    try:
        whole: F = kind.merge(restore_findings(kind.findings, before.values(name)), new)
    except InvalidInput:
        return new, command
    if whole == new:
        return new, command
    return whole, COMMAND_SEPARATOR.join(
        dict.fromkeys([*before.entries[name]["command"].split(COMMAND_SEPARATOR), command])
    )


def _saved_values(before: ReportFolder, name: str, findings: Any, command: str) -> Any:
    """Return a part's findings as they are saved: rounded, and with the earlier numbers where these are the same."""
    kind = before.kind
    digits_of, values = {**EXACT_FIELDS, **kind.digits_of}, plain_findings(kind.prepare_to_save(findings))
    if name in before.entries and before.entries[name]["command"] == command:
        with suppress(InvalidInput):
            values = keep_earlier_digits(before.values(name), values, kind.digits, digits_of, kind.places)
    return round_findings(values, kind.digits, digits_of)


def _found_again(
    before: ReportFolder, head: Mapping[str, Any], entries: Mapping[str, Any], saved: Mapping[str, Any]
) -> bool:
    """Return True if a report's engines and findings equal the folder's."""
    was, now = before.document.get("environment", {}), head["environment"]
    if before.entries.keys() != entries.keys() or any(was.get(name) != now[name] for name in engine_packages()):
        return False
    try:
        return all(before.values(name) == values for name, values in saved.items())
    except InvalidInput:
        return False


def document_text(kind: Kind[F], findings: Mapping[str, F]) -> str:
    """Return findings as one JSON document: `results.json` with the findings of each part."""
    parts = {
        name: {
            "title": kind.title(one),
            "summary": plain_findings(kind.summary(one)),
            "findings": plain_findings(kind.prepare_to_save(one)),
        }
        for name, one in findings.items()
    }
    return json_text(_document_head(kind) | {"parts": parts})


def render_again(folder: Path, out: Path | None = None, draw: Draw = map) -> list[Batch]:
    """Render the reports of a folder again from their own JSON.

    Args:
        folder: folder of the reports.
        out: folder to write; None for the same.
        draw: as in `report_batch`.

    Raises:
        InvalidInput: the folder has no report, or a report of another version of conrod.
    """
    found = reports_in(folder)
    if not found:
        raise InvalidInput(f"{folder}: no report that can be rendered: no JSON file in it names a kind of report")
    return [_render_folder(one, out, draw) for one in found]


@contextmanager
def explain_unfit_findings(folder: Path) -> Iterator[None]:
    """Turn an exception while saved findings are rendered into one line that names the folder.

    Raises:
        InvalidInput: the findings were changed, or conrod is at fault; which of both cannot be known.
    """
    try:
        yield
    except (InvalidInput, OSError, MemoryError):
        raise
    except Exception as error:  # a template may fail in any way on changed findings
        said = f"{folder}: what it holds cannot be shown again ({error_text(error)})"
        raise InvalidInput(f"{said}: it was changed since conrod wrote it, or conrod is at fault") from error


def reports_in(folder: Path) -> list[ReportFolder]:
    """Return a folder's reports of all kinds; raises InvalidInput for another version's report."""
    return [ReportFolder(folder, kind_named(name)) for name in _kinds_in(folder)]


def _document_head(kind: Kind[Any]) -> dict[str, Any]:
    return {
        "kind": kind.name, "schema": kind.schema, "conrod": version("conrod"), "environment": environment(),
    }  # fmt: skip


def _kinds_in(folder: Path) -> list[str]:
    found = []
    for file in sorted(folder.glob("*.json")):
        try:
            document = read_document(file)
        except InvalidInput:
            raise
        except (OSError, ValueError):
            continue
        if isinstance(document, dict) and "schema" in document and "conrod" in document:
            if "kind" not in document:
                raise InvalidInput(f"{file}: it was written by an earlier conrod, which saved no findings to render")
            found += [name for name in KINDS if name == document["kind"]]
    return found


def _render_folder(before: ReportFolder, out: Path | None, draw: Draw) -> Batch:
    """Render a saved report again, into a folder or in its place."""
    head = {key: value for key, value in before.document.items() if key not in ("files", "parts")}
    if not before.entries:
        again = f": make it again: {before.document['command']}" if before.document["command"] else ""
        raise InvalidInput(f"{before.path}: writing it was stopped before anything that was found was there{again}")
    saved = {name: before.values(name) for name in before.entries}
    target = before if out is None else ReportFolder(out, before.kind)
    return _render_parts(target, head, target.entries | before.entries, saved, draw)


def _render_parts(
    target: ReportFolder, head: Mapping[str, Any], entries: Mapping[str, Any], saved: Mapping[str, Any], draw: Draw
) -> Batch:
    """Render the parts with new findings, the index and the document.

    If writing the report was stopped before, all its parts are rendered.
    """
    kind, files = target.kind, dict[str, str]()
    if target.unfinished:
        saved = {name: target.values(name) for name in target.entries} | dict(saved)
    below = subreports(target.path)
    links = {name: [one.link_to(name) for one in below if name in one.parts] for name in saved}
    made = draw(part_files, repeat(kind.name), saved, saved.values(), map(entries.get, saved), links.values())
    done = dict(entries)
    for name, (texts, summary) in zip(saved, made, strict=True):
        files |= texts
        done[name] = _part_entry(kind, name, entries[name], summary, texts)
    done = {name: done[name] for name in sorted(done, key=part_order)}

    def part_findings(name: str) -> Any:
        return restore_findings(kind.findings, saved[name] if name in saved else target.values(name))

    index = Index(
        done, head["environment"], _origin_sentence(head["command"]), part_findings, [one.line for one in below]
    )
    first = {} if kind.one_part else _page_files(kind.index_file, kind.index_of(index))
    document = {**head, "files": [kind.results, *first], "parts": done}
    target.check_free([*files, *first, kind.results])
    owned = {kind.results, *first, *(name for entry in done.values() for name in entry["files"])}
    stale = sorted(name for name in target.owned - owned if (target.path / name).is_file())
    data = {name: files[done[name]["data"]] for name in saved}
    meanwhile = {kind.results: target.unfinished_document(document, data)}
    return Batch(target.path, {**files, **first, kind.results: json_text(document)}, tuple(stale), meanwhile)


def part_order(name: str) -> tuple[int, list[tuple[str, float]]]:
    """Return a sort key for parts: shipped scenes first, in their order, then others by name, and by numbers in it."""
    from conrod.scenes import SCENES

    words = re.findall(r"([^\d]*)(\d+(?:\.\d+)?)?", name)
    by_numbers = [(text, float(number or 0.0)) for text, number in words]
    return (list(SCENES).index(name) if name in SCENES else len(SCENES), by_numbers)


def part_files(
    kind_name: str, name: str, values: Any, entry: Mapping[str, Any], elsewhere: Sequence[str]
) -> tuple[dict[str, str], Mapping[str, Any]]:
    """Render a part's files from its saved findings, in any process.

    Returns:
        Files by name, and the part's summary.
    """
    kind = kind_named(kind_name)
    part = Part(name, restore_findings(kind.findings, values), entry["command"], entry["conrod"], elsewhere)
    page = _page_files(kind.page_file(name), kind.page_of(part))
    return {kind.data_file(name): json_text(values), **page}, plain_findings(kind.summary(part.findings))


def _part_entry(
    kind: Kind[Any], name: str, entry: Mapping[str, Any], summary: Mapping[str, Any], texts: Mapping[str, str]
) -> dict[str, Any]:
    own = {key: entry[key] for key in ("title", "command", "conrod")}
    places = {"page": kind.page_file(name), "data": kind.data_file(name), "files": list(texts)}
    return {**own, "summary": summary, **places}


def _page_files(file: str, page: Page) -> dict[str, str]:
    return {**{figure.file: figure.svg() for figure in page.figures}, file: page.text}


def _origin_sentence(command: str | None) -> str:
    if command is None:
        return SEVERAL_COMMANDS
    return f"Reproduced by `{command}`; each page names the command that reproduces it alone."
