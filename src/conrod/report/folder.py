"""What a user writes beside a report must be none of the report's own files.

The folder of a report, and what in it must not be replaced by one.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput
from conrod.studies.frame.files import is_folder, is_no_file, real_path


def check_beside(file: Path, folder: Path, names: Iterable[str]) -> None:
    """Refuse a file that is one of those that a report in a folder consists of, or stands in the folder's way.

    Args:
        names: of the report's files, in the folder.

    Raises:
        InvalidInput: names the file.
    """
    home, wanted = real_path(folder), real_path(file)
    # Compared without case: on some systems readme.md is README.md.
    if str(wanted).casefold() in {str(home / name).casefold() for name in names}:
        raise InvalidInput(f"cannot write {file}: the report in {folder} has a file of that name")
    if wanted in (home, *home.parents):
        raise InvalidInput(f"cannot write {file}: it is where the folder {folder} has to be")


def check_own_folder(
    directory: Path, pages: Sequence[str], drawn: Iterable[str], figures: str, is_own: bool, kind: str
) -> None:
    """Refuse a folder in which a report would replace what is not its own.

    Args:
        pages, drawn: names of the report's files in the folder; those drawn lie in its folder of figures.
        figures: name of that.
        is_own: whether the folder already holds a report of the kind.
        kind: of report, for the error.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    place = directory / figures
    if place.is_symlink() or (place.exists() and not is_folder(place)):
        raise InvalidInput(f"cannot write into {directory}: {figures} in it is not a folder")
    for name in (*pages, *drawn):
        if is_no_file(directory / name):
            raise InvalidInput(f"cannot write into {directory}: {name} in it is not a regular file")
    for name in () if is_own else pages:
        if (directory / name).exists():
            raise InvalidInput(f"cannot write into {directory}: it holds a {name} that is not {kind}")


def document_in(file: Path) -> Any:
    """What a report's JSON file holds.

    Raises:
        OSError: it cannot be read.
        ValueError: it is no JSON.
    """
    return json.loads(file.read_text(encoding="utf-8"))


def holds_document(file: Path, keys: set[str]) -> bool:
    """Whether a file is a report's, which is known by its keys."""
    try:
        document = document_in(file)
    except (OSError, ValueError):
        return False
    return isinstance(document, dict) and keys <= document.keys()
