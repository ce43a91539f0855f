"""The files that a user's MJCF consists of, so that nothing is written over them; they are read as text."""

from __future__ import annotations

import re
from pathlib import Path

NAMED = re.compile(r"""\sfile\s*=\s*(["'])(.+?)\1""")
FOLDERS = re.compile(r"""\s(?:meshdir|texturedir|assetdir)\s*=\s*(["'])(.*?)\1""")
TEXT = (".xml", ".mjcf", ".urdf")


def files_of_model(path: Path) -> tuple[Path, ...]:
    """A model file, those that it includes, and its meshes, textures and the like, as far as they are there.

    MuJoCo looks for what is included beside the including file and beside the model file, for assets in the folders
    that the compiler is given, too.
    """
    found: dict[Path, None] = {path: None}
    folders, waiting = {path.parent}, [path]
    names: list[str] = []
    while waiting:
        file = waiting.pop()
        if not file.is_file() or file.suffix.lower() == ".mjb":
            continue
        text = file.read_text(encoding="utf-8", errors="replace")
        folders |= {file.parent, *(path.parent / match[2] for match in FOLDERS.finditer(text))}
        names += [match[2] for match in NAMED.finditer(text)]
        for there in _present(folders, names):
            if there not in found:
                found[there] = None
                if there.suffix.lower() in TEXT:
                    waiting.append(there)
    return tuple(found)


def _present(folders: set[Path], names: list[str]) -> list[Path]:
    every = (folder / name for folder in sorted(folders) for name in names)
    return [there for there in every if there.is_file()]


def as_outputs_must_not_be(path: Path) -> dict[str, Path]:
    """The files of a model by what a user calls them, for `conrod.studies.frame.files.check_apart`."""
    first, *others = files_of_model(path)
    return {"the model": first} | {f"{other}, which the model is made of": other for other in others}
