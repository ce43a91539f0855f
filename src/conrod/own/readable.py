"""Files that a user names to be read."""

from __future__ import annotations

import os
from pathlib import Path

from conrod.errors import InvalidInput


def check_readable(path: Path) -> None:
    """Refuse what is no file that can be read.

    Raises:
        InvalidInput: says why.
    """
    if not path.exists():
        raise InvalidInput(f"{path}: there is no such file")
    if not path.is_file():
        raise InvalidInput(f"{path}: it is a folder, not a file" if path.is_dir() else f"{path}: it is no regular file")
    if not os.access(path, os.R_OK):
        raise InvalidInput(f"{path}: it cannot be read: permission denied")
