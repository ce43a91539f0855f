"""Files that a user names: whether they can be read, which files a model consists of, their hashes and sources."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import distribution
from pathlib import Path

from conrod.errors import InvalidInput, no_such_file
from conrod.scenes import SCENES, catalogue_names, dynamics_names

FILE_ATTRIBUTE = re.compile(r"""\sfile\s*=\s*(["'])(.+?)\1""")
COMMENT = re.compile("<!--.*?-->", re.DOTALL)
FOLDER_ATTRIBUTE = re.compile(r"""\s(?:meshdir|texturedir|assetdir)\s*=\s*(["'])(.*?)\1""")
TEXT_SUFFIXES = (".xml", ".mjcf", ".urdf")


def check_readable(path: Path) -> None:
    """Refuse a path that is not a readable regular file.

    Raises:
        InvalidInput: says why.
    """
    if not path.exists():
        raise no_such_file(path)
    if not path.is_file():
        raise InvalidInput(f"{path}: it is a folder, not a file" if path.is_dir() else f"{path}: it is no regular file")
    if not os.access(path, os.R_OK):
        raise InvalidInput(f"{path}: it cannot be read: permission denied")


def check_model_readable(path: Path, verb: str) -> None:
    """Refuse a path that is no readable model; of a scene's name say how to have its model.

    Args:
        verb: of the command line that takes models, for what to type.

    Raises:
        InvalidInput: says why.
    """
    name = str(path)
    if not path.exists() and name in (*SCENES, *catalogue_names(), *dynamics_names()):
        model = f"{name}.xml"
        typed = f"conrod export {name} --format mjcf -o {model} && conrod {verb} {model}"
        raise InvalidInput(f"{name}: it is a scene, and {verb} takes a model's file: {typed}")
    check_readable(path)


@contextmanager
def name_file_in_errors(path: Path) -> Iterator[None]:
    """Prefix every InvalidInput raised within with the name of the file."""
    try:
        yield
    except InvalidInput as error:
        raise error if str(error).startswith(str(path)) else InvalidInput(f"{path}: {error}") from None


def model_files(path: Path) -> tuple[Path, ...]:
    """A model file with the files it includes and its meshes, textures and other assets that exist.

    They are read as text. MuJoCo looks for what is included beside the including file and beside the model file, for
    assets in the folders that the compiler is given, too.

    Raises:
        InvalidInput: a file is a pipe or a device, which has no end.
    """
    found, names, waiting = {path: None}, list[str](), [path]
    folders = {path.parent}
    while waiting:
        file = waiting.pop()
        if not file.is_file() or file.suffix.lower() == ".mjb":
            continue
        text = COMMENT.sub("", file.read_text(encoding="utf-8", errors="replace"))
        folders |= {file.parent, *(path.parent / match[2] for match in FOLDER_ATTRIBUTE.finditer(text))}
        names += [match[2] for match in FILE_ATTRIBUTE.finditer(text)]
        every = [there for folder in sorted(folders) for name in names if (there := folder / name).exists()]
        if endless := [there for there in every if not (there.is_file() or there.is_dir())]:
            raise InvalidInput(f"{file}: {endless[0]} is no regular file")
        # A file that includes itself can do so under ever longer names.
        real = {there.resolve() for there in found}
        new = {there.resolve(): there for there in every if there.is_file() and there.resolve() not in real}
        found |= dict.fromkeys(new.values())
        waiting += [there for there in new.values() if there.suffix.lower() in TEXT_SUFFIXES]
    return tuple(found)


# What in a model's text says that MuJoCo reads files which cannot be found by their names in it.
UNFOLLOWED = re.compile(r"<!DOCTYPE|<!ENTITY|<plugin|<extension|\sstrippath\s*=|<!\[CDATA\[")
FILE_NAMES = re.compile(r"""\sfile[a-z]*\s*=\s*(["'])(.*?)\1""")


def model_digest(path: Path) -> str | None:
    """Digest of a model file and all files that it names; None if they are not all found."""
    found, names = model_files(path), set[str]()
    real, digest = {there.resolve() for there in found}, hashlib.sha256()
    folders = {there.parent for there in found}
    for file in found:
        content = file.read_bytes()
        digest.update(f"{os.path.relpath(file, path.parent)} {len(content)} ".encode(errors="surrogateescape"))
        digest.update(content)
        if file.suffix.lower() == ".mjb":
            continue
        if file == path or file.suffix.lower() in TEXT_SUFFIXES:
            text = COMMENT.sub("", content.decode(errors="replace"))
            names |= {match[2] for match in FILE_NAMES.finditer(text)}
            folders |= {file.parent, *(path.parent / match[2] for match in FOLDER_ATTRIBUTE.finditer(text))}
            if UNFOLLOWED.search(text):
                return None
    known = all(any((folder / name).resolve() in real for folder in folders) for name in names)
    return digest.hexdigest() if known else None


def protected_model_files(path: Path) -> dict[str, Path]:
    """A model's files by description, which no output may overwrite (`conrod.execution.files.files_to_write`)."""
    first, *others = model_files(path)
    return {f"the model {first}": first} | {f"{other}, which the model is made of": other for other in others}


# -- pedigree: hashes of what was read and of the software installed, with sources -------------------------------------


# A first comment of a text file, in which whoever made it says where it is from.
FIRST_COMMENT = re.compile(r"\s*(?:<!--(.*?)-->|[#%]+\s*([^\n]*))", re.DOTALL)
MAX_HEAD_CHARACTERS, MAX_SOURCE_CHARACTERS = 4096, 160  # characters of a file that are looked at, and of a source
INSTALLER_FILE = re.compile(r"\.\./|.*\.dist-info/(INSTALLER|REQUESTED|direct_url\.json)")


def sha256(content: bytes) -> str:
    """SHA-256 of bytes in hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()


def stated_source(content: bytes) -> str:
    """Text of a file's first comment; empty if the file begins otherwise."""
    found = FIRST_COMMENT.match(content[:MAX_HEAD_CHARACTERS].decode("utf-8", errors="replace"))
    said = " ".join((found[1] or found[2] or "").split()) if found else ""
    return said if len(said) <= MAX_SOURCE_CHARACTERS else said[:MAX_SOURCE_CHARACTERS].rpartition(" ")[0] + " .."


def package_hash(name: str) -> tuple[str, str, str]:
    """Version of an installed distribution, SHA-256 of its content, and the content hashed, in words.

    Hashed is the wheel's RECORD, which lists the SHA-256 of each file: sorted, and without files that an installer
    adds, so that the hash is the same on every machine. Of an installed source tree the files are hashed.
    """
    found = distribution(name)
    if json.loads(found.read_text("direct_url.json") or "{}").get("dir_info", {}).get("editable"):
        root = Path(__file__).parents[1]
        files = {p.relative_to(root).as_posix(): p for p in root.rglob("*") if p.is_file() and p.suffix != ".pyc"}
        lines = [f"{path},{sha256(files[path].read_bytes())}" for path in sorted(files)]
        return found.version, sha256("\n".join(lines).encode()), "source tree"
    lines = (found.read_text("RECORD") or "").splitlines()
    lines = sorted(line for line in lines if ",sha256=" in line and not INSTALLER_FILE.match(line))
    return found.version, sha256("\n".join(lines).encode()), "wheel's RECORD" if lines else "nothing: it has no RECORD"
