"""A user's file of printed values, and the machines that it names: by name, or as mechanism files beside it."""

from __future__ import annotations

from pathlib import Path

from conrod.errors import InvalidInput
from conrod.own.files import check_readable
from conrod.own.printed.judging import Audited
from conrod.own.printed.user_table import audit_table
from conrod.scenes import Scene
from conrod.scenes.catalogue import scene_named
from conrod.scenes.described_scene import read_scene
from conrod.studies.frame.files import real_path

MECHANISM_FILE = ".toml"
MOST_BYTES = 4 * 1024 * 1024  # 10 000 rows of 400 characters


def audit_file(path: Path) -> Audited:
    """The verdicts on a file.

    Raises:
        InvalidInput: it cannot be read or used; names the file, the row and the field.
    """
    verdicts = audit_table(str(path), _text(path), lambda machine: _scene(machine, path.parent))
    documents = dict.fromkeys(verdict.document for verdict in verdicts)
    title = ", ".join(documents) if str(path) not in documents else f"Printed values of {path.name}"
    return Audited(path.name, title, verdicts)


def _text(path: Path) -> str:
    check_readable(path)
    try:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise InvalidInput(f"{path}: it is too large: at most {MOST_BYTES // 1024**2} MiB are read")
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InvalidInput(f"{path}: it is no text in UTF-8: byte {error.start} cannot be read") from None


def _scene(machine: str, folder: Path) -> Scene:
    """The machine that a row names."""
    if not machine.lower().endswith(MECHANISM_FILE):
        return scene_named(machine)
    home, place = real_path(folder), real_path(folder / machine)
    if Path(machine).is_absolute() or not place.is_relative_to(home):
        raise InvalidInput(f"scene = {machine!r} leads out of the folder of the table: put the mechanism file into it")
    return read_scene(place)
