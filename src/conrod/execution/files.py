"""Checks of output files and folders that a user names, before any work is done."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Mapping
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.execution.writing import TEMPORARY_PREFIX
from conrod.system import own_path, real_path


def file_to_write(text: str, option: str) -> Path:
    """Check the output file that an option names, and return its path; creates nothing.

    Raises:
        InvalidInput: the file cannot be written, or would replace something that is no output.
    """
    if text.strip() in ("", "-") or text.endswith(("/", os.sep)):
        raise InvalidInput(f"{option} {text!r}: give the name of a file")
    path, real = Path(text), own_path(Path(text))
    if is_special_file(real):
        what = "a folder; give the name of a file" if is_folder(real) else "not a regular file"
        raise InvalidInput(f"cannot write {path}: it is {what}")
    if real.exists() and real.name.lower().endswith(".toml"):
        raise InvalidInput(f"cannot write {path}: it is a mechanism file; give another name")
    if not real.parent.is_dir():
        raise InvalidInput(f"cannot write {path}: there is no folder {path.parent}")
    _check_folder_writable(real.parent, path)
    return path


def files_to_write(given: Mapping[str, str | None], beside: Mapping[str, Path] | None = None) -> dict[str, Path]:
    """Check the output files that options name, and return their paths by option.

    Args:
        given: text that was typed, by option; None where an option was not given.
        beside: other files, which must not be overwritten, by what a user calls them.

    Raises:
        InvalidInput: a file cannot be written, or two names mean one file.
    """
    files = {option: file_to_write(text, option) for option, text in given.items() if text is not None}
    seen = dict(beside or {})
    for name, path in files.items():
        for other, there in seen.items():
            if _same_file(path, there):
                raise InvalidInput(f"{name} {path}: it is the same file as {other}")
        seen[name] = path
    return files


def _same_file(one: Path, other: Path) -> bool:
    # Compared without case: on some systems a.csv is A.csv. A file may have several names of its own, too.
    if str(real_path(one)).casefold() == str(real_path(other)).casefold():
        return True
    return one.exists() and other.exists() and one.samefile(other)


def folder_to_write(text: str, option: str) -> Path:
    """Check the output folder that an option names, and return its path.

    Raises:
        InvalidInput: the folder can neither be made nor written into.
    """
    if text.strip() in ("", "-"):
        raise InvalidInput(f"{option} {text!r}: give the name of a folder")
    check_writable_folder(Path(text))
    return Path(text)


def check_writable_folder(path: Path) -> None:
    """Refuse a path where no folder can be created or written; creates nothing.

    Raises:
        InvalidInput: says why.
    """
    real = own_path(path)
    existing = next(p for p in (real, *real.parents) if os.path.lexists(p))
    if not existing.is_dir():
        raise InvalidInput(f"cannot write into {path}: {existing} is a file, not a folder")
    _check_folder_writable(existing, path)


def is_folder(path: Path) -> bool:
    """True if this is a folder itself, not a link to one."""
    return path.is_dir() and not path.is_symlink()


def is_special_file(path: Path) -> bool:
    """True if the path exists and is not a regular file: a folder, link, device or pipe."""
    try:
        return not stat.S_ISREG(path.lstat().st_mode)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError as error:
        raise InvalidInput(f"cannot write {path.name}: {error.strerror or error}") from None


def _check_folder_writable(folder: Path, wanted: Path) -> None:
    try:
        with tempfile.TemporaryFile(dir=folder, prefix=TEMPORARY_PREFIX):
            pass
    except OSError as error:
        raise InvalidInput(f"cannot write {wanted}: {error.strerror or error} in {folder}") from None
