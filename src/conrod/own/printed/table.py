"""A user's table of printed values in CSV, each row tied to a machine, judged by its exact motion.

A row's verdict rests on the other rows too: a cause is systematic where it reproduces a quantity's values as a whole.
The format is described in docs/audit.md. Nothing in a table is executed; a path in one cannot lead out of its folder.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from functools import cache
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.own.encodings import decoded
from conrod.own.files import check_readable, of_file
from conrod.own.printed.row_verdicts import verdicts_on
from conrod.own.printed.rows import Row, read_rows
from conrod.own.printed.verdicts import Audited, Verdict
from conrod.scenes import Scene, scene_named
from conrod.scenes.described_scene import read_scene
from conrod.studies.frame.writing import real_path

MOST_BYTES = 1024 * 1024  # 20 000 rows of 50 characters


def audit_file(path: Path) -> Audited:
    """The verdicts on a file; machines are named, or mechanism files beside it.

    Raises:
        InvalidInput: it cannot be read or used; names the file, the row and the field.
    """
    check_readable(path)
    if path.stat().st_size > MOST_BYTES:
        raise InvalidInput(f"{path}: it is too large: at most {MOST_BYTES // 1024**2} MiB are read")
    with of_file(path):
        text, _ = decoded(path.read_bytes())
    verdicts = audit_table(str(path), text, lambda machine: _scene(machine, path.parent))
    return Audited(path.name, f"Printed values of {path.name}", verdicts)


def _scene(machine: str, folder: Path) -> Scene:
    """The machine that a row names."""
    if not machine.lower().endswith(".toml"):
        return scene_named(machine)
    home, place = real_path(folder), real_path(folder / machine)
    if Path(machine).is_absolute() or not place.is_relative_to(home):
        raise InvalidInput(f"scene = {machine!r} leads out of the folder of the table: put the mechanism file into it")
    return read_scene(place)


def audit_table(document: str, text: str, scene_of: Callable[[str], Scene] = scene_named) -> tuple[Verdict, ...]:
    """A verdict on every row.

    Args:
        document: what the table is called in errors and in the verdicts.
        text: of the table.
        scene_of: finds the machine that a row names.

    Raises:
        InvalidInput: the table or a row cannot be used; names the row and what is wanted.
    """
    groups: dict[tuple[object, ...], list[Row]] = {}
    try:
        for row in read_rows(text.splitlines(), cache(scene_of)):
            groups.setdefault(row.group, []).append(row)
        if not groups:
            raise InvalidInput("no rows below the heading")
        verdicts = [verdict for rows in groups.values() for verdict in verdicts_on(document, rows)]
    except (InvalidInput, csv.Error) as error:
        raise InvalidInput(f"{document}: {error}") from None
    return tuple(sorted(verdicts, key=lambda verdict: verdict.line))
