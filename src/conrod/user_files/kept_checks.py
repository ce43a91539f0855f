"""Checks of model files that the ledger keeps: the same bytes, judged by the same software, have the same findings."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

import conrod
from conrod.comparison.plain_values import plain_values
from conrod.engines import environment
from conrod.errors import InvalidInput
from conrod.execution.case import CACHE_VERSION
from conrod.execution.ledger import Ledger
from conrod.execution.local import call_named, call_on_file
from conrod.execution.runner import Runs
from conrod.execution.timing import machine_fingerprint
from conrod.report.folder import restore_findings
from conrod.scenes import Scene
from conrod.user_files.files import model_digest

Found = TypeVar("Found")


def check_or_recall(
    task: str, kind: type[Found], path: Path, *arguments: Any, runs: Runs | None, beside: str = ""
) -> Found:
    """Call a task on a user's model file, or recall its findings about the same bytes.

    Nothing is recalled if the files that the model is made of cannot be told from its text, and nothing that cannot
    be read from the ledger again, value by value.

    Args:
        task: full name of the function, whose module is imported in the process of its call alone.
        path, arguments: as in `call_on_file`.
        kind: class of what the task finds.
        runs: ledger, and whether it is asked; None to call the task here and now, and keep nothing.
        beside: path of another model that the task reads; empty if it reads none.

    Raises:
        InvalidInput: as `call_on_file`; or a ledger that was named cannot be used.
    """
    key = None if runs is None else _key_of(task, path, beside, arguments)
    if runs is None or key is None:
        return _call_now(task, kind, path, arguments)
    kept = None
    try:
        # Reading would make a ledger where there is none, which a refused check is not to leave.
        if runs.ledger_file.exists() and not runs.fresh:
            with Ledger.open_for_reading(runs.ledger_file) as ledger:
                kept = ledger.checked_file(key)
    except InvalidInput:
        if runs.ledger is not None:
            raise
        return _call_now(task, kind, path, arguments)
    if kept is not None:
        with suppress(InvalidInput):  # of values that are no findings
            recalled = restore_findings(kind, kept)
            with runs.progress("checks", "completed") as watcher:
                watcher.on_start(1, 1)
            return recalled
    found = _call_now(task, kind, path, arguments)
    values = plain_values(found)
    # A file that was changed meanwhile may be another one than the task has read.
    if _can_be_restored(kind, values) and _key_of(task, path, beside, arguments) == key:
        with suppress(InvalidInput), Ledger.open(runs.ledger_file) as ledger:
            ledger.keep_checked_file(key, str(path).encode(errors="replace").decode(), values)
    return found


def _call_now(task: str, kind: type[Found], path: Path, arguments: tuple[Any, ...]) -> Found:
    """Call a task on a file in a fresh process, which alone imports it; `kind` is the class of its result."""
    found: Found = call_on_file(call_named, path, task, *arguments)
    return found


def _can_be_restored(kind: type[Any], values: Any) -> bool:
    """Return True if restoring findings from their plain values as JSON changes none of them."""
    try:
        text = json.dumps(values)
        return json.dumps(plain_values(restore_findings(kind, json.loads(text)))) == text
    except (InvalidInput, TypeError, ValueError):
        return False


def _key_of(task: str, path: Path, beside: str, arguments: tuple[Any, ...]) -> str | None:
    """Digest of all inputs of a task on a model file; None if the model's files are not all known."""
    try:
        digests = [model_digest(Path(one)) for one in (path, beside) if str(one)]
    except OSError:  # what cannot be read is for the task to say
        return None
    if None in digests:
        return None
    determining = {
        "cache_version": CACHE_VERSION,
        "task": task,
        "path": str(path),
        "models": digests,
        "arguments": plain_values(arguments),
        "scenes": [one.identity() for one in _flatten(arguments) if isinstance(one, Scene)],
        "environment": {**environment(), "scipy": version("scipy")},
        "conrod": _source_stamps(),
        "machine": machine_fingerprint(),
    }
    return hashlib.sha256(json.dumps(determining, sort_keys=True).encode()).hexdigest()[:32]


def _flatten(arguments: tuple[Any, ...]) -> Iterator[Any]:
    """Yield all arguments, with tuples among them flattened."""
    for one in arguments:
        yield from _flatten(one) if isinstance(one, tuple) else [one]


@cache
def _source_stamps() -> list[tuple[str, int, int]]:
    """Path, size and time of change of each of conrod's files, as a change may alter findings."""
    found, waiting = list[tuple[str, int, int]](), [str(Path(conrod.__file__).parent)]
    while waiting:
        for entry in os.scandir(waiting.pop()):
            if entry.is_dir():
                if entry.name != "__pycache__":
                    waiting.append(entry.path)
            else:
                facts = entry.stat()
                found.append((entry.path, facts.st_size, facts.st_mtime_ns))
    return sorted(found)
