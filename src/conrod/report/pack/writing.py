"""A pack on the disk: a folder, or one zip archive; written whole or not at all."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from conrod.errors import InvalidInput
from conrod.report.folder import check_own_folder, holds_document
from conrod.report.pack.contents import DRAWING, FIGURES, KEYS, MACHINE, PAGES, PARAMETERS, zipped
from conrod.studies.frame.files import Batch, file_to_write, folder_to_write, single

ARCHIVE = ".zip"


def pack_to_write(text: str | None) -> Path:
    """The folder or archive that a user names, refused where anything but an earlier pack would be replaced.

    Raises:
        InvalidInput: none is named, or it cannot be written.
    """
    if text is None:
        raise InvalidInput("--format pack is a folder or an archive: name it with -o DIR or -o FILE.zip")
    if text.lower().endswith(ARCHIVE):
        return file_to_write(text, "-o")
    folder = folder_to_write(text, "-o")
    own = holds_document(folder / PARAMETERS, KEYS)
    check_own_folder(folder, (*PAGES, MACHINE), (DRAWING,), FIGURES, own, "of a pack")
    return folder


def pack_batch(files: Mapping[str, str | bytes], place: Path) -> Batch:
    """What is to be written."""
    if place.name.lower().endswith(ARCHIVE):
        return single(place, zipped(files, place.name[: -len(ARCHIVE)]))
    return Batch(place, files)
