"""A user's CSV table of printed values, each row naming its machine, judged by the exact motion.

A row's verdict rests on the other rows too: a cause is systematic where it reproduces a quantity's values as a whole.
The format is described in docs/audit.md. Nothing in a table is executed; a path in one cannot lead out of its folder.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.models.printed.column_slips import other_speed
from conrod.models.printed.row_verdicts import check_span, verdicts_on
from conrod.models.printed.rows import PrintedRow, read_rows
from conrod.models.printed.verdicts import AuditedDocument, PrintedVerdict
from conrod.scenes import Scene, scene_named
from conrod.scenes.described_scene import read_scene
from conrod.system import real_path
from conrod.user_files.encodings import decode_text
from conrod.user_files.files import check_readable, name_file_in_errors

MAX_TABLE_BYTES = 1024 * 1024  # 20 000 rows of 50 characters


def audit_file(path: Path) -> AuditedDocument:
    """Judge the printed values in a file; its rows name built-in machines or mechanism files of its folder.

    Raises:
        InvalidInput: the file cannot be read or used; names file, row and field.
    """
    check_readable(path)
    if path.stat().st_size > MAX_TABLE_BYTES:
        raise InvalidInput(f"{path}: it is too large: at most {MAX_TABLE_BYTES // 1024**2} MiB are read")
    with name_file_in_errors(path):
        text, _ = decode_text(path.read_bytes())
    verdicts = audit_table(str(path), text, lambda machine: _scene(machine, path.parent))
    return AuditedDocument(path.name, f"Printed values of {path.name}", verdicts)


def _scene(machine: str, folder: Path) -> Scene:
    """The machine that a row names: a built-in one, or a mechanism file in the table's folder."""
    if not machine.lower().endswith(".toml"):
        return scene_named(machine)
    home, place = real_path(folder), real_path(folder / machine)
    if Path(machine).is_absolute() or not place.is_relative_to(home):
        raise InvalidInput(f"scene = {machine!r} leads out of the folder of the table: put the mechanism file into it")
    return read_scene(place)


def audit_table(document: str, text: str, scene_of: Callable[[str], Scene] = scene_named) -> tuple[PrintedVerdict, ...]:
    """Judge every row of a table of printed values.

    Args:
        document: name of the table in errors and in the verdicts.
        text: content of the table.
        scene_of: finds the machine that a row names.

    Raises:
        InvalidInput: the table or a row cannot be used; names the row and what is wanted.
    """
    groups: dict[tuple[object, ...], list[PrintedRow]] = {}
    try:
        for row in read_rows(text.splitlines(), cache(scene_of)):
            groups.setdefault(row.group, []).append(row)
        if not groups:
            raise InvalidInput("no rows below the heading")
        verdicts = [verdict for columns in _machines(groups).values() for verdict in _verdicts(document, columns)]
    except (InvalidInput, csv.Error) as error:
        raise InvalidInput(f"{document}: {error}") from None
    return tuple(sorted(verdicts, key=lambda verdict: verdict.line))


def _machines(
    groups: Mapping[tuple[object, ...], list[PrintedRow]],
) -> Mapping[tuple[object, ...], list[list[PrintedRow]]]:
    """Collect the columns of each machine with one set of parameters, in the order of the table."""
    machines: dict[tuple[object, ...], list[list[PrintedRow]]] = {}
    for (scene, parameters, *_), rows in groups.items():
        machines.setdefault((scene, parameters), []).append(rows)
    return machines


def _verdicts(document: str, columns: Sequence[Sequence[PrintedRow]]) -> Iterator[PrintedVerdict]:
    """Judge the columns of one machine, which one speed may explain together."""
    for rows in columns:
        check_span(rows)
    speed = other_speed(columns)
    for rows in columns:
        yield from verdicts_on(document, rows, speed)
