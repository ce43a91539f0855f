"""Files that a user names: whether they can be read, and the files that a MuJoCo model consists of."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from conrod.errors import InvalidInput

NAMED = re.compile(r"""\sfile\s*=\s*(["'])(.+?)\1""")
COMMENT = re.compile("<!--.*?-->", re.DOTALL)
FOLDERS = re.compile(r"""\s(?:meshdir|texturedir|assetdir)\s*=\s*(["'])(.*?)\1""")
TEXT = (".xml", ".mjcf", ".urdf")


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


@contextmanager
def of_file(path: Path) -> Iterator[None]:
    """Within it, whatever cannot be used is said with the file's name before it."""
    try:
        yield
    except InvalidInput as error:
        raise error if str(error).startswith(str(path)) else InvalidInput(f"{path}: {error}") from None


def files_of_model(path: Path) -> tuple[Path, ...]:
    """A model file, those that it includes, and its meshes, textures and the like, as far as they are there.

    They are read as text. MuJoCo looks for what is included beside the including file and beside the model file, for
    assets in the folders that the compiler is given, too.

    Raises:
        InvalidInput: one of them is a pipe or a device, which has no end.
    """
    found, names, waiting = {path: None}, list[str](), [path]
    folders = {path.parent}
    while waiting:
        file = waiting.pop()
        if not file.is_file() or file.suffix.lower() == ".mjb":
            continue
        text = COMMENT.sub("", file.read_text(encoding="utf-8", errors="replace"))
        folders |= {file.parent, *(path.parent / match[2] for match in FOLDERS.finditer(text))}
        names += [match[2] for match in NAMED.finditer(text)]
        every = [there for folder in sorted(folders) for name in names if (there := folder / name).exists()]
        if endless := [there for there in every if not (there.is_file() or there.is_dir())]:
            raise InvalidInput(f"{file}: {endless[0]} is no regular file")
        # A file that includes itself can do so under ever longer names.
        real = {there.resolve() for there in found}
        new = {there.resolve(): there for there in every if there.is_file() and there.resolve() not in real}
        found |= dict.fromkeys(new.values())
        waiting += [there for there in new.values() if there.suffix.lower() in TEXT]
    return tuple(found)


def as_outputs_must_not_be(path: Path) -> dict[str, Path]:
    """The files of a model by what a user calls them, for `conrod.studies.frame.files.files_to_write`."""
    first, *others = files_of_model(path)
    return {"the model": first} | {f"{other}, which the model is made of": other for other in others}
