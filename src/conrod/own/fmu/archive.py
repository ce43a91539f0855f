"""The archive that an FMU is, unpacked within limits: nothing outside its folder, no bomb, no XML with entities."""

from __future__ import annotations

import lzma
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.parsers import expat

from conrod.errors import InvalidInput

DESCRIPTION = "modelDescription.xml"
# Models of whole plants describe 200 000 variables in some 60 MB, and unpack to some hundred.
MOST_FILES, MOST_BYTES, MOST_DESCRIPTION = 100_000, 1 << 30, 1 << 27
BROKEN = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, ValueError, RuntimeError)  # the last: encrypted


def unpack(path: Path, folder: Path, wanted: Sequence[str]) -> tuple[str, ...]:
    """Unpack the model description and some folders of an FMU, "binaries/linux64/"; return the names of all its files.

    Raises:
        InvalidInput: it is no such archive, or one that was made to do harm.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            entries = {entry.filename: entry.file_size for entry in archive.infolist()}
            _check_entries(entries)
            named = [name for name in entries if name == DESCRIPTION or name.startswith(tuple(wanted))]
            archive.extractall(folder, members=named)
    except InvalidInput:
        raise
    except BROKEN as error:
        what = "it is no FMU: no zip archive" if not zipfile.is_zipfile(path) else f"its archive is damaged: {error}"
        raise InvalidInput(what) from None
    except OSError as error:
        raise InvalidInput(f"it cannot be unpacked: {error.strerror}") from None
    _check_description((folder / DESCRIPTION).read_bytes())
    return tuple(entries)


def _check_entries(entries: dict[str, int]) -> None:
    for name in entries:
        if name.startswith("/") or "\\" in name or ":" in name or ".." in name.split("/"):
            raise InvalidInput(f"its archive names {name!r}, which leads out of its folder")
    if DESCRIPTION not in entries:
        raise InvalidInput(f"it is no FMU: it has no {DESCRIPTION}")
    if entries[DESCRIPTION] > MOST_DESCRIPTION:
        raise InvalidInput(f"its {DESCRIPTION} has {entries[DESCRIPTION]} bytes: at most {MOST_DESCRIPTION} are read")
    total = sum(entries.values())
    if len(entries) > MOST_FILES or total > MOST_BYTES:
        raise InvalidInput(f"it unpacks to {len(entries)} files, {total} bytes: at most {MOST_FILES}, {MOST_BYTES} are")


def _check_description(content: bytes) -> None:
    """Refuse XML that is broken or declares entities, which FMI has no use for and which may grow without end."""
    parser = expat.ParserCreate()

    def declared(*_: Any) -> None:
        raise InvalidInput(f"its {DESCRIPTION} has a document type or entities, which FMI does not use")

    parser.StartDoctypeDeclHandler = declared
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        raise InvalidInput(f"its {DESCRIPTION} is no XML: {error}") from None
