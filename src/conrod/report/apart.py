"""What a user writes beside a report must be none of the report's own files."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.files import real_path


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
