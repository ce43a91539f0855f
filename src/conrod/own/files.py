"""Files that a user names: whether they can be read, and the files that a MuJoCo model consists of."""

from __future__ import annotations

import os
import re
from pathlib import Path

from conrod.errors import InvalidInput

NAMED = re.compile(r"""\sfile\s*=\s*(["'])(.+?)\1""")
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


def files_of_model(path: Path) -> tuple[Path, ...]:
    """A model file, those that it includes, and its meshes, textures and the like, as far as they are there.

    They are read as text. MuJoCo looks for what is included beside the including file and beside the model file, for
    assets in the folders that the compiler is given, too.
    """
    found, names, waiting = {path: None}, list[str](), [path]
    folders = {path.parent}
    while waiting:
        file = waiting.pop()
        if not file.is_file() or file.suffix.lower() == ".mjb":
            continue
        text = file.read_text(encoding="utf-8", errors="replace")
        folders |= {file.parent, *(path.parent / match[2] for match in FOLDERS.finditer(text))}
        names += [match[2] for match in NAMED.finditer(text)]
        every = (folder / name for folder in sorted(folders) for name in names)
        new = [there for there in every if there.is_file() and there not in found]
        found |= dict.fromkeys(new)
        waiting += dict.fromkeys(there for there in new if there.suffix.lower() in TEXT)
    return tuple(found)


def as_outputs_must_not_be(path: Path) -> dict[str, Path]:
    """The files of a model by what a user calls them, for `conrod.studies.frame.files.check_apart`."""
    first, *others = files_of_model(path)
    return {"the model": first} | {f"{other}, which the model is made of": other for other in others}
