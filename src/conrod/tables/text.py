"""Lines of a text file, whatever its encoding: numbered, of bounded length."""

from __future__ import annotations

import codecs
from collections.abc import Iterator
from pathlib import Path

from conrod.errors import InvalidInput

LONGEST_LINE = 1_000_000  # characters
BLOCK = 1 << 21  # characters read at a time
HEAD = 1 << 16  # bytes that an encoding is told from
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
    """Lines with their numbers from 1, without those that are blank; raises as `blocks`."""
    for first, block in blocks(path, encoding):
        yield from ((number, line) for number, line in enumerate(block, first) if line.strip())


def blocks(path: Path, encoding: str) -> Iterator[tuple[int, list[str]]]:
    """All lines in blocks of bounded size, each block with the number of its first line.

    Raises:
        InvalidInput: a line that is too long, or no text.
    """
    number, rest = 1, ""
    with path.open(encoding=encoding) as file:
        while True:
            try:
                text = file.read(BLOCK)
            except UnicodeError:
                raise InvalidInput(f"{path}: behind row {number}: it is no text in {encoding}") from None
            # Only by the ends of lines, not by all that str.splitlines() takes for one.
            block = (rest + text).split("\n")
            rest = block.pop() if text else ""
            _check(path, number, block, rest)
            if "\0" in text:
                zero = next((k for k, line in enumerate(block) if "\0" in line), len(block))
                raise InvalidInput(f"{path}: row {number + zero} holds zero bytes: it is no table of text")
            if block:
                yield number, block
            number += len(block)
            if not text:
                return


def _check(path: Path, first: int, block: list[str], rest: str) -> None:
    longest = max(map(len, (*block, rest)))
    if longest > LONGEST_LINE:
        number = first + [len(line) for line in (*block, rest)].index(longest)
        raise InvalidInput(f"{path}: row {number} is longer than {LONGEST_LINE} characters: it is no table")
