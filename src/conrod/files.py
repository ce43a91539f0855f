"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from conrod.errors import InvalidInput


def check_writable_file(path: Path) -> None:
    """Refuse a path that a file cannot be written to, before any work is done.

    Raises:
        InvalidInput: says why.
    """
    if path.is_dir():
        raise InvalidInput(f"cannot write {path}: it is a folder; give the name of a file")
    if not path.parent.is_dir():
        raise InvalidInput(f"cannot write {path}: there is no folder {path.parent}")
    _try_folder(path.parent, path)


def check_writable_folder(path: Path) -> None:
    """Refuse a path that a folder cannot be made at or written in, before any work is done; makes nothing.

    Raises:
        InvalidInput: says why.
    """
    existing = next(p for p in (path, *path.absolute().parents) if p.exists())
    if not existing.is_dir():
        raise InvalidInput(f"cannot write into {path}: {existing} is a file, not a folder")
    _try_folder(existing, path)


def _try_folder(folder: Path, wanted: Path) -> None:
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InvalidInput(f"cannot write {wanted}: {error.strerror or error} in {folder}") from None


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file whole or not at all: into a temporary neighbour first, then in place of the old one."""
    data = content.encode() if isinstance(content, str) else content
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
        # A temporary file is private; the file itself gets the rights that any new file gets.
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
