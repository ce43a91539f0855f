"""Lines of a text file, whatever its encoding: numbered, of bounded length."""

from __future__ import annotations

import codecs
from collections.abc import Iterator
from itertools import count
from pathlib import Path

from conrod.errors import InvalidInput

LONGEST_LINE = 1_000_000  # characters
HEAD = 1 << 16  # bytes that an encoding is derived from
BOMS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
# What other programs save by, and people then rename.
SIGNATURES = {
    b"PK\x03\x04": "a zip archive or an Excel workbook; save the sheet as CSV",
    b"PAR1": "a Parquet file; let its name end in .parquet",
    b"\x1f\x8b": "compressed; unpack it first",
    b"\x89HDF": "an HDF5 file; save the columns as CSV",
    b"MATLAB 5.0": "a MATLAB file; save the columns as CSV",
    b"%PDF": "a PDF file",
}


def encoding_of(path: Path) -> str:
    """The encoding of a text file, from its beginning.

    Raises:
        InvalidInput: the file is empty, or no text.
    """
    with path.open("rb") as file:
        head = file.read(HEAD)
    if not head.strip():
        raise InvalidInput(f"{path}: it is empty")
    for signature, what in SIGNATURES.items():
        if head.startswith(signature):
            raise InvalidInput(f"{path}: it is no table of text but {what}")
    for mark, encoding in BOMS.items():
        if head.startswith(mark):
            return encoding
    if b"\0" in head:
        raise InvalidInput(f"{path}: it is no table of text: it holds zero bytes")
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "cp1252"  # what spreadsheets on Windows write
    return "utf-8"


def lines(path: Path, encoding: str) -> Iterator[tuple[int, str]]:
    """Lines with their numbers from 1, without those that are blank.

    Raises:
        InvalidInput: a line that is too long, or no text.
    """
    with path.open(encoding=encoding) as file:
        for number in count(1):
            try:
                line = file.readline(LONGEST_LINE + 1)
            except UnicodeError:
                raise InvalidInput(f"{path}: behind row {number}: it is no text in {encoding}") from None
            if len(line) > LONGEST_LINE:
                raise InvalidInput(f"{path}: row {number} is longer than {LONGEST_LINE} characters: it is no table")
            if "\0" in line:
                raise InvalidInput(f"{path}: row {number} holds zero bytes: it is no table of text")
            if not line:
                return
            if not line.isspace():
                yield number, line.rstrip("\n")
